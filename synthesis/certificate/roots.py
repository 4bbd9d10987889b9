"""Complex roots of exact polynomials, isolated by FLINT."""

from __future__ import annotations

from typing import Any, cast

from flint import acb, fmpq_poly


def complex_roots(p: fmpq_poly) -> list[tuple[acb, int]]:
    """Balls that hold one distinct root each, with its multiplicity; the imaginary part of a real root is exactly 0."""
    return cast(Any, p.numer().complex_roots()) if p.degree() > 0 else []
