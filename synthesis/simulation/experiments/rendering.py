"""Figs. 11 and 12: the apparent impedance, estimated from τ_int and θ while many sines push at once."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...spec.model import Spec
from ..batch.run import simulate_batch
from ..batch.switched import Imperfections, switched
from ..equations import Compensator, desired
from ..excitation import multisine
from .experiment import FRICTION, STICTION, Array, Curve, Experiment, Observation, given, rivals, true_load, wishing

FREQUENCIES = np.array([1, 2, 3, 5, 8, 12, 17, 23, 30, 37, 44, 50], dtype=float)  # rad/s: the paper's 0 to 50
TORQUE = 2.0  # N·m, of the sine with the same rms
CYCLE = 2048  # ticks of the lowest frequency
CYCLES = 12  # the first four settle
AXES = ("ω [rad/s]", "|τ_int/θ| [N·m/rad]")
WISHES = ((Fraction(5, 4), Fraction(7, 20)), (Fraction(3), Fraction(1, 4)))  # K_imp, B_imp [published]


def estimated(spec: Spec, C: Compensator) -> NDArray[np.complex128]:
    """`τ_int/θ` at FREQUENCIES with the true load and its friction."""
    sines = multisine(FREQUENCIES, TORQUE)
    hand = [replace(sines.generator, outputs=("contact_torque",))]
    joint = switched(
        spec, C, [true_load(spec)], Imperfections(load_friction=FRICTION, stiction=STICTION), environment=hand
    )
    start = np.zeros(joint.states)
    start[joint.environment] = sines.start
    tick = 2 * np.pi / FREQUENCIES[0] / CYCLE
    run = simulate_batch(
        joint, tick, np.zeros(CYCLES * CYCLE), start=start, sines=FREQUENCIES, since=CYCLES // 3 * CYCLE
    )
    return np.asarray(run.phasors[0, :, 1] / run.phasors[0, :, 0])


def wished(spec: Spec) -> NDArray[np.complex128]:
    """G_imp at FREQUENCIES."""
    wish, s = desired(spec), 1j * FREQUENCIES
    return np.asarray(float(wish.inertia) * s**2 + float(wish.damping) * s + float(wish.stiffness))


def error(spec: Spec, Z: NDArray[np.complex128]) -> Array:
    """`|Z/G_imp − 1|`, (n,)."""
    return np.asarray(abs(Z / wished(spec) - 1))


def fig11(spec: Spec, C: Compensator) -> Experiment:
    """Apparent impedance under (2), (10) and (20)."""
    spec = wishing(spec, *WISHES[0])
    Z = {name: estimated(*each) for name, each in rivals(spec, C).items()}
    off = {name: error(spec, values) for name, values in Z.items()}
    rms = {name: float(np.sqrt(np.mean(values**2))) for name, values in off.items()}
    slow = FREQUENCIES <= 10
    own = "the DOB" if given(spec) == "DOB (10)" else given(spec)
    plain, feedback, dob = off.values()
    curves = [Curve("desired", FREQUENCIES, np.abs(wished(spec)))]
    curves += [Curve(name, FREQUENCIES, np.abs(values)) for name, values in Z.items()]
    ratio = rms[given(spec)] / rms["traditional (2)"]
    lowest = f"error ≤ {dob[slow].max():.3f} up to 10 rad/s, (2) up to {plain[slow].max():.3f}"
    seen = (
        Observation(
            f"{own} is more accurate than (2) at low frequency", lowest, bool(dob[slow].max() < plain[slow].max())
        ),
        Observation(
            "and less than half as wrong over the whole band",
            f"rms error {rms[given(spec)]:.3f} against {rms['traditional (2)']:.3f}",
            ratio < 0.5,
        ),
        Observation(
            "dynamic feedback is moderate at low frequency",
            f"error ≤ {feedback[slow].max():.3f} up to 10 rad/s, (2) up to {plain[slow].max():.3f}",
            bool(feedback[slow].max() < plain[slow].max()),
        ),
        Observation(
            "and worse at high frequency",
            f"{feedback[~slow].max():.3f} above 10 rad/s",
            bool(feedback[~slow].max() > feedback[slow].max()),
        ),
        Observation(
            f"where {own} is better",
            f"{dob[~slow].max():.3f} above 10 rad/s",
            bool(dob[~slow].max() < feedback[~slow].max()),
        ),
    )
    return Experiment("Fig. 11: apparent impedance", AXES, tuple(curves), seen)


def fig12(spec: Spec, C: Compensator) -> Experiment:
    """Two impedances with the same Q."""
    curves, seen = [], []
    for K, B in WISHES:
        one = wishing(spec, K, B)
        Z, name = estimated(one, C), f"K = {float(K):g}, B = {float(B):g}"
        off = error(one, Z)
        curves += [Curve(f"desired, {name}", FREQUENCIES, np.abs(wished(one))), Curve(name, FREQUENCIES, np.abs(Z))]
        rms = float(np.sqrt(np.mean(off**2)))
        seen.append(
            Observation(
                f"{name} rendered accurately",
                f"rms error {rms:.3f}, worst {off.max():.3f} at {FREQUENCIES[off.argmax()]:g} rad/s",
                rms < 0.15,
            )
        )
    return Experiment("Fig. 12: two impedances with one Q", AXES, tuple(curves), tuple(seen))
