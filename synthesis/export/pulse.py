"""Stability of the sampled loop as it is: joint between ticks exact, every alias included, no frequency response.

The joint is moved over a tick by matrix exponentials in ball arithmetic; with the shipped law it has a characteristic
polynomial of z, whose coefficients are balls. All its roots inside the unit circle: every mode of joint, hold, delay,
filters and controller decays. A sample is taken just before the torque changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from math import log

from flint import arb, arb_mat, arb_poly, ctx, fmpq, fmpq_poly

from ...models.impedance import DynamicStiffness
from ...models.rational import exact, to_float
from ...models.sampling import Hold
from ..certificate.claim import Claim, Refutation
from ..certificate.outcome import Outcome
from ..certificate.stability import MODES
from ..certificate.witness import short
from ..problem.constraints.inequality import WHOLE
from ..problem.setting import Setting
from .carried import DECAY
from .law import Law
from .schur import is_schur

PRECISIONS = (256, 1024, 4096)  # bits; the next where balls are too wide
HALVINGS = 40


@dataclass(frozen=True)
class Pulse:
    """`num/den` of z: from the commands to a signal's samples."""

    num: arb_poly
    den: arb_poly


def pulse(num: fmpq_poly, den: fmpq_poly, hold: Hold) -> Pulse:
    """The pulse transfer function of a proper `num/den` of s behind a hold and a delay; nothing is cancelled."""
    n, T = den.degree(), hold.period
    lead = den[n] / T**n
    d = [den[k] / T**k / lead for k in range(n)]  # time in ticks
    through = num[n] / den[n]
    c = [num[k] / T**k / lead - through * d[k] for k in range(n)]
    ticks = hold.delay / T
    whole = ticks.floor()
    late = ticks - whole  # part of a tick that the older command still acts
    motion, _ = _moved(d, fmpq(1))
    rest, newer = _moved(d, 1 - late)
    older = rest * _moved(d, late)[1]
    characteristic = _characteristic(motion, None, c)
    z = arb_poly([0, 1])
    numerator = (_characteristic(motion, newer, c) - characteristic) * z
    numerator = numerator + (_characteristic(motion, older, c) - characteristic) + characteristic * arb(through)
    return Pulse(numerator, characteristic * z ** (int(whole) + 1))


def _moved(d: list[fmpq], ticks: fmpq) -> tuple[arb_mat, arb_mat]:
    """State after a time from its start, and from a command held meanwhile, of the companion form of d."""
    n = len(d)
    flow = arb_mat(n + 1, n + 1)
    for k in range(n - 1):
        flow[k, k + 1] = arb(ticks)
    for k in range(n):
        flow[n - 1, k] = arb(-d[k] * ticks)
    if n:
        flow[n - 1, n] = arb(ticks)
    moved = flow.exp()
    motion = arb_mat(n, n, [moved[i, j] for i in range(n) for j in range(n)])
    return motion, arb_mat(n, 1, [moved[i, n] for i in range(n)])


def _characteristic(motion: arb_mat, entry: arb_mat | None, c: list[fmpq]) -> arb_poly:
    """`det(zI − Φ + Γc)`; less that without Γ it is `c adj(zI − Φ) Γ`."""
    row = arb_mat(1, len(c), [arb(value) for value in c])
    return (motion if entry is None else motion - entry * row).charpoly()


def characteristic(setting: Setting, law: Law, end: str, load: DynamicStiffness) -> arb_poly:
    """The characteristic polynomial of z in free motion or against a rigid wall, every mode counted."""
    port, hold = setting.loop.actuator, setting.loop.actuator.hold
    assert hold is not None
    wish = law.error.stiffness(law.desired)
    compensation = law.compensated.stiffness(law.nominal) - law.compensated.stiffness(law.desired)
    feedback, behind = law.feedback(end, lambda p: p, wish, compensation)
    joint = pulse(port.h, port.d if end == "locked" else port.d * load.polynomial + port.z, hold)
    degree, idle = max(feedback.degree(), behind.degree()), law.idle(end)
    closed = joint.den * _in_z(behind, degree) + joint.num * _in_z(feedback, degree)
    return closed * _in_z(idle, idle.degree())


def _in_z(p: fmpq_poly, degree: int) -> arb_poly:
    """`z^degree p(z⁻¹)`."""
    return arb_poly([arb(p[degree - k]) for k in range(degree + 1)])


def decays(p: arb_poly, ticks: arb | int = 0) -> bool | None:
    """Whether every root of p lies inside the circle of radius `exp(−ticks)`; None: the balls are too wide."""
    return is_schur([c * (-arb(ticks) * k).exp() for k, c in enumerate(p.coeffs())])


def prove_sampled(setting: Setting, law: Law, end: str) -> Claim:
    """Nominal stability of the sampled loop, with the rate [1/s] at which every mode decays at least."""
    load, T = setting.loop.nominal, law.period
    proven, refuted, status = None, None, Outcome.UNDECIDED
    for bits in PRECISIONS:
        with precision(bits):
            p = characteristic(setting, law, end, load)
            stable = decays(p)
            if stable is None:
                continue
            status = Outcome.PROVEN if stable else Outcome.REFUTED
            if stable:
                proven, refuted = _rate(p, T)
            break
    return Claim(
        id=f"stability-{end}",
        equation=MODES[end][0],
        form=DECAY,
        statement=f"{MODES[end][1]} of the sampled loop decays faster than exp(−v·t), nominal load, aliases included",
        uncertainty="none: nominal load",
        interval=WHOLE,
        required=True,
        status=status,
        margin=proven,
        refuted_at=Refutation(Fraction(0), None) if status is Outcome.REFUTED else refuted,
    )


def _rate(p: arb_poly, period: fmpq) -> tuple[Fraction, Refutation | None]:
    """The decay rate [1/s], bisected, with the next level that fails."""
    T = to_float(period)
    low, high = 0.0, -log(1e-6) / T
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if decays(p, arb(middle * T)) else (low, middle)
    proven, beyond = short(low, up=False), short(high, up=True)
    if not decays(p, arb(exact(proven) * period)):
        proven = Fraction(0)
    fails = decays(p, arb(exact(beyond) * period)) is False
    return proven, Refutation(beyond, None) if fails else None


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Ball arithmetic with so many bits, meanwhile."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before
