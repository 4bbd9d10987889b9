"""The joint among others: passive environments, friction, thousands of loads."""

from __future__ import annotations

from collections.abc import Iterator

from ..agreement import ENERGY_ROUNDING
from ..simulation.adversary.coupled import WALL, Contact, contacts
from ..simulation.adversary.finding import Finding, Side
from ..simulation.adversary.friction import rest_under_friction
from ..simulation.adversary.population import Population, Reality
from .proven import Subject

FEW = 4  # members of ranges that meet every environment


def environments(subject: Subject) -> Iterator[Finding]:
    """Coupled to what is passive, motion dies out where passivity is proven."""
    worst: dict[str, tuple[Contact, str]] = {}
    for member in subject.joints(subject.claims.get(("eq12", "structured")))[:FEW]:
        for contact in contacts(member.spec, subject.C):
            known = worst.get(contact.environment)
            if known is None or contact.growth > known[0].growth:
                worst[contact.environment] = contact, str(member)
    for contact, member_ in worst.values():
        aliased = contact.environment == WALL and subject.spec.sampling is not None
        side: Side = "inside" if subject.passive and not aliased else "information"
        what = f"coupled to: {contact.environment}{member_}; late over early motion"
        yield Finding(
            "eq12 structured", side, what, contact.growth, None, not contact.grows if side == "inside" else None
        )  # fmt: skip


def friction(subject: Subject) -> Iterator[Finding]:
    """With dry friction on the load there is no limit cycle where none is proven."""
    claim = ("friction", "strictly-positive-real")
    side: Side = "inside" if subject.proven(*claim) else "information"
    rests = [(m, rest_under_friction(m.spec, subject.C)) for m in subject.joints(subject.claims.get(claim))[:FEW]]
    member, rest = max(rests, key=lambda each: (len(each[1].hunting), each[1].reversals))
    hunting = f"hunts under {', '.join(map(str, rest.hunting))} times the friction" if rest.hunting else "comes to rest"
    what = f"with Coulomb friction and stiction {hunting}{member}; reversals at the end"
    agrees = not rest.hunting if side == "inside" else None
    yield Finding(" ".join(claim), side, what, rest.reversals, None, agrees)


def drawn_joints(subject: Subject, found: Population) -> Iterator[Finding]:
    """Energy and decay of the joints drawn, against whatever makes every load stable or passive."""
    passive = subject.passive
    robust = passive or subject.robust
    grew = int(found.grew.sum())
    who = f"{len(found.loads)} joints drawn, {found.ticks} ticks of {found.tick * 1e3:g} ms"
    yield Finding(
        "stability-free box", "inside" if robust else "information", f"{who}; how many grew", grew, None,
        grew == 0 if robust else None,
    )  # fmt: skip
    continuous = passive and subject.spec.sampling is None
    yield Finding(
        "eq12 structured", "inside" if continuous else "information", f"{who}; energy drawn, of the largest",
        found.extraction, None, found.extraction >= -ENERGY_ROUNDING if continuous else None,
    )  # fmt: skip


def real_joints(reality: Reality, found: Population, ideal: Population) -> Iterator[Finding]:
    """What the certificate leaves out, on the same joints: it changes no claim, so nothing here can contradict one."""
    who = f"joints drawn, with {reality}"
    figures = {
        "how many grew": float(found.grew.sum()),
        "how many still move back and forth at the end": float((found.reversals > 1).sum()),
        "largest range of θ at the end [rad]": float(found.range.max()),
        "largest |θ| [rad]": float(found.largest_angle.max()),
        "largest |θ| without [rad]": float(ideal.largest_angle.max()),
    }
    for what, value in figures.items():
        yield Finding("not certified", "information", f"{who}; {what}", value, None, None)
