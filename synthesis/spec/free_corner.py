"""A free corner and the one found: the specification that is proven, and how it is compared with the one asked for.

`filters: {force: free}` leaves the corner of F to the search. Its result *resolves* the specification: the corner
stands where `free` stood, as a number of six digits. Whatever follows the search (proof, certificate, checker,
simulation, report, export) knows that specification only, and so does the digest `spec_sha256` in a certificate: it
is that of the specification with the number. The digest of the one with `free` is never stored beside a proof; a
certificate belongs to it if both are the same once the certificate's own corner, a positive number, is put in the
place of `free`. Everything else is compared as it stands: a corner that was asked for as a number has to be that one.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

from ..errors import InputError
from .exact import parse_number
from .filters import GIVEN
from .model import FREE, Spec


def resolved(spec: Spec, corner: Fraction | None) -> Spec:
    """The specification with `corner` [rad/s] in the place of a free one; as it is where none is free.

    Raises: InputError for a free corner without a number, because no search has found one.
    """
    controller = spec.controller
    if controller.filters.force != FREE:
        return spec
    if corner is None:
        raise InputError(f"controller.filters.force: expected an angular frequency > 0; found free: {GIVEN}")
    filters = controller.filters.model_copy(update={"force": corner})
    return spec.model_copy(update={"controller": controller.model_copy(update={"filters": filters})})


def as_certified(asked: dict[str, Any], certified: dict[str, Any]) -> dict[str, Any]:
    """A canonical specification, with the corner of a certificate's one in the place of `free`: to compare the two.

    Nothing but a positive number takes that place: without one `free` stays, and differs.
    """
    filters = asked["controller"].get("filters") or {}
    corner = (certified["controller"].get("filters") or {}).get("force")
    if filters.get("force") != FREE or not _is_positive(corner):
        return asked
    found: dict[str, Any] = json.loads(json.dumps(asked))
    found["controller"]["filters"]["force"] = corner
    return found


def _is_positive(corner: object) -> bool:
    try:
        return isinstance(corner, str) and parse_number(corner) > 0
    except ValueError:
        return False
