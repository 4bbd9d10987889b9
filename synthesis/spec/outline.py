"""A specification in a few lines: section by section, as it was written, numbers as short decimals."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from .exact import decimal_text
from .model import Polynomials, Section, Spec


def outline(spec: Spec) -> Iterator[tuple[str, str]]:
    """Section and content of every section that says something."""
    for name, value in spec:
        if name not in ("robimp", "name") and value is not None:
            yield name, _text(value)


def _text(value: Any) -> str:
    if isinstance(value, Fraction):
        return decimal_text(value)
    if isinstance(value, Polynomials):
        return str(value)
    if isinstance(value, Section):
        said = ((key, item) for key, item in value if item is not None)
        return ", ".join(f"{key} {_nested(item)}".rstrip() for key, item in said)
    if isinstance(value, tuple):
        return f"[{', '.join(map(_text, value[:8]))}{', …' if len(value) > 8 else ''}]"
    return str(value)


def _nested(value: Any) -> str:
    text = _text(value)
    return f"({text})" if text and isinstance(value, Section) and not isinstance(value, Polynomials) else text
