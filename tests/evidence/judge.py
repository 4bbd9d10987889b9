"""Every claim of a certificate judged by dense floats: the physics solved at many frequencies and loads."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from instances import at, instances, nominal, perturbed
from physics import Complex, Json, Real, num, numbers, rational_at, system

TOLERANCE = 1e-7  # of floats, relative to the terms compared
LOW, HIGH = 1e-3, 1e6  # rad/s
Slack = tuple[Real, Real]  # right minus left side, and the size of what was compared


class Joint:
    """Responses of one specification's joint with one controller, on a grid of frequencies."""

    def __init__(self, spec: Json, controller: Json, omega: Real) -> None:
        self.spec, self.controller, self.omega = spec, controller, omega
        self.s = 1j * omega
        self.nominal, self.m = (self.stiffness(numbers(spec[key])) for key in ("plant", "impedance"))
        self.free = system(spec, controller, None)
        weight, table = (spec["uncertainty"].get(key) for key in ("weight", "table"))
        self.weight = np.zeros_like(omega) if weight is None else np.abs(rational_at(weight, self.s))
        if table:  # on top of it: 1 + V = (1 + W_w)(1 + W_t)
            points = np.array([[num(value) for value in point] for point in table["points"]])
            self.weight = (1 + self.weight) * (1 + np.interp(omega, *points.T)) - 1

    def stiffness(self, load: Any) -> Complex:
        """`I s² + B s + K`; each of I, B, K a number, or one for every frequency."""
        I, B, K = load  # noqa: E741
        return I * self.s**2 + B * self.s + K

    @cached_property
    def ideal(self) -> Joint:
        """The same joint behind an ideal actuator: no hold either, which belongs to H."""
        spec = {**self.spec, "actuator": {"type": "ideal"}, "sampling": None}
        return Joint(spec, self.controller, self.omega)

    @cached_property
    def wall(self) -> dict[str, Complex]:
        return system(self.spec, self.controller, None, wall=True).response(self.omega, "push")

    @cached_property
    def sensitivity(self) -> Complex:
        """`1 − Q̃`: torque at the wall for a disturbance on the actuator's torque."""
        return -self.wall["τ_int"]

    def port(self, load: Complex) -> Complex:
        """`Z = τ_int/θ` with a load."""
        return 1 / self.free.response(self.omega, "touch", load)["θ"]

    def pushed(self, load: Complex) -> Complex:
        """Torque on the load, from friction, by the motion it causes; nobody touches the port."""
        return 1 / self.free.response(self.omega, "push", load)["θ"]

    @cached_property
    def actuator(self) -> tuple[Complex, Complex]:
        """H and Z_a, from what the actuator does in two situations."""
        locked = system(self.spec, self.controller, None, wall=True).response(self.omega, "command")
        H = locked["τ_act"] / locked["τ_d"]
        moved = self.free.response(self.omega, "touch", self.nominal)
        return H, (H * moved["τ_d"] - moved["τ_act"]) / moved["θ"]

    def loads(self, rng: random.Random, inside: int) -> Iterator[Complex]:
        """The corners of the box, and loads inside it, drawn anew at every frequency."""
        box = self.spec["uncertainty"]["box"]
        if box is None:
            yield self.nominal
            return
        ends = [tuple(map(num, box[key])) for key in ("inertia", "damping", "stiffness")]
        for corner in dict.fromkeys(product(*ends)):
            yield self.stiffness(corner)
        draw = np.random.default_rng(rng.getrandbits(32))
        for _ in range(inside):
            yield self.stiffness([lo + (hi - lo) * draw.random(len(self.omega)) for lo, hi in ends])

    def radius(self, load: Complex) -> Real:
        """The lumped W of a load with the weight on top."""
        W = np.abs(self.nominal / load - 1) if self.spec["uncertainty"]["box"] is not None else 0 * self.omega
        return W + self.weight + W * self.weight


def _below(left: Real, right: Real) -> Slack:
    return right - left, np.abs(left) + np.abs(right)


