"""From measured frequency responses to a nominal model and a weight that covers every one of them.

The package can be called: `identify(responses, kind="load", beyond="hold")`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from .identified import Beyond, Identified, Kind, identify
from .records import read_files, record_of
from .written import specification

__all__ = ["Identified", "from_responses", "identify", "read_files", "record_of", "specification"]


def from_responses(responses: Sequence[Any], *, kind: Kind, beyond: Beyond, **options: Any) -> Identified:
    """A nominal model and a weight that covers every measured response; `robimp identify`.

    responses: CSV files, `control.FRD` objects with frequencies in rad/s, or records of `record_of`, which may
    have an amplitude and coherences. kind: responses of a load `θ/τ_int` or of an actuator's torque. beyond: |Δ|
    (below, above) the measured band, or `hold`. options: amplitude, exclude, order, poles, zeros, as for
    `robimp.synthesis.identify.identify`.

    Raises: InputError for files that cannot be read, and for nothing usable among the records.

    >>> import control, numpy as np
    >>> from robimp.synthesis import identify
    >>> joints = [control.tf([1], [inertia, 0.2, 1]) for inertia in (0.028, 0.03, 0.032)]
    >>> identify([control.frd(joint, np.geomspace(1, 50, 40)) for joint in joints], kind="load", beyond="hold")
    <Identified load from 3 records: |Δ| up to 0.0717, 0 left out>
    """
    files = [Path(each) for each in responses if isinstance(each, str | Path)]
    others = [each for each in responses if not isinstance(each, str | Path)]
    named = [record_of(each, f"response {k}") if hasattr(each, "issiso") else each for k, each in enumerate(others)]
    return identify([*read_files(files), *named], kind=kind, beyond=beyond, **options)


class _Identify(ModuleType):
    """The package is its own main function, for `synthesis` hands it on under the folder's name."""

    __call__ = staticmethod(from_responses)


sys.modules[__name__].__class__ = _Identify
