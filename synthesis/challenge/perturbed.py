"""Controllers whose coefficients are wrong, each by as much as the tolerance allows, and one by a little more."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from ...models.rational import descending
from ..problem.setting import Setting
from ..simulation import Member, members
from ..simulation.adversary import tones
from ..simulation.adversary.finding import Finding, outside
from ..simulation.adversary.loop import Array, Loop, free, locked
from ..simulation.adversary.motion import left_alone
from ..simulation.equations import Compensator
from ..spec.model import Polynomials, Spec
from .levels import LEVELS, Level, loops_of
from .proven import Subject, load_of, nominal_load, witness_of

TRIED = 16  # sets of signs of the errors
FEW = 2  # members of ranges that each of them is tried on
POINTS = 300  # frequencies
ROUNDING = 1e-9
NAME = "tolerance coefficients"


def tolerance(subject: Subject, coefficients: Polynomials, seed: int) -> Iterator[Finding]:
    """Within the tolerance every requirement is met; the controller of the witness, just outside, breaks one."""
    claim = subject.proven("tolerance", "coefficients")
    if claim is None or claim.margin is None:
        return
    rng = np.random.default_rng(seed)
    tried = [_wrong(coefficients, claim.margin, rng) for _ in range(TRIED)]
    for end in ("free", "locked"):
        loops = [_joint(subject.spec, compensator(subject.spec, each), end) for each in tried]
        run = left_alone(max(loops, key=lambda loop: loop.rate))
        what = f"slowest of {TRIED} controllers wrong by {float(claim.margin):.4g}, {end}; late over early motion"
        yield Finding(NAME, "inside", what, run.growth, None, not run.grows)
    wrong = [Subject(subject.spec, compensator(subject.spec, each), {}) for each in tried]
    built: dict[bool, list[tuple[Member, list[Loop]]]] = {}  # against a wall or not
    for kind, level in LEVELS.items():
        required = _required(subject, kind)
        if required is None:
            continue
        if level.locked not in built:
            joints = list(members(subject.spec))[:FEW]
            built[level.locked] = [(one, [p for w in wrong for p in loops_of(w, level, one)]) for one in joints]
        yield _met(subject, kind, level, required, built[level.locked])
    yield from _outside(subject)


def compensator(spec: Spec, coefficients: Polynomials) -> Compensator:
    """C of coefficients of Q, `C = Q/(1−Q)`, or of C_imp."""
    C = Setting.of(spec).compensator(coefficients)
    return descending(C.num), descending(C.den)


def _wrong(coefficients: Polynomials, v: Fraction, rng: np.random.Generator) -> Polynomials:
    def moved(part: tuple[Fraction, ...]) -> tuple[Fraction, ...]:
        return tuple(c * (1 + v * int(sign)) for c, sign in zip(part, rng.choice([-1, 1], size=len(part)), strict=True))

    return Polynomials(numerator=moved(coefficients.numerator), denominator=moved(coefficients.denominator))


def _joint(spec: Spec, C: Compensator, end: str, load: Array | None = None) -> Loop:
    """Against a wall, or free with a load, the nominal one if none is given."""
    return locked(spec, C) if end == "locked" else free(spec, C, nominal_load(spec) if load is None else load)


def _required(subject: Subject, kind: tuple[str, str]) -> float | None:
    """The level that the specification requires of a claim; None where it only reports."""
    claim, asked = subject.proven(*kind), subject.spec.constraints
    if claim is None or not claim.required:
        return None
    levels = {
        "bandwidth": subject.spec.objective.attenuation,
        "rendering": subject.spec.objective.rendering_error,
        "peak": asked.peak,
        "eq12": None if asked.eq12 is None else asked.eq12.margin,
        "noise": None if asked.noise is None else asked.noise.gain,
        "friction": Fraction(0),
    }
    level = None if claim.form == "paper" else levels[claim.id]
    return None if level is None else float(level)


def _met(
    subject: Subject, kind: tuple[str, str], level: Level, required: float, joints: list[tuple[Member, list[Loop]]]
) -> Finding:
    """The worst of the wrong controllers, by frequency response, then its motion; Δ is left to the one as printed."""
    claim = subject.claims[kind]
    low, high = subject.band
    low, high = max(float(claim.interval[0]), low), float(claim.interval[1] or high)
    grid = np.geomspace(min(low, high / 100), high, POINTS)
    found = []
    for one, loops in joints:
        quantity = level.quantity(one.spec)
        for loop in loops:
            values = quantity.of(loop, grid)
            found.append((float(values.max()), float(grid[values.argmax()]), loop, quantity))
    _, omega, loop, quantity = max(found, key=lambda each: each[0])
    what = f"{' '.join(kind)}: {level.words} at {omega:.6g} rad/s, worst of {TRIED} wrong controllers"
    what += f"; required {required:.6g}"
    if not loop.poles.stable:
        return Finding(NAME, "inside", f"{what}; unstable", None, None, False)
    seen, sign = tones.measured(loop, quantity, omega), quantity.sign
    agrees = seen.worse <= sign * required + ROUNDING * abs(required) + seen.slack
    return Finding(NAME, "inside", what, sign * seen.worse, None, agrees)


def _outside(subject: Subject) -> Iterator[Finding]:
    """The witness's controller, just outside the tolerance, at the frequency where it breaks a requirement."""
    claim = subject.claims["tolerance", "coefficients"]
    if claim.refuted_at is None:
        return
    witness, margin = witness_of(claim), float(claim.margin or 0)
    broken = witness.claim if witness is not None else None
    required, level = (None, None) if broken is None else (_required(subject, broken), LEVELS.get(broken))
    if witness is None or witness.controller is None or witness.omega is None or required is None or level is None:
        why = f"no sine measures {' '.join(broken)} there" if broken else "the claim names no controller"
        yield outside(NAME, "no controller to try", False, bound=margin, why=why)
        return
    member, C, load = subject.joints(claim)[0], compensator(subject.spec, witness.controller), load_of(witness)
    loop = _joint(member.spec, C, "locked" if level.locked else "free", load)
    quantity, value = level.quantity(member.spec), float(claim.refuted_at.value)
    what = f"witness's controller, {' '.join(witness.claim or ())}"
    if not loop.poles.stable:
        yield outside(NAME, f"{what}: unstable; relative error", True, measured=value, bound=margin)
        return
    seen = tones.measured(loop, quantity, float(witness.omega))
    sign = quantity.sign
    what += f" {sign * seen.worse:.12g} where {required:.6g} is required; relative error"
    beyond = seen.worse - sign * required
    why = "too near what is required to tell" if abs(beyond) <= seen.slack else ""
    yield outside(NAME, what, beyond > 0, measured=value, bound=margin, why=why)
