"""Bounds that hold frequency by frequency, measured where the joint is worst."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..simulation.adversary import tones
from ..simulation.adversary.finding import Finding
from ..simulation.adversary.stretched import vertices, worst_poles
from ..simulation.equations import Compensator
from ..simulation.members import members
from ..spec.model import Spec
from .proven import Claims, band_of, hints_of, nominal_load, proven

ROUNDING = 1e-6  # relative, of what a run measures


def levels(spec: Spec, C: Compensator, claims: Claims) -> Iterator[Finding]:
    """Bounds that hold frequency by frequency, measured with a sine where the joint is worst."""
    low, high = band_of(spec)
    bandwidth = proven(claims, "bandwidth", "attenuation")
    omega_B = float(bandwidth.margin) if bandwidth and bandwidth.margin else None
    if omega_B:
        level = float(spec.objective.attenuation)
        yield _level(spec, C, "bandwidth attenuation", level, (min(low, omega_B / 100), omega_B), (omega_B,))
        tone = tones.measured(spec, C, nominal_load(spec)[0], omega_B * (1 + 1e-4))
        value = abs(tone.attenuation)
        yield Finding("bandwidth attenuation", "outside", "|1−Q̃| just beyond ω_B", value, level, value > level or None)
    peak, rendering = proven(claims, "peak", "sensitivity"), proven(claims, "rendering", "every-load")
    if peak and peak.margin:
        yield _level(spec, C, "peak sensitivity", float(peak.margin), (low, high), hints_of(peak))
    if rendering and rendering.margin and omega_B:
        yield _level(
            spec,
            C,
            "rendering every-load",
            float(rendering.margin),
            (min(low, omega_B / 100), omega_B),
            hints_of(rendering),
        )
    passive = proven(claims, "eq12", "structured")
    if passive and passive.margin is not None:
        ends = (float(passive.interval[0]) or low, float(passive.interval[1] or high))
        yield _level(spec, C, "eq12 structured", float(passive.margin), ends, hints_of(passive))
    if decay := proven(claims, "stability-free", "hurwitz"):
        slowest = -float(worst_poles(spec, C, nominal_load(spec))[0])
        bound = float(decay.margin or 0)
        yield Finding(
            "stability-free hurwitz", "inside", "slowest decay [/s]", slowest, bound, slowest >= bound * (1 - ROUNDING)
        )


_BADNESS: dict[str, Callable[[Spec], tones.Badness]] = {
    "rendering every-load": tones.rendering_error,
    "eq12 structured": lambda _: tones.yielding,
}
_WORDS = {
    "bandwidth attenuation": "|1−Q̃| of a disturbance",
    "peak sensitivity": "|1−Q̃| of a disturbance",
    "rendering every-load": "|Z/G_imp − 1|",
    "eq12 structured": "Re(Z/jω) [N·m·s/rad]",
}


def _level(
    spec: Spec, C: Compensator, claim: str, bound: float, band: tuple[float, float], hints: tuple[float, ...]
) -> Finding:
    """The worst of all loads and members by their frequency response, then its motion."""
    found = []
    for member in members(spec):
        badness = _BADNESS[claim](member.spec) if claim in _BADNESS else tones.disturbed
        load, omega = tones.worst(member.spec, C, vertices(member.spec), badness, band, hints)
        Z, attenuation = tones.responses(member.spec, C, load[None], np.array([omega]))
        found.append((float(badness(np.array([omega]), Z, attenuation)[0, 0]), member.spec, load, omega, badness))
    _, one, load, omega, badness = max(found, key=lambda each: each[0])
    if worst_poles(one, C, load[None])[0] >= 0:
        return Finding(claim, "information", f"unstable, nothing to measure: load {load.tolist()}", None, bound, None)
    tone = tones.measured(one, C, load, omega)
    value = float(badness(np.array([omega]), np.array([tone.Z]), np.array([tone.attenuation]))[0])
    where = f"{_WORDS[claim]} at {omega:.6g} rad/s, I={load[0]:.4g} B={load[1]:.4g} K={load[2]:.4g}"
    if claim == "eq12 structured":
        return Finding(claim, "inside", where, -value, bound, -value >= bound - ROUNDING * abs(tone.Z / omega))
    return Finding(claim, "inside", where, value, bound, value <= bound * (1 + ROUNDING))
