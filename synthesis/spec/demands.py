"""The other half of a specification: the controller to find, what it should maximise, and what must be proven."""

from __future__ import annotations

from fractions import Fraction
from typing import Literal, cast

from ..errors import Location
from .fields import above, described, entries, integer, non_negative, polynomials, require, word
from .filters import filters
from .model import (
    FORMS,
    Constraints,
    Controller,
    Eq9,
    Eq12,
    Eq18,
    Filters,
    Interval,
    Noise,
    Objective,
    Polynomials,
    Uncertainty,
)
from .ranges import interval
from .tree import Node, Scalar
from .units import FREQUENCY, RATIO, Mechanics

ORDERS = {"dob": (2, 8), "dynamic-feedback": (0, 8)}
"""Least and greatest order of a controller that is searched, by type."""
_CHOICES = ("order", "form", "coefficients")
FLOAT32 = Fraction(1, 2**24)  # half a unit in the last place: what rounding to single precision changes at most


def controller(node: Node) -> Controller:
    """A controller to find (`order`, `form`) or one to certify (`coefficients`)."""
    section = entries(node, ("type",), (*_CHOICES, "filters"))
    kind = cast(Literal["dob", "dynamic-feedback"], word(section["type"], *ORDERS))
    given = [key for key in _CHOICES if key in section]
    found = f"{' and '.join(given)}; keep one" if given else "none; write order: 4, for instance"
    require(len(given) == 1, f"expected exactly one of order, form, coefficients; found {found}", node.where)
    if "form" in section:
        form = word(section["form"], *(form for forms in FORMS.values() for form in forms))
        message = f"the form {form} is not one of type: {kind}, whose forms are {', '.join(FORMS[kind])}"
        require(form in FORMS[kind], message, section["form"].where)
    return Controller(
        type=kind,
        order=_order(section["order"], kind) if "order" in section else None,
        form=word(section["form"], *FORMS[kind]) if "form" in section else None,
        coefficients=_given(section["coefficients"], kind) if "coefficients" in section else None,
        filters=filters(section["filters"], coefficients="coefficients" in section)
        if "filters" in section
        else Filters(),
    )


def objective(node: Node) -> Objective:
    """Largest bandwidth at a stated attenuation."""
    section = entries(node, ("maximize", "attenuation"), ("rendering_error",))
    word(section["maximize"], "bandwidth")
    attenuation = above(section["attenuation"], 0, RATIO)
    given = section["attenuation"]
    message = f"expected an attenuation below 1, the part of a disturbance that remains; found {described(given)}"
    require(attenuation < 1, f"{message}; write 0.3 or 30 %", given.where)
    rendering = section.get("rendering_error")
    return Objective(
        maximize="bandwidth",
        attenuation=attenuation,
        rendering_error=above(rendering, 0, RATIO) if rendering else None,
    )


def constraints(node: Node, units: Mechanics, uncertainty: Uncertainty | None) -> Constraints:
    """What must be proven; `uncertainty` None: it could not be read, and its own error is reported."""
    section = entries(node, optional=("eq9", "eq12", "eq18", "peak", "friction", "noise", "tolerance"))
    if "eq9" in section:
        entries(section["eq9"])
    friction = word(section["friction"], "report", "require") if "friction" in section else "report"
    return Constraints(
        eq9=Eq9() if "eq9" in section else None,
        eq12=_eq12(section["eq12"], units, uncertainty) if "eq12" in section else None,
        eq18=_eq18(section["eq18"]) if "eq18" in section else None,
        peak=above(section["peak"], 1, RATIO) if "peak" in section else None,
        friction=cast(Literal["report", "require"], friction),
        noise=_noise(section["noise"]) if "noise" in section else None,
        tolerance=_tolerance(section["tolerance"]) if "tolerance" in section else None,
    )


def _order(node: Node, kind: str) -> int:
    low, high = ORDERS[kind]
    what = {"dob": "an order of Q from 2 to 8", "dynamic-feedback": "an order of C_imp from 0 (P) to 8"}[kind]
    order = integer(node, what)
    require(low <= order <= high, f"expected {what}; found {described(node)}; write order: 4, say", node.where)
    return order


def _given(node: Node, kind: str) -> Polynomials:
    given = polynomials(node)
    demand_realizable(given, kind, node.where)
    return given


def demand_realizable(given: Polynomials, kind: str, where: Location) -> None:
    """Refuse a Q with `Q(∞) = 1`: `C = Q/(1−Q)` would be improper. Raises: InputError."""
    biproper = len(given.numerator) == len(given.denominator)
    looped = kind == "dob" and biproper and given.numerator[0] == given.denominator[0]
    require(
        not looped,
        "expected Q(∞) ≠ 1; found Q(∞) = 1, so that C = Q/(1−Q) is not proper; lower the numerator's degree",
        where,
    )


def _eq12(node: Node, units: Mechanics, uncertainty: Uncertainty | None) -> Eq12:
    section = entries(node, ("form",), ("band", "margin"))
    form = cast(Literal["paper", "disc", "structured"], word(section["form"], "paper", "disc", "structured"))
    if form != "structured" and uncertainty is not None and uncertainty.box is not None:
        for key in ("weight", "table"):
            message = f"the form {form} takes a box or a {key}, not both; write structured, which takes both"
            require(getattr(uncertainty, key) is None, message, section["form"].where)
    margin = section.get("margin")
    return Eq12(
        form=form,
        band=_band(section["band"]) if "band" in section else None,
        margin=non_negative(margin, units.damping) if margin else Fraction(0),
    )


def _band(node: Node) -> Interval:
    low, high = interval(node, FREQUENCY)
    require(low >= 0, "expected a band that begins at 0 or above", node.where)
    require(low < high, "expected low < high; leave `band` out for the whole axis", node.where)
    return low, high


def _eq18(node: Node) -> Eq18:
    section = entries(node, ("form", "coupling"))
    return Eq18(
        form=cast(Literal["paper", "lumped", "half-plane"], word(section["form"], "paper", "lumped", "half-plane")),
        coupling=cast(Literal["frozen", "physical"], word(section["coupling"], "frozen", "physical")),
    )


def _noise(node: Node) -> Noise:
    section = entries(node, ("gain",), ("above",))
    start = section.get("above")
    return Noise(gain=above(section["gain"], 0, RATIO), above=non_negative(start, FREQUENCY) if start else Fraction(0))


def _tolerance(node: Node) -> Fraction:
    if isinstance(node, Scalar) and node.text.startswith("float"):
        word(node, "float32")
        return FLOAT32
    part = above(node, 0, RATIO)
    message = f"expected a tolerance below 1, the part by which a coefficient may be wrong; found {described(node)}"
    require(part < 1, message, node.where)
    return part
