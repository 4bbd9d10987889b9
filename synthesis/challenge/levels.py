"""Bounds that hold frequency by frequency, measured where the joint is worst."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf

import numpy as np

from ..agreement import NOMINAL
from ..certificate.claim import Claim
from ..simulation import Member
from ..simulation.adversary import tones
from ..simulation.adversary.bounds import lumped, on_top
from ..simulation.adversary.delta import worst_within
from ..simulation.adversary.finding import Finding, outside
from ..simulation.adversary.loop import Loop, free, locked
from ..simulation.adversary.motion import fading
from ..simulation.adversary.stretched import vertices
from ..simulation.adversary.tones import Quantity
from ..spec.model import Spec
from .proven import Subject, hints_of, nominal_load

FAR = 1000.0  # beyond the band, for what is worst at ω = 0 or ∞
ROUNDING = 1e-6  # of a bound
JUST = 1 + 1e-4  # of a frequency: just beyond it
FILLED = 0.03  # of a complex figure: what a Δ that does not fill its disc may miss
FAILS = "the claim is said to fail at"


@dataclass(frozen=True)
class Level:
    """What a claim bounds: in words, as a quantity; whether on [0, ω_B], against a wall, and for which Δ."""

    words: str
    quantity: Callable[[Spec], Quantity]
    on_band: bool = False
    locked: bool = False
    disc: bool = False  # on top of every load
    lumped: bool = False  # about the nominal load, with the box in it
    ideal: bool = False  # actuator


RESISTANCE, DISTURBED = "Re(Z/jω) [N·m·s/rad]", "|1−Q̃| of a disturbance"
LEVELS = {
    ("bandwidth", "attenuation"): Level(DISTURBED, lambda _: tones.ATTENUATION, on_band=True),
    ("peak", "sensitivity"): Level(DISTURBED, lambda _: tones.ATTENUATION),
    ("rendering", "every-load"): Level("|Z/G_imp − 1|", tones.rendering_error, on_band=True, disc=True),
    ("eq12", "structured"): Level(RESISTANCE, lambda _: tones.RESISTANCE, disc=True),
    ("eq12", "disc"): Level(RESISTANCE, lambda _: tones.RESISTANCE, lumped=True),
    ("eq12", "paper"): Level(f"ideal actuator, {RESISTANCE}", lambda _: tones.RESISTANCE, lumped=True, ideal=True),
    ("friction", "strictly-positive-real"): Level(
        "Re(Z/jω)/(1−Q̃), which friction meets [N·m·s/rad]", lambda _: tones.DRY, disc=True
    ),
    ("noise", "command"): Level("command per noise of the sensor, locked", lambda _: tones.COMMAND, locked=True),
}


def levels(subject: Subject) -> Iterator[Finding]:
    """Bounds that hold frequency by frequency, measured with a sine where the joint is worst."""
    for kind, level in LEVELS.items():
        claim = subject.proven(*kind)
        if claim is None or claim.margin is None:
            continue
        band = subject.band
        if level.on_band:
            omega_B = float(claim.interval[1] or band[1])
            band = min(band[0], omega_B / 100), omega_B
        else:
            band = float(claim.interval[0]) or band[0] / FAR, float(claim.interval[1] or band[1] * FAR)
        yield from _level(subject, claim, level, band)
    yield from _beyond_band(subject)
    yield from _decays(subject)


def bound_of(subject: Subject, claim: Claim) -> float:
    """What a claim's quantity is bounded by: the margin, or where that is a frequency or a factor, the level itself."""
    if claim.id == "bandwidth":
        return float(subject.spec.objective.attenuation)
    return 0.0 if claim.form == "paper" else float(claim.margin or 0)


def loops_of(subject: Subject, level: Level, member: Member) -> list[Loop]:
    """The joints that a level is about, of one member of the ranges."""
    spec = member.spec
    if level.ideal:
        spec = spec.behind_ideal_actuator
    if level.locked:
        return [locked(spec, subject.C)]
    return [free(spec, subject.C, load) for load in ([nominal_load(spec)] if level.lumped else vertices(spec))]


