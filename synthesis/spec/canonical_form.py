"""The canonical form of a specification: plain JSON, every number exact text; what a certificate carries and hashes.

A canonical specification is itself a valid specification (JSON is YAML), so one reader judges both.
"""

from __future__ import annotations

import hashlib
import json
from fractions import Fraction
from typing import Any

from ..errors import InputError, Location
from .exact import number_text
from .load import build_spec
from .model import Section, Spec
from .tree import MAX_DEPTH, Mapping, Node, Scalar, Sequence, joined


def canonical(spec: Spec) -> dict[str, object]:
    """The specification as JSON types: numbers as text in lowest terms, absent options null (younger ones: no key)."""
    return _section(spec)


def canonical_json(document: object) -> bytes:
    """The one byte string of a JSON document: sorted keys, no spaces, ASCII."""
    text = json.dumps(document, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.encode("ascii")


def spec_sha256(spec: Spec) -> str:
    """SHA-256 of the canonical JSON, in hexadecimal."""
    return hashlib.sha256(canonical_json(canonical(spec))).hexdigest()


def from_canonical(document: dict[str, object], file: str = "<certificate>") -> Spec:
    """The specification of a canonical document; `file` names it in errors.

    Raises:
        InputError: the document is not a specification, or not in canonical form.
    """
    spec = build_spec(_tree(document, Location(file), 0))
    if canonical_json(canonical(spec)) != canonical_json(document):
        raise InputError("expected a specification in canonical form; write it with `canonical`", Location(file))
    return spec


def _section(section: Section) -> dict[str, object]:
    return {key: _plain(item) for key, item in section if item is not None or key not in section.absent_when_none}


def _plain(value: Any) -> object:
    if isinstance(value, Fraction):
        return number_text(value)
    if isinstance(value, Section):
        return _section(value)
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value


def _tree(value: object, where: Location, depth: int) -> Node:
    """JSON types as the tree the YAML reader would give, without lines and columns."""
    key = where.key
    if depth > MAX_DEPTH:
        raise InputError(f"expected at most {MAX_DEPTH} nested levels; found more", where)
    if isinstance(value, dict):
        children = {str(name): (Location(where.file, key=joined(key, str(name))), item) for name, item in value.items()}
        return Mapping({name: (at, _tree(item, at, depth + 1)) for name, (at, item) in children.items()}, where)
    if isinstance(value, list):
        places = [Location(where.file, key=f"{key or ''}[{index}]") for index in range(len(value))]
        return Sequence(tuple(_tree(item, at, depth + 1) for item, at in zip(value, places, strict=True)), where)
    if value is None:
        return Scalar("null", True, where)
    if isinstance(value, str) or type(value) is int:
        return Scalar(str(value), False, where)
    raise InputError(f"expected exact text; found {value!r:.40}", where)
