"""Where stability and passivity end: a Δ, a box, a partner, at the proven margin and just beyond it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..certificate.outcome import Outcome
from ..simulation.adversary import tones
from ..simulation.adversary.delta import attack, bound_of
from ..simulation.adversary.finding import Finding, Side
from ..simulation.adversary.motion import left_alone
from ..simulation.adversary.stretched import partner, stretch_to_yield, vertices, worst_poles
from ..simulation.batch.switched import switched
from ..simulation.equations import Compensator
from ..spec.model import IdealActuator, Spec
from .proven import Claims, band_of, hints_of, nominal_load, passive_port, proven

BEYOND = 1.02  # times the level at which a claim fails: just outside
WITHIN = 0.98


def deltas(spec: Spec, C: Compensator, claims: Claims) -> Iterator[Finding]:
    """(9) behind an ideal actuator, (18) with the physical one: stable for every Δ within W times the margin."""
    bound = bound_of(spec)
    for claim in claims.values():
        physical = claim.id == "eq18" and claim.form.endswith("/physical")
        if bound is None or claim.status is not Outcome.PROVEN or not (claim.id == "eq9" or physical):
            continue
        joint = spec if physical else spec.model_copy(update={"actuator": IdealActuator(type="ideal")})
        name, margin = f"{claim.id} {claim.form}", float(claim.margin or 1)
        levels: list[tuple[Side, float]] = [("inside", max(1.0, WITHIN * margin))]
        if claim.refuted_at is not None:
            levels.append(("outside", BEYOND * float(claim.refuted_at.value)))
        for side, factor in levels:
            tried = attack(joint, C, bound, factor, band_of(spec))
            end = left_alone(tried.joint(joint, C), tried.omega)
            what = (
                f"Δ within {factor:.6g} W, built against {tried.omega:.4g} rad/s, |ΔT| = {tried.reach:.4g}; rate [/s]"
            )
            agrees = not end.grows if side == "inside" else (end.grows or None)
            yield Finding(name, side, what, end.worst_pole, None, agrees)


def boxes(spec: Spec, C: Compensator, claims: Claims) -> Iterator[Finding]:
    """The box stretched by the proven factor, and the load at which the next one fails."""
    claim = proven(claims, "stability-free", "box")
    if claim is None or claim.margin is None:
        return
    inside = float(worst_poles(spec, C, vertices(spec, float(claim.margin))).max())
    yield Finding(
        "stability-free box",
        "inside",
        f"corners of {float(claim.margin):.6g} × the box; rate [/s]",
        inside,
        None,
        inside < 0,
    )
    witness = claim.refuted_at.witness if claim.refuted_at else None
    if witness is None or witness.load is None or not witness.omega:
        return
    nominal = nominal_load(spec)[0]
    marginal = np.array([float(v) for v in (witness.load.inertia, witness.load.damping, witness.load.stiffness)])
    load = nominal + BEYOND * (marginal - nominal)
    end = left_alone(switched(spec, C, load[None]), float(witness.omega))
    what = f"load of the witness, {BEYOND} times as far: I={load[0]:.4g} B={load[1]:.4g} K={load[2]:.4g}; rate [/s]"
    yield Finding("stability-free box", "outside", what, end.worst_pole, None, end.grows or None)


def partners(spec: Spec, C: Compensator, claims: Claims) -> Iterator[Finding]:
    """A mass and spring tuned against the joint come to rest where it is passive, and drive it unstable where not."""
    claim, band = claims.get(("eq12", "structured")), band_of(spec)
    if claim is None:
        return
    stretches: list[tuple[Side, float]] = []
    if passive_port(claims):
        limit = stretch_to_yield(spec, C, band)
        stretches = [("inside", 1.0)]
        if limit is not None:
            stretches.append(("outside", BEYOND * limit))
    elif claim.status is Outcome.REFUTED:
        stretches = [("outside", 1.0)]
    for side, stretch in stretches:
        load, omega = tones.worst(spec, C, vertices(spec, stretch), tones.yielding, band, hints_of(claim))
        other = partner(spec, C, load, omega)
        end = left_alone(other.joint(spec, C, load), omega)
        fed = tones.measured(spec, C, load, omega).resistance if side == "outside" else None
        drawn = "" if fed is None else f", Re(Z/jω) = {fed:.4g} N·m·s/rad measured"
        what = f"{stretch:.5g} × the box, mass {other.inertia:.4g} on spring {other.stiffness:.4g}"
        what += f" at {omega:.5g} rad/s{drawn}; rate [/s]"
        agrees = not end.grows if side == "inside" else (end.grows or None)
        yield Finding("eq12 structured", side, what, end.worst_pole, None, agrees)
