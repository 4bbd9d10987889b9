"""YAML 1.2 to `Spec`: exact numbers, units, and errors that say where."""

from __future__ import annotations

from .canonical import canonical, canonical_json, from_canonical, spec_sha256
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
