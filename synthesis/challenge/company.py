"""The joint among others: passive environments, friction, thousands of loads."""

from __future__ import annotations

from collections.abc import Iterator

from ..simulation.adversary.coupled import contacts
from ..simulation.adversary.finding import Finding, Side
from ..simulation.adversary.friction import rest_under_friction
from ..simulation.adversary.population import Population
from ..simulation.equations import Compensator
from ..spec.model import Spec
from .proven import Claims, passive_port, proven

ENERGY_ROUNDING = 1e-9  # of the largest energy that passed the port


def environments(spec: Spec, C: Compensator, claims: Claims) -> Iterator[Finding]:
    """Coupled to what is passive, motion dies out where passivity is proven."""
    side: Side = "inside" if passive_port(claims) else "information"
    for contact in contacts(spec, C):
        agrees = not contact.grows if side == "inside" else None
        yield Finding(
            "eq12 structured",
            side,
            f"coupled to: {contact.environment}; late over early motion",
            contact.growth,
            None,
            agrees,
        )


def friction(spec: Spec, C: Compensator, claims: Claims) -> Iterator[Finding]:
    """With dry friction on the load there is no limit cycle where none is proven."""
    rest = rest_under_friction(spec, C)
    side: Side = "inside" if proven(claims, "friction", "strictly-positive-real") else "information"
    hunting = f"hunts under {', '.join(map(str, rest.hunting))} times the friction" if rest.hunting else "comes to rest"
    what = f"with Coulomb friction and stiction {hunting}; reversals at the end"
    yield Finding(
        "friction strictly-positive-real",
        side,
        what,
        rest.reversals,
        None,
        not rest.hunting if side == "inside" else None,
    )


def drawn_joints(spec: Spec, found: Population, claims: Claims) -> Iterator[Finding]:
    """Energy and decay of the joints drawn, against whatever makes every load stable or passive."""
    passive = passive_port(claims)
    robust = passive or proven(claims, "stability-free", "box") is not None
    grew = int(found.grew.sum())
    who = f"{len(found.loads)} joints drawn, {found.ticks} ticks of {found.tick * 1e3:g} ms"
    yield Finding(
        "stability-free box", "inside" if robust else "information", f"{who}; how many grew", grew, None,
        grew == 0 if robust else None,
    )  # fmt: skip
    continuous = passive and spec.sampling is None
    yield Finding(
        "eq12 structured", "inside" if continuous else "information", f"{who}; energy drawn, of the largest",
        found.extraction, None, found.extraction >= -ENERGY_ROUNDING if continuous else None,
    )  # fmt: skip