def _modulus(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    return _below(np.abs(j.sensitivity), np.full_like(j.omega, v))


def _attenuation(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    return _modulus(j, num(j.spec["objective"]["attenuation"]), g, around)


def _eq9(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    return _below(v * j.radius(g) * np.abs(j.ideal.port(0 * g)), np.abs(j.ideal.port(j.nominal)))


def _eq18(form: str, coupling: str) -> Callable[..., Slack]:
    def slack(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
        if coupling == "physical":  # the load's share of the port's motion, and the rest of it
            scale = j.ideal.sensitivity / j.sensitivity / j.nominal
            D0, T = scale * j.port(j.nominal), scale * j.port(0 * g)
        else:
            H, Z_a = j.actuator
            T = H * j.ideal.port(0 * g) / (j.nominal + Z_a)
            D0 = j.ideal.sensitivity + T
        M = {"paper": np.ones_like(D0), "lumped": j.m / j.nominal, "half-plane": D0}[form]
        return _below(np.abs(D0 - M) + v * j.radius(g) * np.abs(T), np.abs(M))

    return slack


def _paper(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    W = v * j.radius(g)
    r = np.where(W < 1, W / (1 - np.minimum(W, 0.999999)), np.inf)
    return _below(np.abs(j.s - j.m) + 2 * r * np.abs(j.ideal.sensitivity * j.nominal), np.abs(j.s + j.m))


def _passive(disc: bool) -> Callable[..., Slack]:
    def slack(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
        true = j.nominal / (1 + around * j.radius(g)) if disc else g / (1 + around * j.weight)
        Y = j.port(true) / j.s
        return Y.real - v, np.abs(Y) + abs(v)

    return slack


def _friction(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    Y = j.pushed(g / (1 + around * j.weight)) / j.s
    return Y.real - v, np.abs(Y) + abs(v)


def _noise(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    """Torque command at the wall for noise of the torque sensor."""
    locked = system(j.spec, j.controller, None, wall=True).response(j.omega, "noise")
    return _below(np.abs(locked["τ_d"]), np.full_like(j.omega, v))


def _rendering(j: Joint, v: float, g: Complex, around: Complex) -> Slack:
    Z = j.port(g / (1 + around * j.weight))
    return v * np.abs(j.m) - np.abs(Z - j.m), np.abs(Z) + np.abs(j.m)


STATEMENTS: dict[tuple[str, str], Callable[[Joint, float, Complex, Complex], Slack]] = {
    ("bandwidth", "attenuation"): _attenuation,
    ("peak", "sensitivity"): _modulus,
    ("eq9", "printed"): _eq9,
    ("eq12", "paper"): _paper,
    ("eq12", "disc"): _passive(True),
    ("eq12", "structured"): _passive(False),
    ("friction", "strictly-positive-real"): _friction,
    ("rendering", "every-load"): _rendering,
    ("noise", "command"): _noise,
    **{
        ("eq18", f"{form}/{coupling}"): _eq18(form, coupling)
        for form in ("paper", "lumped", "half-plane")
        for coupling in ("frozen", "physical")
    },
}
IDEAL = {("eq9", "printed"): "free", ("eq12", "paper"): "locked"}  # they suppose a nominal that is stable like this
WITHOUT_LOAD = {"bandwidth", "peak", "noise"}
STABILITY = {"hurwitz", "winding", "box"}


def decay(spec: Json, controller: Json, end: str) -> float:
    """Decay rate of the slowest mode, in free motion with the nominal load or against a wall."""
    poles = system(spec, controller, numbers(spec["plant"]), wall=end == "locked").poles()
    return float(-max(poles.real, default=-np.inf))


def behind_ideal(spec: Json) -> Json:
    """The nominal joint with an ideal actuator, and nothing sampled."""
    return {**nominal(spec), "actuator": {"type": "ideal"}, "sampling": None}


def _place(text: str) -> float:
    return HIGH if text == "inf" else min(max(num(text), LOW), HIGH)


def judge(certificate: Json, seed: int, points: int = 600, inside: int = 3, phases: int = 3) -> tuple[int, list[str]]:
    """How many claims were judged at their margins and at their twins, and what contradicts them."""
    rng, judged, faults = random.Random(seed), 0, []
    spec, controller = certificate["spec"], certificate["controller"]
    for claim in certificate["claims"]:
        kind, name = (claim["id"], claim["form"]), f"{claim['id']} {claim['form']}"
        judged += kind in STATEMENTS or claim["form"] in STABILITY or claim["id"] == "tolerance"
        if claim["form"] in STABILITY:
            faults += [f"{name}: {fault}" for fault in _stability(spec, controller, claim, rng)]
        if claim["id"] == "tolerance" and claim["status"] == "proven":
            faults += [f"{name}: {fault}" for fault in _tolerance(certificate, claim, rng, points)]
        if kind not in STATEMENTS:
            continue
        if kind in IDEAL and (rate := decay(behind_ideal(spec), controller, IDEAL[kind])) < 1e-9:
            if claim["status"] == "proven" and rate < -1e-9:
                faults.append(f"{name}: proven, behind an ideal actuator a mode grows by {-rate:.3g}")
            continue
        if claim["status"] == "proven" and (claim["interval"][1] == "inf" or num(claim["interval"][1]) >= LOW):
            lo, hi = (_place(end) for end in claim["interval"])
            omega = np.geomspace(lo, max(hi, lo * (1 + 1e-12)), points)
            for one in instances(spec, rng):
                worst = _worst(Joint(one, controller, omega), kind, num(claim["margin"]), rng, inside, phases)
                if worst[0] < -TOLERANCE:
                    faults.append(f"{name}: proven at {claim['margin']}, off by {worst[0]:.3g} at ω = {worst[1]:.9g}")
        witness = claim["refuted_at"]
        if witness and LOW <= (omega := np.inf if witness["omega"] == "inf" else num(witness["omega"])) <= HIGH:
            turns = _turns(spec, kind)
            joint = Joint(at(spec, witness), controller, np.full(4096 if turns else 1, omega))  # every phase of Δ
            load = witness["load"] and joint.stiffness(numbers(witness["load"]))
            worst = _worst(joint, kind, num(witness["value"]), rng, 0, 0, load)
            if worst[0] > (1e-3 if turns else TOLERANCE):
                faults.append(f"{name}: refuted at ω = {omega:.9g}, holds there by {worst[0]:.3g}")
    return judged, faults


def _stability(spec: Json, controller: Json, claim: Json, rng: random.Random) -> Iterator[str]:
    """What the modes say against a claim about them: their decay, or how many do not decay with the hold."""
    end, twin = claim["id"].removeprefix("stability-"), claim["refuted_at"]
    if claim["form"] == "hurwitz":
        rate = decay(nominal(spec), controller, end)
        if claim["status"] == "proven" and rate < num(claim["margin"]) - 1e-5 * max(1, abs(rate)):
            yield f"proven at {num(claim['margin']):.9g}, the slowest mode decays at {rate:.9g}"
        if twin and rate > num(twin["value"]) + 1e-5 * max(1, abs(rate)):
            yield f"refuted, the slowest mode decays at {rate:.9g}"
        return
    v = Fraction(claim["margin"] or 1) if claim["form"] == "box" else Fraction(0)
    for one in instances(spec, rng, v, loads=end == "free"):
        load = numbers(one.get("true load") or one["plant"])
        modes = system(one, controller, load, wall=end == "locked").unstable()
        if claim["status"] == "proven" and modes:
            yield f"proven at {claim['margin']}, {modes} modes do not decay for {one}"
    if twin and claim["form"] == "box":
        one = at(spec, twin)
        load = numbers(twin["load"] or one["plant"])
        if not system(one, controller, load, wall=end == "locked").unstable():
            yield f"refuted, every mode decays at {twin}"


def _tolerance(certificate: Json, claim: Json, rng: random.Random, points: int) -> Iterator[str]:
    """Controllers within the tolerance: stable, and the other required claims at the level asked for."""
    spec = certificate["spec"]
    for _ in range(4):
        controller = perturbed(certificate["controller"], rng, Fraction(claim["margin"]))
        one = nominal(spec)
        for wall in (False, True):
            if modes := system(one, controller, numbers(one["plant"]), wall=wall).unstable():
                yield f"{modes} modes do not decay with {controller}"
        for other in certificate["claims"]:
            kind = (other["id"], other["form"])
            if not other["required"] or kind not in STATEMENTS:
                continue
            lo, hi = (_place(end) for end in other["interval"])
            joint = Joint(one, controller, np.geomspace(lo, max(hi, lo * (1 + 1e-12)), points))
            worst = _worst(joint, kind, required_level(spec, kind), rng, 1, 1)
            if worst[0] < -TOLERANCE:
                yield f"{kind} fails by {worst[0]:.3g} at ω = {worst[1]:.9g} with {controller}"


def required_level(spec: Json, kind: tuple[str, str]) -> float:
    """The level a specification asks of a claim."""
    asked = spec["constraints"]
    levels = {"peak": asked["peak"], "rendering": spec["objective"]["rendering_error"], "bandwidth": "0"}
    levels |= {"noise": (asked.get("noise") or {}).get("gain"), "friction": "0"}
    if kind[0] == "eq12" and kind[1] != "paper":
        return num(asked["eq12"]["margin"])
    return num(levels.get(kind[0]) or "1")


def _turns(spec: Json, kind: tuple[str, str]) -> bool:
    """Whether the claim's slack depends on the phase of Δ, or only on its modulus."""
    shaken = kind[0] in ("friction", "rendering") or kind == ("eq12", "structured")
    disturbed = any(spec["uncertainty"].get(key) is not None for key in ("weight", "table"))
    return kind == ("eq12", "disc") or (shaken and disturbed)


def _worst(
    joint: Joint,
    kind: tuple[str, str],
    v: float,
    rng: random.Random,
    inside: int,
    phases: int,
    load: Complex | None = None,
) -> tuple[float, float]:
    """Least slack relative to the terms, and where; `phases` drawn at each frequency, 0: spread over the grid."""
    worst = (np.inf, 0.0)
    draw, n = np.random.default_rng(rng.getrandbits(32)), len(joint.omega)
    loads = [joint.nominal] if kind[0] in WITHOUT_LOAD else [load] if load is not None else joint.loads(rng, inside)
    for g in loads:
        largest = joint.radius(g) if kind == ("eq12", "disc") else joint.weight
        for _ in range(max(phases, 1) if _turns(joint.spec, kind) else 1):
            around = np.exp(2j * np.pi * (draw.random(n) if phases else np.arange(n) / n))
            with np.errstate(all="ignore"):
                slack, size = STATEMENTS[kind](joint, v, g, around)
                relative = np.where(np.isfinite(slack), slack / size, np.where(slack == -np.inf, -1.0, 1.0))
            if _turns(joint.spec, kind):
                relative = np.where(largest < 1, relative, -1.0)  # 1 + Δ may vanish
            k = int(np.argmin(relative))
            worst = min(worst, (float(relative[k]), float(joint.omega[k])))
    return worst
