"""Every claim: true ones pass, and the same ones made false, for every kind of joint and uncertainty, are caught."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from time import monotonic

import pytest
from certificate_builder import EQ23, certificate, claim, data, dob, find, omega_b, seal, spec, text
from claim_floats import Joint, Json, num

from robimp.synthesis.check import check_bytes
from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.reader import read

WEIGHT = {"numerator": ["1/20", "0"], "denominator": ["1", "100"]}
SPRING: Json = {
    "plant": {"inertia": "3/100", "damping": "1/5", "stiffness": "2"},
    "uncertainty": {
        "box": {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["3/2", "5/2"]},
        "weight": None,
    },
}
SPRING_WEIGHT = {**SPRING, "uncertainty": {**SPRING["uncertainty"], "weight": WEIGHT}}


def filtered(force: str | None, position: str | None, derivative: str | None) -> Json:
    return {"filters": {"force": force, "position": position, "derivative": derivative}}


JOINTS: dict[str, Json] = {
    "series-elastic": {},
    "ideal": {"actuator": {"type": "ideal"}},
    "weight": {"uncertainty": {"box": None, "weight": WEIGHT}},
    "box+weight": {"uncertainty": {"weight": WEIGHT}},
    "spring": SPRING,
    "spring+weight": SPRING_WEIGHT,
    "one filter": {"controller": filtered("500", None, "2000")},
    "force filter": {"controller": filtered("500", "none", None)},
    "two filters": {"controller": filtered("500", "400", "1000")},
}
FORMS = [
    ("eq9", "printed"),
    ("eq12", "paper"),
    ("eq12", "disc"),
    ("eq12", "structured"),
    *(
        ("eq18", f"{form}/{coupling}")
        for form in ("paper", "lumped", "half-plane")
        for coupling in ("frozen", "physical")
    ),
    ("rendering", "every-load"),
    ("peak", "sensitivity"),
    ("friction", "strictly-positive-real"),
]
NOTHING = {"eq9": None, "eq12": None, "eq18": None, "peak": None, "friction": "report"}


def alone(s: Json, kind: str, form: str, margin: str, interval: list[str], twin: Json = None) -> bytes:
    """A certificate with the claims that are always required and this one, not required."""
    cert = certificate(s, EQ23)
    cert["claims"].append(claim(kind, form, interval, margin, False, refuted_at=twin))
    return data(seal(cert))


def extreme(s: Json, kind: str, form: str, interval: list[str]) -> tuple[float, float]:
    """The float margin on a fine grid (27 loads at each frequency, 729 if the spring can resonate), and where it is."""
    steps = 9 if s["plant"]["stiffness"] != "0" and kind in ("eq9", "eq18") else 3
    sign = -1 if kind in ("peak", "rendering") else 1
    lo, hi = max(num(interval[0]), 1e-3), 1e6 if interval[1] == "inf" else num(interval[1])

    def margins(grid: list[float], steps: int) -> list[tuple[float, float]]:
        return sorted((sign * Joint(s, EQ23, w).margin(kind, form, steps), w) for w in grid)

    best = margins([lo * (hi / lo) ** (k / 240) for k in range(241)], 2)[:6]
    fine = {min(max(w * (1 + k * 2e-3), lo), hi) for _, w in best for k in range(-20, 21)}
    best = margins(sorted(fine), 2)[:6]
    value, omega = min(best + margins([w for _, w in best], steps))
    return sign * value, omega


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize(("kind", "form"), FORMS)
def test_margin_is_proven_below_and_refuted_above_the_floats(name: str, kind: str, form: str) -> None:
    s = spec(**{"constraints": NOTHING, **JOINTS[name]})
    both = s["uncertainty"]["box"] and s["uncertainty"]["weight"]
    proven = text(omega_b(s, EQ23) * (1 - 1e-5), 5)
    interval = {"eq12": ["1/2", "5"], "rendering": ["0", proven]}.get(kind, ["0", "inf"])
    value, omega = extreme(s, kind, form, interval)
    if kind == "eq12" and form != "structured" and both:
        assert check_bytes(alone(s, kind, form, "1", interval)).exit_code == 6
        return
    signed = kind == "eq12" and form != "paper"
    if not math.isfinite(value) or (value <= 1e-6 and not signed):
        assert check_bytes(alone(s, kind, form, "1/1000", interval)).exit_code == 4
        return
    step = abs(value) * 3e-3 * (-1 if kind in ("peak", "rendering") else 1)
    good = check_bytes(alone(s, kind, form, text(value - step, 9), interval))
    assert good.exit_code == 0, good.message
    bad = check_bytes(alone(s, kind, form, text(value + step, 9), interval))
    assert bad.exit_code == 4 and bad.message.startswith(f"{kind} {form}: does not hold")
    omega = min(max(omega, num(interval[0])), math.inf if interval[1] == "inf" else num(interval[1]))
    if 1e-2 < omega < 1e5:
        where = {"value": text(value + step, 9), "omega": text(omega, 12), "load": None}
        twin = check_bytes(alone(s, kind, form, text(value - step, 9), interval, where))
        assert twin.exit_code == 0, twin.message
        lie = {**where, "value": text(value - step, 9)}
        assert check_bytes(alone(s, kind, form, text(value - step, 9), interval, lie)).exit_code == 4


@pytest.mark.parametrize("name", ["series-elastic", "ideal", "weight", "box+weight", "spring+weight", "two filters"])
@pytest.mark.parametrize(("kind", "form"), FORMS)
def test_exact_formula_equals_the_float_formula_at_random_frequencies(name: str, kind: str, form: str) -> None:
    """For one load at one frequency the statement holds on one side of the float margin, fails on the other."""
    s = spec(**{"constraints": NOTHING, **JOINTS[name]})
    if kind == "eq12" and form != "structured" and s["uncertainty"]["weight"]:
        s["uncertainty"]["box"] = None
    prover = CellProver(read(data(certificate(s, EQ23))), monotonic() + 20)
    rng, box, checked = random.Random(f"{name}{kind}{form}"), s["uncertainty"]["box"], 0
    for _ in range(40):
        omega = Fraction(f"{math.exp(rng.uniform(-1, 6)):.4g}")
        ends = [[Fraction(v) for v in box[k]] for k in ("inertia", "damping", "stiffness")] if box else []
        load = tuple(lo + (hi - lo) * Fraction(rng.randint(0, 7), 7) for lo, hi in ends) or None
        value = Joint(s, EQ23, float(omega)).margin(kind, form, load=load and tuple(map(float, load)))
        if not math.isfinite(value) or (value <= 1e-6 and not (kind == "eq12" and form != "paper")):
            continue

        def holds(v: float, load: tuple[Fraction, ...] | None = load, omega: Fraction = omega) -> bool:
            parameters = load and dict(zip(("inertia", "damping", "stiffness"), load, strict=True))
            return not prover.fault((kind, form), Fraction(v), (omega, omega), False, {"load": parameters})

        step = 1e-7 * max(abs(value), 1e-2)
        upper = kind in ("peak", "rendering")
        assert (holds(value - step), holds(value + step)) == ((False, True) if upper else (True, False))
        checked += 1
    assert checked >= 5


def test_the_edge_of_the_box_matters_where_the_load_can_resonate() -> None:
    """Inside a wide stiffness range |ĝ/g − 1| exceeds its corner values: without the edge a false claim passes."""
    s = spec(
        constraints=NOTHING,
        actuator={"type": "ideal"},
        plant={"inertia": "3/100", "damping": "1/5", "stiffness": "10"},
        uncertainty={"box": {"inertia": ["3/100", "3/100"], "damping": ["1/5", "1/5"], "stiffness": ["5", "40"]}},
    )
    loads = [(0.03, 0.2, 5 + k / 4) for k in range(141)]
    at = Joint(s, EQ23, 25.0)
    brute = min(at.margin("eq9", "printed", load=load) for load in loads)
    corners = at.margin("eq9", "printed", 2)
    assert brute < 0.7 * corners
    prover = CellProver(read(data(certificate(s, EQ23))), monotonic() + 20)

    def proven(v: float) -> bool:
        return not prover.fault(("eq9", "printed"), Fraction(v), (Fraction(25), Fraction(25)), False)

    assert proven(brute * 0.99) and not proven(brute * 1.01)


@pytest.mark.parametrize(("radius", "code"), [("9/10", 0), ("3/2", 4)])
def test_passivity_over_a_disc_needs_a_radius_below_one_whatever_the_factor(radius: str, code: int) -> None:
    weight = {"numerator": [radius], "denominator": ["1"]}
    s = spec(constraints=NOTHING, uncertainty={"box": None, "weight": weight})
    assert check_bytes(alone(s, "eq12", "paper", "1/1000", ["1", "2"])).exit_code == code


SOFT: Json = {
    "plant": {"inertia": "3/100", "damping": "1/5", "stiffness": "10"},
    "impedance": {"inertia": "3/100", "damping": "7/20", "stiffness": "1/2"},
    "uncertainty": {"box": {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["4", "16"]}},
}
LIGHT: Json = {"actuator": {"type": "ideal"}, "impedance": {"inertia": "1/1000", "damping": "7/20", "stiffness": "5/4"}}


@pytest.mark.parametrize(
    ("change", "text", "band"), [(SOFT, "Z(0)", ["1/100", "inf"]), (LIGHT, "infinity", ["0", "1000"])]
)
def test_poles_of_the_port_at_zero_and_infinity_must_be_passive(change: Json, text: str, band: list[str]) -> None:
    """Re[Z/jω] is bounded, but Z(0) < 0 (a soft wish on a stiff joint) or Z/s² → negative: false on 0..inf only."""
    s = spec(constraints=NOTHING, **change)
    verdict = check_bytes(alone(s, "eq12", "structured", "-100", ["0", "inf"]))
    assert verdict.exit_code == 4 and text in verdict.message
    claims = {
        (kind, form): status
        for kind, form, status, _ in check_bytes(alone(s, "eq12", "structured", "-100", band)).claims
    }
    assert claims["eq12", "structured"] == "proven"
    assert (
        claims["stability-free", "box"] == "not verified"
    )  # the same sign change lets a root of N pass through 0 or ∞


def test_a_loop_that_is_not_well_posed_is_not_stable() -> None:
    """Ideal actuator: 1 + HCF(∞) = 0 is a root at infinity; below 0 any lag H/(1 + εs) makes one at about +1/ε."""
    s = spec(constraints=NOTHING, actuator={"type": "ideal"}, controller={"type": "dynamic-feedback"})
    cert = certificate(s, {"type": "dynamic-feedback", "C": {"numerator": ["2000"], "denominator": ["1", "70", "500"]}})
    for C, expected in ((["-1", "2000"], True), (["-99/100", "2000"], False), (["-3", "-2000"], True)):
        cert["controller"]["C"] = {"numerator": C, "denominator": ["1", "500"]}
        message = {kind: said for kind, _, _, said in check_bytes(data(seal(cert))).claims}["stability-locked"]
        assert ("any lag of the actuator" in message) == expected


def gain(above: str, below: str) -> Json:
    """A two-port that gives this share of the torque at once, without an impedance of its own."""
    share, none = ({"numerator": [n], "denominator": [below]} for n in (above, "0"))
    return {"type": "two-port", "transfer": share, "impedance": none}


@pytest.mark.parametrize(
    ("transfer", "C", "expected"),
    [  # for ω → ∞ 1 + HA/(g + Z_a) is 1 + H (C m/ĝ − (1 − m/ĝ)), m/ĝ = 1/10: for H = 2 it is (C − 4)/5
        ("2", "0", "any lag of the actuator"),
        ("2", "399/100", "any lag of the actuator"),
        ("2", "4", "any lag of the actuator"),
        ("2", "401/100", "a root does not decay"),
        ("1", "0", "proven"),
    ],
)
def test_in_free_motion_too(transfer: str, C: str, expected: str) -> None:
    """N = (s + 5)(ĝ − H (ĝ − m)) + H (C s + 5) m: below 4 all its coefficients are negative for H = 2."""
    s = spec(
        constraints=NOTHING,
        plant={"inertia": "1/20", "damping": "3/10", "stiffness": "1"},
        uncertainty={"box": {"inertia": ["1/20", "1/20"], "damping": ["3/10", "3/10"], "stiffness": ["1", "1"]}},
        impedance={"inertia": "1/200", "damping": "1/50", "stiffness": "1/50"},
        actuator=gain(transfer, "1"),
        controller={"type": "dynamic-feedback"},
        objective={"attenuation": "1/2"},
    )
    cert = certificate(s, {"type": "dynamic-feedback", "C": {"numerator": ["5"], "denominator": ["1", "5"]}})
    cert["controller"]["C"]["numerator"] = [C, "5"]
    said = {(kind, form): said for kind, form, _, said in check_bytes(data(seal(cert))).claims}
    assert expected in said["stability-free", "hurwitz"]
    assert "a lag" not in said["stability-locked", "hurwitz"]


@pytest.mark.parametrize(("pole", "stable"), [("1", True), ("-1", False)])
@pytest.mark.parametrize("sampling", [None, {"rate": "100000", "delay": "0"}])
def test_what_speaks_of_an_ideal_actuator_supposes_a_joint_that_is_stable_behind_one(
    pole: str, stable: bool, sampling: Json
) -> None:
    """H = 1/2, Q = (80 − 10 s)/(s² + pole s + 100): 1 + HCF and N have no root on the right, but d_Q may have."""
    s = spec(
        constraints=NOTHING | {"eq9": {}, "eq12": {"form": "paper", "band": ["1", "2"], "margin": "0"}},
        plant={"inertia": "1", "damping": "2", "stiffness": "1"},
        uncertainty={"box": None, "weight": {"numerator": ["1/200"], "denominator": ["1"]}},
        impedance={"inertia": "1/10", "damping": "1/5", "stiffness": "1/10"},
        actuator=gain("1", "2"),
        objective={"attenuation": "2/5"},
    )
    s["sampling"] = sampling
    verdict = check_bytes(data(certificate(s, dob(["-10", "80"], ["1", pole, "100"]), decay="1/10")))
    said = {(kind, form): said for kind, form, _, said in verdict.claims}
    ideal = "does not hold: behind an ideal actuator a root does not decay at the stated rate"
    assert (verdict.exit_code == 0) == stable
    for kind in (("eq9", "printed"), ("eq12", "paper")):
        assert said[kind] == f"{' '.join(kind)}: {'proven' if stable else ideal}"
    assert {said[kind][-6:] for kind in said if kind[0].startswith("stability")} == {"proven"}


@pytest.mark.parametrize(("k", "stable"), [("7", True), ("799/100", False)])
@pytest.mark.parametrize("motor", [None, {"motor_inertia": ["9/1000", "11/1000"]}])
def test_and_so_for_every_controller_within_the_tolerance(k: str, stable: bool, motor: Json) -> None:
    """C = k/(s+1)³: 1 + C has roots on the axis at k = 8, within 1 % of 7.99; a band away from √3 misses them."""
    s = spec(
        constraints=NOTHING | {"eq12": {"form": "paper", "band": ["1/2", "3/5"], "margin": "0"}, "tolerance": "1/100"},
        plant={"inertia": "1", "damping": "1", "stiffness": "0"},
        uncertainty={"box": None, "weight": {"numerator": ["1/100"], "denominator": ["1"]}, "actuator": motor},
        impedance={"inertia": "1", "damping": "2", "stiffness": "1"},
        controller={"type": "dynamic-feedback"},
        objective={"attenuation": "1/2"},
        **({} if motor else {"actuator": gain("1", "2")}),
    )
    C = {"numerator": [k], "denominator": ["1", "3", "3", "1"]}
    cert = certificate(s, {"type": "dynamic-feedback", "C": C}, decay="0")
    cert["bandwidth"]["proven"] = "1/10"  # which is in the tolerance
    for claimed in (c for c in cert["claims"] if c["id"] == "bandwidth"):
        claimed.update(margin="1/10", interval=["0", "1/10"])
    said = {kind: said for kind, _, _, said in check_bytes(data(seal(cert))).claims}
    assert said["eq12"] == "eq12 paper: proven"
    assert ("tolerance coefficients: proven" in said["tolerance"]) == stable, said


def test_the_reference_controller_is_proven_with_the_known_bandwidth() -> None:
    verdict = check_bytes(data(certificate(spec(), EQ23)))
    assert verdict.exit_code == 0 and verdict.omega_b is not None
    assert 8.87 < float(verdict.omega_b) < 8.89
    assert [status for _, _, status, _ in verdict.claims] == ["proven"] * 8


@pytest.mark.parametrize("factor", [Fraction(7), Fraction(1, 1000)])
def test_scaling_time_scales_the_bandwidth_only(factor: Fraction) -> None:
    """s → s/a: I a⁻², B a⁻¹, and the controller's coefficients with them; stiffnesses, factors and ratios stay."""
    s, cert = spec(), certificate(spec(), EQ23)

    def scaled(value: str, power: int) -> str:
        return str(Fraction(value) / factor**power)

    for section in (s["plant"], s["impedance"]):
        section.update(inertia=scaled(section["inertia"], 2), damping=scaled(section["damping"], 1))
    box = s["uncertainty"]["box"]
    box["inertia"] = [scaled(v, 2) for v in box["inertia"]]
    box["damping"] = [scaled(v, 1) for v in box["damping"]]
    actuator, loop = s["actuator"], s["actuator"]["torque_loop"]
    actuator.update(
        motor_inertia=scaled(actuator["motor_inertia"], 2), motor_damping=scaled(actuator["motor_damping"], 1)
    )
    loop.update(kd=scaled(loop["kd"], 1), derivative_corner=scaled(loop["derivative_corner"], -1))
    controller = dob([str(2000 * factor**2)], ["1", str(Fraction(283, 4) * factor), str(2500 * factor**2)])
    cert.update(spec=s, controller=controller)
    proven = scaled(cert["bandwidth"]["proven"], -1)
    cert["bandwidth"]["proven"] = proven
    for entry in cert["claims"]:
        if entry["form"] == "hurwitz":
            entry["margin"] = scaled(entry["margin"], -1)
        if entry["id"] == "bandwidth":
            entry.update(margin=proven, interval=["0", proven])
        if entry["id"] == "eq12":
            entry["margin"] = scaled(entry["margin"], 1)
    assert check_bytes(data(seal(cert))).exit_code == 0
    find(cert, "eq12")["margin"] = text(num(find(cert, "eq12")["margin"]) * 1.01, 9)
    assert check_bytes(data(seal(cert))).exit_code == 4


