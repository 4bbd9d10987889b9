"""Where stability and passivity end: a Δ, a box, a partner, at the proven margin and just beyond it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction

import numpy as np

from ..certificate.claim import Claim
from ..certificate.outcome import Outcome
from ..simulation import Member, members
from ..simulation.adversary import tones
from ..simulation.adversary.bounds import Bound, lumped, on_top
from ..simulation.adversary.delta import attack, reachable
from ..simulation.adversary.finding import Finding, Side, outside
from ..simulation.adversary.loop import Loop, free, locked
from ..simulation.adversary.motion import Decay, left_alone
from ..simulation.adversary.stretched import (
    hardest,
    joints,
    partner,
    ranges_stretched,
    stretch_of,
    stretch_to_yield,
    vertices,
)
from ..spec.model import Spec
from .proven import Subject, hints_of, load_of, member_of, nominal_load, witness_of

EXACT = ("printed", "half-plane/frozen", "half-plane/physical")  # forms necessary and sufficient over the disc
BEYOND = 1.02  # times the level at which a claim fails: just outside
WITHIN = 0.98
ROUNDING = 1e-6  # relative, of a factor
AT_AN_END = "it fails at ω = 0 or ∞, where no motion shows it"
MARGINAL = 1e-6  # relative to its frequency, a rate that may be rounding


def deltas(subject: Subject) -> Iterator[Finding]:
    """(9) behind an ideal actuator, (18) with the frozen or the physical one: stable for every Δ within W · margin."""
    bound = lumped(subject.spec)
    for claim in subject.claims.values():
        if bound is not None and claim.status is Outcome.PROVEN and claim.id in ("eq9", "eq18"):
            yield from _within_and_beyond(subject, claim, _built(subject, claim), bound)


def _built(subject: Subject, claim: Claim) -> Callable[[Member], Loop]:
    """The nominal joint that a claim is about."""

    def loop(member: Member) -> Loop:
        spec = member.spec
        if claim.id == "eq9":
            spec = spec.behind_ideal_actuator
        return free(spec, subject.C, nominal_load(spec), frozen=claim.form.endswith("/frozen"))

    return loop


def _within_and_beyond(
    subject: Subject, claim: Claim, built: Callable[[Member], Loop], bound: Bound
) -> Iterator[Finding]:
    name, margin, hints = f"{claim.id} {claim.form}", float(claim.margin or 1), hints_of(claim)
    loops = [(member, built(member)) for member in subject.joints(claim)]
    limits = [reachable(loop, bound, subject.band, hints) for _, loop in loops]
    member, loop = loops[int(np.argmin(limits))]

    def tried(factor: float) -> tuple[str, Decay]:
        one = attack(loop, bound, factor, subject.band, hints)
        what = f"Δ within {factor:.6g} W, built against {one.delta.omega:.4g} rad/s{member}, |ΔT| = {one.reach:.4g}"
        return what, left_alone(loop.with_law(one.delta.laws()), one.delta.omega)

    what, end = tried(max(1.0, WITHIN * margin))
    yield Finding(name, "inside", f"{what}; rate [/s]", end.rate, None, not end.grows)
    if claim.refuted_at is not None:
        factor = BEYOND * float(claim.refuted_at.value)
        what, end = tried(factor)
        why = _excuse(claim, "some Δ closes the loop, but grows too slowly to be seen" if min(limits) <= factor else "")
        what += f"; rate {end.rate:.3g} /s; factor on W"
        yield outside(name, what, end.grows, measured=factor, bound=margin, why=why)


def _excuse(claim: Claim, otherwise: str) -> str:
    """Why a Δ just outside need not be found."""
    if claim.form not in EXACT:
        return "this form is only sufficient"
    return otherwise if hints_of(claim) else AT_AN_END


def discs(subject: Subject) -> Iterator[Finding]:
    """With a weight or a table on top of the box: every corner with every Δ is stable where that is proven."""
    bound = on_top(subject.spec)
    kinds = (("eq12", "structured"), ("friction", "strictly-positive-real"))
    kind = next((k for k in kinds if (c := subject.proven(*k)) and c.interval[1] is None and not c.interval[0]), None)
    if bound is None or kind is None or not subject.stable:
        return
    loops = [
        (member, free(member.spec, subject.C, load))
        for member in subject.joints(subject.claims[kind]) for load in vertices(member.spec)
    ]  # fmt: skip
    member, loop = min(loops, key=lambda each: reachable(each[1], bound, subject.band))
    tried = attack(loop, bound, 1.0, subject.band)
    end = left_alone(loop.with_law(tried.delta.laws()), tried.delta.omega)
    what = f"{loop.of}{member} and Δ on top, built against {tried.delta.omega:.4g} rad/s, |ΔT| = {tried.reach:.4g}"
    yield Finding(" ".join(kind), "inside", f"{what}; rate [/s]", end.rate, None, not end.grows)


def boxes(subject: Subject) -> Iterator[Finding]:
    """Every box stretched by the proven factor, and the joint at which the next one fails."""
    for end in ("free", "locked"):
        claim = subject.proven(f"stability-{end}", "box")
        if claim is None or claim.margin is None:
            continue
        name, margin = f"{claim.id} box", claim.margin
        loops = [
            p for one in members(ranges_stretched(subject.spec, margin)) for p in _at(one.spec, subject, end, margin)
        ]
        run = left_alone(max(loops, key=lambda loop: loop.rate))
        what = f"slowest corner of {float(margin):.6g} × the box; late over early motion"
        yield Finding(name, "inside", what, run.growth, None, not run.grows)
        yield from _beyond_box(subject, claim, end)


def _at(spec: Spec, subject: Subject, end: str, stretch: Fraction) -> list[Loop]:
    """Against the wall, or free with every load of the stretched box."""
    if end == "locked":
        return [locked(spec, subject.C)]
    return joints(spec, subject.C, vertices(spec, float(stretch)))


def _beyond_box(subject: Subject, claim: Claim, end: str) -> Iterator[Finding]:
    """The joint of the witness, a little further from the nominal one, and how far that really is."""
    if claim.refuted_at is None:
        return
    name, witness, margin = f"{claim.id} box", witness_of(claim), float(claim.margin or 0)
    if witness is None or not (witness.load or witness.impedance or witness.actuator):
        yield outside(name, "no joint to move", False, bound=margin, why="the claim names none")
        return
    C, named, spec = subject.C, float(claim.refuted_at.value), subject.spec
    load, nominal = load_of(witness), nominal_load(spec)
    if witness.impedance or witness.actuator:
        spec = _further(spec, member_of(spec, witness).spec)
    moved = nominal if load is None else nominal + BEYOND * (load - nominal)
    if moved[0] == 0:
        yield outside(
            name, "no joint to move", False, bound=margin, why="beyond the witness's lies one without inertia"
        )
        return
    loop = locked(spec, C) if end == "locked" else free(spec, C, moved)
    found, stretch = left_alone(loop), stretch_of(subject.spec, spec, moved)
    there = stretch <= BEYOND * named * (1 + ROUNDING)
    what = f"joint of the witness, {BEYOND} times as far: {loop.of}; rate {found.rate:.3g} /s"
    what += f"; {stretch:.6g} × the box holds it"
    what += "" if there else f", beyond {BEYOND} × {named:.6g}, where the claim is said to fail"
    marginal = abs(found.rate) <= MARGINAL * max(1.0, max(hints_of(claim), default=0.0))
    why = "it neither grows nor decays, in floating point" if marginal and there else ""
    yield outside(name, what, found.grows and there, measured=stretch, bound=margin, why=why)


def _further(spec: Spec, at_witness: Spec) -> Spec:
    """A joint beyond that of a witness, as seen from the nominal one."""
    nominal = next(iter(members(spec))).spec

    def moved(part: str) -> dict[str, Fraction]:
        ours, theirs = getattr(nominal, part), getattr(at_witness, part)
        pairs = {name: (getattr(ours, name), value) for name, value in theirs if isinstance(value, Fraction)}
        return {name: a + Fraction(str(BEYOND)) * (b - a) for name, (a, b) in pairs.items()}

    return at_witness.model_copy(
        update={part: getattr(at_witness, part).model_copy(update=moved(part)) for part in ("impedance", "actuator")}
    )


def partners(subject: Subject) -> Iterator[Finding]:
    """A mass and spring tuned against the joint come to rest where it is passive, and drive it unstable where not."""
    claim = subject.claims.get(("eq12", "structured"))
    if claim is None:
        return
    C, hints = subject.C, hints_of(claim)
    spec = min((one.spec for one in subject.joints(claim)), key=lambda one: _resistance(one, subject, hints))
    stretches: list[tuple[Side, float]] = []
    if subject.passive:
        limit = stretch_to_yield(spec, C, subject.band)
        stretches = [("inside", 1.0)]
        if limit is not None:
            stretches.append(("outside", BEYOND * limit))
    elif claim.status is Outcome.REFUTED:
        stretches = [("outside", 1.0)]
    for side, stretch in stretches:
        loads = vertices(spec, stretch)
        which, omega, fed = hardest(spec, C, loads, subject.band, hints)
        loop = free(spec, C, loads[which])
        other = partner(loop, omega)
        end = left_alone(loop.with_law(other.laws()), omega)
        drawn = ""
        if side == "outside" and loop.poles.stable:
            seen = -tones.measured(loop, tones.RESISTANCE, omega).worse
            drawn = f", Re(Z/jω) = {seen:.4g} N·m·s/rad measured"
        what = f"{stretch:.5g} × the box, mass {other.inertia:.4g} on spring {other.stiffness:.4g}"
        what += f" at {omega:.5g} rad/s{drawn}; rate [/s]"
        if side == "inside":
            yield Finding("eq12 structured", side, what, end.rate, None, not end.grows)
        else:
            why = "Re(Z/jω) < 0, but this partner does not make it grow" if fed > 0 else _unseen(subject, claim)
            yield outside("eq12 structured", what, end.grows, measured=end.rate, why=why)


def _unseen(subject: Subject, claim: Claim) -> str:
    """Why a load of the box need not feed any motion, though passivity is refuted."""
    if on_top(subject.spec) is not None:
        return "it fails for a Δ on top of the box"
    if claim.refuted_at is not None and claim.refuted_at.value > 0:
        return "what is refuted asks for more than passivity"
    return "" if hints_of(claim) else AT_AN_END


def _resistance(spec: Spec, subject: Subject, hints: tuple[float, ...]) -> float:
    return -hardest(spec, subject.C, vertices(spec), subject.band, hints)[2]
