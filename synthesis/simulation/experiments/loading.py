"""Figs. 9 and 10: a torque slowly applied and taken back, against dry friction."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from ...spec.model import SeriesElasticActuator, Spec
from ..batch.run import simulate_batch
from ..batch.switched import Imperfections, switched
from ..equations import Compensator
from .experiment import FRICTION, STICTION, Array, Curve, Experiment, Observation, given, rivals, true_load, wishing

TICK = 1e-3
SECONDS = 60.0
EVERY = 100  # ticks between points of a curve
STIFFNESSES = tuple(map(Fraction, ("1/5", "1/2", "5/4", "3", "10")))  # N·m/rad; the paper's run from 0.2 to 10
DAMPING = Fraction(7, 20)  # N·m·s/rad [published]
REACH = 1.0  # rad: how far the slow torque takes the joint
AXES = ("θ [rad]", "τ_int [N·m]")


def loaded(spec: Spec, C: Compensator, torque: float) -> tuple[Array, Array]:
    """θ and τ_int while the torque [N·m] rises slowly from zero and falls back."""
    faults = Imperfections(load_friction=FRICTION, stiction=STICTION)
    joint = switched(spec, C, [true_load(spec)], faults)
    push = torque * (1 - abs(np.linspace(-1, 1, round(SECONDS / TICK))))
    run = simulate_batch(joint, TICK, push, every=EVERY)
    return run.trace("theta"), run.trace("tau_int")


def hysteresis(theta: Array, tau: Array) -> float:
    """Width [rad] of the loop at half the largest torque."""
    top = int(np.argmax(tau))
    level = tau[top] / 2
    up = np.interp(level, tau[: top + 1], theta[: top + 1])
    down = np.interp(level, tau[top:][::-1], theta[top:][::-1])
    return float(abs(down - up))


def stiffness(theta: Array, tau: Array) -> float:
    """Slope [N·m/rad] of the middle line of the loop, between a quarter and three quarters of the torque."""
    top = int(np.argmax(tau))
    levels = np.linspace(0.25, 0.75, 50) * tau[top]
    up = np.interp(levels, tau[: top + 1], theta[: top + 1])
    down = np.interp(levels, tau[top:][::-1], theta[top:][::-1])
    return float(np.polyfit((up + down) / 2, levels, 1)[0])


def fig9(spec: Spec, C: Compensator) -> Experiment:
    """Stiffness rendering under slow loading with Coulomb friction: (2), (10) and (20)."""
    spec = wishing(spec, Fraction(5, 4), DAMPING)
    loops = {name: loaded(*each, 1.25 * REACH) for name, each in rivals(spec, C).items()}
    width = {name: hysteresis(*loop) for name, loop in loops.items()}
    plain = width["traditional (2)"]
    own = "the DOB" if given(spec) == "DOB (10)" else given(spec)
    dob, feedback = width[given(spec)] / plain, width["dynamic feedback (20)"] / plain
    seen = (
        Observation(
            "friction shows under every controller", f"{min(width.values()):.3g} rad at least", min(width.values()) > 0
        ),
        Observation(f"greatly reduced by {own}", f"{dob:.2f} of the traditional width {plain:.3g} rad", dob < 0.5),
        Observation("greatly reduced by dynamic feedback", f"{feedback:.2f} of it", feedback < 0.5),
        Observation(
            "both almost the same", f"they differ by {abs(dob - feedback):.2f} of it", abs(dob - feedback) < 0.15
        ),
    )
    curves = tuple(Curve(name, theta, tau) for name, (theta, tau) in loops.items())
    return Experiment("Fig. 9: stiffness rendering, slow loading", AXES, curves, seen)


def fig10(spec: Spec, C: Compensator) -> Experiment:
    """Stiffnesses from 0.2 to 10 N·m/rad with one inner loop and one Q."""
    curves, found, width, damping = [], {}, {}, {}
    for K in STIFFNESSES:
        one = wishing(spec, K, DAMPING)
        theta, tau = loaded(one, C, max(float(K) * REACH, 8 * FRICTION))
        curves.append(Curve(f"K = {float(K):g} N·m/rad", theta, tau))
        found[K], width[K] = stiffness(theta, tau), hysteresis(theta, tau)
        joint = switched(one, C, [true_load(one)])
        poles = np.linalg.eigvals(joint.flows[0, 0, :, : joint.states])
        damping[K] = float(-poles.real.max())
    error = max(abs(found[K] / float(K) - 1) for K in STIFFNESSES)
    soft, stiff = STIFFNESSES[0], STIFFNESSES[-1]
    spring = float(spec.actuator.spring_stiffness) if isinstance(spec.actuator, SeriesElasticActuator) else np.inf
    slowest = min(damping, key=lambda K: damping[K])
    over = f"{found[stiff]:.3g} over {spring:.3g} N·m/rad"
    seen = (
        Observation("every stiffness rendered with the same Q", f"worst slope {error:.1%} off", error < 0.05),
        Observation("more than the spring's own stiffness", over, found[stiff] > spring),
        Observation(
            "friction shows most at the lowest stiffness", f"{width[soft]:.3g} rad at 0.2, {width[stiff]:.3g} at 10",
            width[soft] == max(width.values()),
        ),
        Observation(
            "0.2 N·m/rad is nearest the limit of stability",
            f"decay {', '.join(f'{damping[K]:.3g} at {float(K):g}' for K in STIFFNESSES)} /s", slowest == soft,
        ),
    )  # fmt: skip
    return Experiment("Fig. 10: stiffnesses with one Q", AXES, tuple(curves), seen)