def test_a_common_factor_in_the_controller_changes_nothing_if_stable() -> None:
    cert = certificate(spec(), EQ23)
    for root, code in ((Fraction(30), 0), (Fraction(-30), 4)):
        n = ["2000", str(2000 * root)]
        d = ["1", str(Fraction(283, 4) + root), str(2500 + Fraction(283, 4) * root), str(2500 * root)]
        cert["controller"] = dob(n, d)
        assert check_bytes(data(seal(cert))).exit_code == code


def test_a_needle_between_any_grid_points_is_found() -> None:
    """A notch of width 1e-9 in Q: C peaks there, |1 − Q̃| follows; the smooth part alone is proven."""
    s = spec(actuator={"type": "ideal"}, constraints={**NOTHING, "peak": "2"})
    cert = certificate(s, EQ23)
    assert check_bytes(data(cert)).exit_code == 0
    z = Fraction(1, 10**9)
    resonance = [Fraction(1), 2 * z * 200, Fraction(40000)]
    bumped = [Fraction(1), 20 * z * 200, Fraction(40000)]  # ten times the damping above: +20 dB at 200 rad/s
    n = [2000 * c for c in bumped]
    d: list[Fraction] = [Fraction(0)] * 5
    for i, a in enumerate([Fraction(1), Fraction(283, 4), Fraction(2500)]):
        for j, b in enumerate(resonance):
            d[i + j] += a * b
    cert["controller"] = dob([str(c) for c in n], [str(c) for c in d])
    for end in ("free", "locked"):
        find(cert, f"stability-{end}")["margin"] = "0"
    q_at = abs(2000 / complex(2500 - 40000, 283 / 4 * 200))
    find(cert, "peak")["margin"] = text(1.3, 3)
    message = check_bytes(data(seal(cert))).message
    assert 10 * q_at > 0.4 and "peak" in message and "200.000" in message


def test_dynamic_feedback_is_checked_with_its_own_compensator() -> None:
    s = spec(controller={"type": "dynamic-feedback"}, constraints={**NOTHING, "peak": "2"})
    C = {"numerator": ["2000"], "denominator": ["1", "283/4", "500"]}  # what the observer's Q/(1−Q) is
    cert = certificate(s, {"type": "dynamic-feedback", "C": C})
    assert check_bytes(data(cert)).exit_code == 0
    cert["spec"]["controller"]["type"] = "dob"
    assert check_bytes(data(seal(cert))).exit_code == 6
