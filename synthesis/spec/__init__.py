"""YAML 1.2 to `Spec`: exact numbers, units, and errors that say where.

Names load when they are first used: whoever only needs the types does not pay for the YAML reader.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .canonical_form import canonical, canonical_json, from_canonical, spec_sha256
    from .exact import number_text
    from .load import load_spec, parse_spec
    from .model import Spec
    from .plausibility import spec_warnings
    from .schema import json_schema

__all__ = [
    "Spec",
    "canonical",
    "canonical_json",
    "from_canonical",
    "json_schema",
    "load_spec",
    "number_text",
    "parse_spec",
    "spec_sha256",
    "spec_warnings",
]

_MODULES = {
    "Spec": "model",
    "canonical": "canonical_form",
    "canonical_json": "canonical_form",
    "from_canonical": "canonical_form",
    "json_schema": "schema",
    "load_spec": "load",
    "number_text": "exact",
    "parse_spec": "load",
    "spec_sha256": "canonical_form",
    "spec_warnings": "plausibility",
}


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)