def _level(subject: Subject, claim: Claim, level: Level, band: tuple[float, float]) -> Iterator[Finding]:
    """The worst of all loads and members, and of all Δ, by their frequency response, then its motion.

    It is within the margin, and beyond the level at which the claim is said to fail.
    """
    name, bound, hints = f"{claim.id} {claim.form}", bound_of(subject, claim), hints_of(claim)
    disc = lumped(subject.spec) if level.lumped else on_top(subject.spec) if level.disc else None
    found = []
    for member in subject.joints(claim):
        loops, quantity, built = loops_of(subject, level, member), level.quantity(member.spec), ""
        if disc is not None:
            which, delta = worst_within(loops, quantity, disc, band, hints)
            omega, loop = delta.omega, loops[which].with_law(delta.laws())
            bad = float(quantity.of(loop, np.array([omega]))[0])
            built = f", |Δ| = {delta.gain:.4g}"
        else:
            each = [(lambda omega, loop=loop, q=quantity: q.of(loop, omega)) for loop in loops]
            which, omega, bad = tones.worst(each, band, hints)
            loop = loops[which]
        found.append((bad, loop, quantity, omega, f"at {omega:.6g} rad/s, {loop.of}{member}{built}"))
    stable = [each for each in found if each[1].poles.stable]
    if not stable:
        yield Finding(name, "information", f"unstable, nothing to measure: {found[0][-1]}", None, bound, None)
        return
    _, loop, quantity, omega, where = max(stable, key=lambda each: each[0])
    seen = tones.measured(loop, quantity, omega)
    slack, sign = ROUNDING * abs(bound) + seen.slack, quantity.sign
    agrees = seen.worse <= sign * bound + slack
    filters = subject.spec.controller.filters
    if claim.form == "paper" and (filters.position is not None or filters.derivative is not None):
        what = f"(12) as printed knows of no filters; {level.words} {where}"
        yield Finding(name, "information", what, sign * seen.worse, bound, None)
        return
    yield Finding(name, "inside", f"{level.words} {where}", sign * seen.worse, bound, agrees)
    if claim.id != "bandwidth" and claim.refuted_at is not None:
        fails_at = float(claim.refuted_at.value)
        what = f"{level.words} {where}: {sign * seen.worse:.9g}; {FAILS} {fails_at:.9g}"
        missing = inf if claim.form == "paper" else sign * fails_at - seen.worse  # its level is a factor on W
        why = _excuse(claim, band, disc is not None and missing <= FILLED * seen.size)
        yield outside(name, what, missing <= slack, measured=sign * seen.worse, bound=bound, why=why)


def _excuse(claim: Claim, band: tuple[float, float], nearly: bool) -> str:
    """Why the level at which a claim fails need not be reached."""
    if claim.form == "paper":
        return "this form is only sufficient"
    if nearly:
        return "a rational Δ fills its disc nearly, not quite"
    low, high = band
    if any(low <= omega <= high for omega in hints_of(claim)):
        return ""
    return f"it fails outside {low:.3g} to {high:.3g} rad/s, where nothing was run"


def _beyond_band(subject: Subject) -> Iterator[Finding]:
    claim = subject.proven("bandwidth", "attenuation")
    if claim is None or not claim.margin or claim.refuted_at is None:
        return
    level, member = float(subject.spec.objective.attenuation), subject.joints(claim)[0]
    loop = free(member.spec, subject.C, nominal_load(member.spec))
    tried = [float(claim.refuted_at.value), *hints_of(claim)]
    tried = [omega for omega in tried if omega <= float(claim.refuted_at.value)]
    runs = [(tones.measured(loop, tones.ATTENUATION, omega * step), omega) for omega in tried for step in (1, JUST)]
    seen, omega = max(runs, key=lambda run: run[0].worse)
    slack = ROUNDING * level + seen.slack
    why = "too near the level to tell" if abs(seen.worse - level) <= slack else ""
    what = f"|1−Q̃| just beyond ω_B, at {omega:.6g} rad/s"
    yield outside(
        "bandwidth attenuation",
        f"{what}, {seen.worse:.6g}",
        seen.worse > level,
        measured=seen.worse,
        bound=level,
        why=why,
    )


def _decays(subject: Subject) -> Iterator[Finding]:
    """The nominal joint thrown and left alone, until only its slowest motion remains."""
    spec, C = subject.spec, subject.C
    for end, loop in (("free", free(spec, C, nominal_load(spec))), ("locked", locked(spec, C))):
        for form in NOMINAL:
            if claim := subject.proven(f"stability-{end}", form):
                yield from _decay(claim, loop)


def _decay(claim: Claim, loop: Loop) -> Iterator[Finding]:
    name, bound, seen = f"{claim.id} {claim.form}", float(claim.margin or 0), fading(loop)
    slack = ROUNDING * abs(seen.rate) + seen.change
    what = (
        "slowest decay of a run [/s]" if claim.form == "hurwitz" else "slowest decay of a run with hold and delay [/s]"
    )
    yield Finding(name, "inside", what, seen.rate, bound, seen.rate >= bound - slack)
    if claim.refuted_at is not None:
        fails_at = float(claim.refuted_at.value)
        what = f"{what}: {seen.rate:.9g}; {FAILS} {fails_at:.9g}"
        yield outside(name, what, seen.rate <= fails_at + slack, measured=seen.rate, bound=bound)
