# ruff: noqa: E501  (tables of edits, one a line)
"""Sampling, ranges of impedance and actuator, tables, two-ports, noise and coefficients: true and false certificates."""

from __future__ import annotations

import copy
import math
import random
from fractions import Fraction
from math import inf
from pathlib import Path
from time import monotonic

import numpy as np
import pytest
from certificate_builder import (
    EQ23,
    FALLING,
    certificate,
    claim,
    data,
    dob,
    find,
    points,
    seal,
    slack_of,
    spec,
    text,
    worst,
)
from claim_floats import Joint, Json, num

from robimp.synthesis.check import check_bytes
from robimp.synthesis.check.enclosure import claims
from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.reader import read

SAMPLED: Json = {"sampling": {"rate": "1000", "delay": "1/1000"}}
RANGE: Json = {"impedance": {"inertia": "3/100", "damping": "7/20", "stiffness": ["1", "3/2"]}}
MOTOR: Json = {
    "uncertainty": {"actuator": {"motor_inertia": ["19/2000", "21/2000"], "spring_stiffness": ["23/5", "5"]}}
}
TABLE: Json = {
    "uncertainty": {
        "box": None,
        "table": {"points": [["10", "1/10"], ["100", "1/5"], ["1000", "2/5"]], "beyond": "hold"},
    }
}
LIMITS: Json = {"eq12": None, "eq9": None, "eq18": None, "peak": "2", "friction": "report"}
ALL: Json = {"eq9": {}, "eq12": {"form": "structured", "band": ["1", "300"], "margin": "0"}}
CASES: dict[str, Json] = {
    "sampled": SAMPLED,
    "range": RANGE,
    "motor": MOTOR,
    "sampled range": {**SAMPLED, **RANGE},
    "sampled range motor": {**SAMPLED, **RANGE, **MOTOR},
    "sampled filters": {
        **SAMPLED,
        "controller": {"filters": {"force": "500", "position": "400", "derivative": "2000"}},
    },
    "table": {**TABLE, "constraints": {"eq12": None}},
    "noise": {"constraints": {"noise": {"gain": "30", "above": "200"}}},
    "sampled noise": {**SAMPLED, "constraints": {"noise": {"gain": "50"}}},
}


def verdict(cert: Json) -> int:
    return check_bytes(data(seal(cert))).exit_code


@pytest.mark.parametrize("name", CASES)
def test_true_certificates_pass_and_each_margin_a_little_harder_does_not(name: str) -> None:
    s = spec(**CASES[name])
    cert = certificate(s, EQ23)
    found = check_bytes(data(cert))
    assert found.exit_code == 0, found.message
    tight = copy.deepcopy(cert)  # every margin harder at once: each claim is judged on its own
    tight["claims"] = [c for c in tight["claims"] if c["required"]]
    harder = [c for c in tight["claims"] if c["form"] not in ("hurwitz", "winding", "box")]
    for entry in harder:
        margin = num(entry["margin"])
        step = (1.5 * slack_of(s) + 2e-3) * abs(margin) * (-1 if entry["id"] in FALLING else 1)
        entry["margin"] = text(margin + step, 9)
        if entry["id"] == "bandwidth":
            entry["interval"], tight["bandwidth"]["proven"] = ["0", entry["margin"]], entry["margin"]
    bad = check_bytes(data(seal(tight)), time_limit=20)
    assert bad.exit_code in (4, 5)
    refused = {(kind, form) for kind, form, status, _ in bad.claims if status == "not verified"}
    assert refused == {(entry["id"], entry["form"]) for entry in harder}


@pytest.mark.parametrize("name", ["sampled", "range", "motor", "sampled range motor", "table"])
def test_at_random_points_cells_say_what_floats_say(name: str) -> None:
    s = spec(**CASES[name])
    prover = CellProver(read(data(certificate(s, EQ23))), monotonic() + 100)
    rng, checked = random.Random(name), 0
    for kind, form in (
        ("eq9", "printed"), ("eq18", "half-plane/physical"), ("eq18", "paper/frozen"), ("eq12", "structured"),
        ("eq12", "paper"), ("eq12", "disc"), ("peak", "sensitivity"), ("rendering", "every-load"), ("noise", "command"),
        ("friction", "strictly-positive-real"), ("eq18", "lumped/physical"),
    ):  # fmt: skip
        for _ in range(6):
            omega = Fraction(f"{math.exp(rng.uniform(-1, 6)):.4g}")
            point = rng.choice(points(s, 3))
            value = Joint(s, EQ23, float(omega), point).margin(kind, form)
            if (
                not math.isfinite(value)
                or (value <= 1e-6 and kind not in ("eq12", "friction"))
                or (form == "paper" and value < 1e-6)
            ):
                continue
            witness: Json = {"load": None}
            for section, given in point.items():
                base = (
                    s[section]
                    if section == "impedance"
                    else {k: s[section][k] for k in ("motor_inertia", "motor_damping", "spring_stiffness")}
                )
                middle = {k: num(v) if isinstance(v, str) else sum(map(num, v)) / 2 for k, v in base.items()}
                witness[section] = {k: Fraction(v).limit_denominator(10**9) for k, v in {**middle, **given}.items()}
            step = 1e-6 * max(abs(value), 1e-2) * (-1 if kind in FALLING else 1)
            assert not prover.fault((kind, form), Fraction(value - step), (omega, omega), False, witness), (kind, form)
            assert prover.fault((kind, form), Fraction(value + step), (omega, omega), False, witness), (kind, form)
            checked += 1
    assert checked > 30


def random_joint(rng: random.Random) -> tuple[Json, Json]:
    def about(value: float, share: float) -> str:
        return text(value * math.exp(rng.uniform(-share, share)), 3)

    w, zeta, alpha = rng.uniform(10, 90), rng.uniform(0.3, 1), rng.uniform(0.3, 0.95)
    changes: Json = {
        "plant": {"inertia": about(0.03, 0.3), "damping": about(0.2, 0.3), "stiffness": rng.choice(["0", "1/2"])}
    }
    I, B, K = (Fraction(v) for v in changes["plant"].values())  # noqa: E741
    changes["uncertainty"] = {
        "box": {
            "inertia": [str(I * 4 / 5), str(I * 6 / 5)],
            "damping": [str(B * 3 / 4), str(B * 5 / 4)],
            "stiffness": [str(K), str(K * 5 / 4)],
        },
        "actuator": rng.choice([None, {"motor_inertia": ["9/1000", "11/1000"]}]),
        "weight": rng.choice([None, None, {"numerator": ["1/20", "0"], "denominator": ["1", "100"]}]),
    }
    changes["sampling"] = rng.choice([None, {"rate": about(800, 0.5), "delay": about(0.002, 1.0)}])
    changes["impedance"] = {
        "inertia": changes["plant"]["inertia"],
        "damping": about(0.35, 0.4),
        "stiffness": rng.choice(["5/4", ["4/5", "2"]]),
    }
    changes["constraints"] = {
        **LIMITS,
        "eq9": {},
        "eq18": {"form": "half-plane", "coupling": "physical"},
        "eq12": {"form": "structured", "band": ["1", "100"], "margin": "0"},
    }
    Q = dob([text(alpha * w * w, 5)], ["1", text(2 * zeta * w, 5), text(w * w, 5)])
    return spec(**changes), Q


@pytest.mark.parametrize("seed", range(12))
def test_random_joints_nothing_is_proven_that_floats_violate(seed: int) -> None:
    rng = random.Random(seed)
    s, controller = random_joint(rng)
    try:
        cert = certificate(s, controller)
    except AssertionError:  # no bandwidth
        return
    said = {(k, f): status for k, f, status, _ in check_bytes(data(cert), time_limit=10).claims}
    if not said:  # a required level is missed
        return
    for entry in cert["claims"]:
        kind, form = entry["id"], entry["form"]
        if form in ("winding", "hurwitz"):
            roots = right_half_plane(s, controller, kind)
            assert said[kind, form] != "proven" or roots == 0
            assert form == "hurwitz" or said[kind, form] == "proven" or roots > 0
        elif form != "box" and kind != "bandwidth" and said[kind, form] == "proven":
            lo, hi = (num(v) if v != "inf" else 1e4 for v in entry["interval"])
            value, margin = worst(s, controller, kind, form, lo, hi, 3), num(entry["margin"])
            assert value <= margin if kind in FALLING else value >= margin


def right_half_plane(s: Json, controller: Json, kind: str, point: Json = None, load: Json = None) -> int:
    """Roots on the right by a float winding of the loop's own functions on a fine grid; poles by roots of C's and d."""

    def value(w: float) -> complex:
        j = Joint(s, controller, w, point)
        f = 1 + j.L
        if kind == "stability-free":
            f = j.Z0(tuple(load.values()) if load else j.nominal) + j.L * j.R * j.m  # type: ignore[arg-type]
            f /= j.s**2 + 20 * j.s + 100
        return f * poles(j.s)

    def poles(z: complex) -> complex:  # denominators: of C, of the actuator, over Hurwitz ones of the same degree
        d = np.polyval([num(c) for c in controller["C"]["denominator"]], z)
        n = len(controller["C"]["denominator"]) - 1
        a = s["actuator"]
        t = a["torque_loop"]
        lag = 1 + z / num(t["derivative_corner"])
        motor = (num(a["motor_inertia"]) * z**2 + num(a["motor_damping"]) * z) * lag
        inner = motor + num(a["spring_stiffness"]) * (lag * (1 + num(t["kp"])) + num(t["kd"]) * z)
        return complex(d * inner / (z + 30) ** (n + 3))

    w = np.concatenate([np.linspace(1e-6, 1, 400), np.geomspace(1, 1e5, 30000)])
    angle = np.unwrap(np.angle([value(x) for x in w]))
    return round(-(angle[-1] - angle[0]) / math.pi)


@pytest.mark.parametrize("delay", ["0", "1/200", "1/100", "1/50", "1/20", "3/20"])
@pytest.mark.parametrize("gain", ["1", "5"])
def test_winding_counts_the_roots_that_pade_counts(delay: str, gain: str) -> None:
    """Roots on the right with the hold as the average of a Padé delay of order 10; free and locked."""
    s = spec(sampling={"rate": "200", "delay": delay}, constraints=LIMITS)
    s["controller"]["type"] = "dynamic-feedback"
    C = {"numerator": [str(2000 * int(gain))], "denominator": ["1", "283/4", "500"]}
    cert = certificate(
        spec(constraints=LIMITS, controller={"type": "dynamic-feedback"}), {"type": "dynamic-feedback", "C": C}
    )
    cert["spec"] = s
    for end in ("free", "locked"):
        find(cert, f"stability-{end}").update(form="winding", margin="0")
    prover = CellProver(read(data(seal(cert))), monotonic() + 20)
    for kind in ("stability-free", "stability-locked"):
        text = prover.fault((kind, "winding"), Fraction(0), (Fraction(0), math.inf), True)
        expected = pade_roots(s, C, kind)
        assert text == (f": {expected} roots with Re s > 0" if expected else ""), (kind, text, expected)


def pade_roots(s: Json, C: Json, kind: str) -> int:
    a, t, P = s["actuator"], s["actuator"]["torque_loop"], np.poly1d
    lag, k = P([1 / num(t["derivative_corner"]), 1]), num(a["spring_stiffness"])
    Ct = num(t["kp"]) * lag + P([num(t["kd"]), 0])
    motor = P([num(a["motor_inertia"]), num(a["motor_damping"]), 0]) * lag
    n_H, n_Z, d = k * (Ct + lag * num(t["feedforward"])), k * motor, motor + k * (lag + Ct)
    n_C, d_C = (P([num(v) for v in C[key]]) for key in ("numerator", "denominator"))
    g, m = (P([num(v) for v in s[key].values()]) for key in ("plant", "impedance"))
    T, delay, order = 1 / num(s["sampling"]["rate"]), num(s["sampling"]["delay"]), 10

    def pade(x: float) -> tuple[np.poly1d, np.poly1d]:
        c = [
            math.factorial(2 * order - i)
            * math.factorial(order)
            / (math.factorial(2 * order) * math.factorial(i) * math.factorial(order - i))
            for i in range(order + 1)
        ]
        return P([c[i] * (-x) ** i for i in reversed(range(order + 1))]), P(
            [c[i] * x**i for i in reversed(range(order + 1))]
        )

    (a1, b1), (a2, b2) = pade(T), pade(delay)  # hold = (b1 − a1)/(b1 s T) · a2/b2
    top, rest = (b1 - a1).c, P([1])
    n_h, d_h = P(top[:-1]) * a2, b1 * T * b2 * rest
    E, U = d * d_C, n_C * m - d_C * (g - m)
    f = E * d_h + n_H * n_C * n_h if kind == "stability-locked" else (E * g + n_Z * d_C) * d_h + n_H * U * n_h
    return int(sum(f.roots.real > 1e-6))


def test_delay_turns_a_passive_stable_joint_into_neither() -> None:
    base = certificate(spec(), EQ23)
    assert verdict(base) == 0
    for delay, codes in (("1/2000", (0,)), ("1/50", (4,)), ("1/5", (4,))):
        cert = copy.deepcopy(base)
        cert["spec"]["sampling"] = {"rate": "1000", "delay": delay}
        for end in ("free", "locked"):
            find(cert, f"stability-{end}").update(form="winding", margin="0")
        for entry in cert["claims"]:  # at the required levels
            entry["margin"] = {"eq12": "0", "eq9": "1", "eq18": "1", "peak": "2"}.get(entry["id"], entry["margin"])
            if entry["id"] == "bandwidth":
                entry.update(margin="5", interval=["0", "5"])
        cert["bandwidth"]["proven"] = "5"
        found = check_bytes(data(seal(cert)))
        assert found.exit_code in codes, found.message
        said = {(kind, form): status for kind, form, status, _ in found.claims}
        if delay != "1/2000":
            assert said["eq12", "structured"] == "not verified"
        if delay == "1/5":
            assert said["stability-locked", "winding"] == "not verified"


def test_without_delay_at_a_very_high_rate_the_margins_are_the_classic_ones() -> None:
    classic = certificate(spec(), EQ23)
    cert = copy.deepcopy(classic)
    cert["spec"]["sampling"] = {"rate": "1000000000000", "delay": "0"}
    for end in ("free", "locked"):
        find(cert, f"stability-{end}").update(form="winding", margin="0")
    assert verdict(classic) == 0 and verdict(cert) == 0
    for kind in ("eq9", "eq12", "eq18", "peak"):
        for c in (classic, cert):
            harder = copy.deepcopy(c)
            entry = find(harder, kind)
            entry["margin"] = text(num(entry["margin"]) * (0.996 if kind == "peak" else 1.004), 9)
            assert verdict(harder) == 4


def test_the_box_is_scaled_and_its_witness_is_an_unstable_load() -> None:
    """The wall-side of the load: with enough negative damping, far outside the box, the free joint is unstable."""
    cert = certificate(spec(), EQ23)
    box = find(cert, "stability-free", "box")
    codes = {}
    for v in ("1", "2", "3", "4", "8"):
        box["margin"] = v
        codes[v] = verdict(cert)
    assert codes["1"] == codes["2"] == 0 and codes["8"] == 5
    box["margin"] = "1"
    plant = {"inertia": Fraction(3, 100), "damping": Fraction(1, 5), "stiffness": Fraction(0)}

    def witness(v: str, damping: str, inertia: str = "3/100") -> int:
        load = {"inertia": inertia, "damping": damping, "stiffness": "0"}
        box["refuted_at"] = {"value": v, "omega": "3", "load": load}
        return verdict(cert)

    assert plant["damping"] == Fraction(1, 5)
    assert witness("100", "-5") == 0  # inside the box scaled by 100, and unstable
    assert witness("100", "1/5") == 4  # stable: a false witness
    assert witness("2", "-5") == 4  # outside the scaled box
    assert "is not in the box" in check_bytes(data(seal(cert))).message


def test_noise_and_two_port() -> None:
    s = spec(constraints={"noise": {"gain": "30", "above": "200"}})
    a = s["actuator"]
    lag, k = np.poly1d([1 / 1000, 1]), 4.8
    Ct, motor = 10 * lag + np.poly1d([0.25, 0]), np.poly1d([0.01, 0.05, 0]) * lag
    d = [text(Fraction(f"{c:.12g}")) for c in (motor + k * (lag + Ct)).c]
    transfer = {"numerator": [text(Fraction(f"{c:.12g}")) for c in (k * (Ct + lag)).c], "denominator": d}
    port = {
        "type": "two-port",
        "transfer": transfer,
        "impedance": {"numerator": [text(Fraction(f"{c:.12g}")) for c in (k * motor).c], "denominator": d},
    }
    assert a["type"] == "series-elastic"
    cert = certificate(s, EQ23)
    assert verdict(cert) == 0
    cert["spec"]["actuator"] = port
    assert verdict(cert) == 0  # the same joint
    cert["spec"]["actuator"]["transfer"]["numerator"] = ["1", "0", "0", "0", "0"]
    assert check_bytes(data(seal(cert))).exit_code == 2
    cert = certificate(s, EQ23)
    entry = find(cert, "noise")
    entry["interval"] = ["0", "inf"]
    assert verdict(cert) == 6
    entry["interval"], entry["margin"] = ["200", "inf"], "31"
    assert verdict(cert) == 6  # above the asked gain


@pytest.mark.parametrize("sampling", [None, SAMPLED["sampling"]])
def test_tolerance(sampling: Json) -> None:
    s = spec(sampling=sampling, constraints={"tolerance": "1/16777216"})
    cert = certificate(s, EQ23)
    proven = text(num(cert["bandwidth"]["proven"]) * 0.99, 5)
    cert["bandwidth"]["proven"] = proven
    find(cert, "bandwidth").update(margin=proven, interval=["0", proven])
    entry = find(cert, "tolerance")
    assert verdict(cert) == 0
    entry["margin"] = "1/1000"
    assert verdict(cert) == 0
    entry["margin"] = "1/2"
    assert verdict(cert) in (4, 5)
    entry["margin"] = "1/100000000000"
    assert verdict(cert) == 6  # short of what is asked
    entry["margin"] = "1/1000"
    # 5 % more of Q's last coefficient: 1 − Q grows at low frequency
    Q = {"numerator": ["2000"], "denominator": ["1", "283/4", "2625"]}
    witness: Json = {
        "value": "1/20",
        "omega": "1",
        "load": None,
        "controller": Q,
        "claim": ["bandwidth", "attenuation"],
    }
    cert["spec"]["objective"]["attenuation"] = "29/100"

    def with_witness(**changes: object) -> int:
        entry["refuted_at"] = {**witness, **changes}
        return verdict(cert)

    cert["spec"]["objective"]["attenuation"] = "3/10"
    small = {"numerator": ["1900"], "denominator": ["1", "283/4", "2625"]}
    assert with_witness(controller=small, omega=proven) == 0  # |1 − Q| is above 0.3 there
    assert with_witness(controller=small, omega="0") == 4 if sampling is None else True
    assert with_witness(controller={**small, "numerator": ["1899"]}, omega=proven) == 4  # not within 5 %
    assert with_witness(controller={**small, "numerator": ["0", "1900"]}, omega=proven) == 4  # another length
    assert with_witness(controller=small, omega=proven, claim=["rendering", "every-load"]) == 4  # not required
    assert with_witness(controller=small, omega=proven, claim=["eq9", "printed"]) == 4  # holds there
    assert with_witness(controller=small, omega="1000000") == 4  # outside the band
    del witness["claim"]
    assert with_witness(controller=small, omega=proven) in (2, 4)


WITNESSES: list[tuple[str, Json, int]] = [
    ("midpoint", {"value": "101/100"}, 0),
    ("holds there", {"value": "3"}, 4),
    ("an impedance", {"value": "101/100", "impedance": {"inertia": "3/100", "damping": "7/20", "stiffness": "3/2"}}, 0),
    ("outside the range", {"value": "101/100", "impedance": {"inertia": "3/100", "damping": "7/20", "stiffness": "2"}}, 4),
    ("another inertia", {"value": "101/100", "impedance": {"inertia": "4/100", "damping": "7/20", "stiffness": "1"}}, 2),
    ("not a range", {"value": "101/100", "impedance": {"inertia": "1/25", "damping": "7/20", "stiffness": "1"}}, 4),
    ("no box", {"value": "101/100", "actuator": {"motor_inertia": "1/50", "motor_damping": "1/20", "spring_stiffness": "24/5"}}, 4),
    ("the nominal", {"value": "101/100", "actuator": {"motor_inertia": "1/100", "motor_damping": "1/20", "spring_stiffness": "24/5"}}, 0),
    ("unknown key", {"value": "101/100", "place": "here"}, 2),
    ("missing key", {"value": "101/100", "impedance": {"stiffness": "1"}}, 2),
    ("controller", {"value": "101/100", "controller": {"numerator": ["1"], "denominator": ["1"]}}, 4),
    ("claim", {"value": "101/100", "claim": ["peak", "sensitivity"]}, 4),
]  # fmt: skip


@pytest.mark.parametrize(("name", "witness", "code"), WITNESSES, ids=[w[0] for w in WITNESSES])
def test_witnesses_of_the_extended_regime(name: str, witness: Json, code: int) -> None:
    cert = certificate(spec(**SAMPLED, **RANGE), EQ23)
    find(cert, "peak")["refuted_at"] = {"omega": "50", "load": None, **witness}
    assert verdict(cert) == code, check_bytes(data(seal(cert))).message


def test_a_false_refutation_is_said_to_be_one() -> None:
    cert = certificate(spec(constraints={"peak": "2"}), EQ23)
    find(cert, "peak").update(status="refuted", margin=None, refuted_at={"value": "2", "omega": "60", "load": None})
    found = check_bytes(data(seal(cert)))
    assert found.exit_code == 4 and "witness of refutation is false" in found.message


UNREADABLE: dict[str, Json] = {
    "rate zero": {"sampling": {"rate": "0", "delay": "0"}},
    "negative delay": {"sampling": {"rate": "1", "delay": "-1"}},
    "reversed range": {"impedance": {"stiffness": ["2", "1"]}},
    "no points": {"uncertainty": {"table": {"points": [], "beyond": "hold"}}},
    "falling": {"uncertainty": {"table": {"points": [["1", "1"], ["1", "2"]], "beyond": "hold"}}},
    "no beyond": {"uncertainty": {"table": {"points": [["1", "1"]]}}},
    "triples": {"uncertainty": {"table": {"points": [["1", "1", "1"]], "beyond": "hold"}}},
    "motor off nominal": {"uncertainty": {"actuator": {"motor_inertia": ["1", "2"]}}},
    "unknown parameter": {"uncertainty": {"actuator": {"gear": ["1", "2"]}}},
    "actuator of an ideal one": {"actuator": {"type": "ideal"}, **MOTOR},
    "noise gain": {"constraints": {"noise": {"gain": "0"}}},
    "tolerance": {"constraints": {"tolerance": "0"}},
    "improper port": {"actuator": {"type": "two-port", "transfer": {"numerator": ["1", "0"], "denominator": ["1"]}, "impedance": {"numerator": ["0"], "denominator": ["1"]}}},
}  # fmt: skip


@pytest.mark.parametrize("name", UNREADABLE)
def test_unusable_new_fields_are_2(name: str) -> None:
    cert = certificate(spec(), EQ23)
    cert["spec"] = spec(**UNREADABLE[name])
    found = check_bytes(data(seal(cert)))
    assert found.exit_code == 2 and "\n" not in found.message, found.message


def test_required_new_claims_that_are_missing_are_6() -> None:
    for changes, kind, form in (
        ({}, "stability-free", "box"),
        (MOTOR, "stability-locked", "box"),
        (SAMPLED, "stability-free", "winding"),
        ({"constraints": {"noise": {"gain": "30", "above": "200"}}}, "noise", "command"),
        ({"constraints": {"tolerance": "1/1000000"}}, "tolerance", "coefficients"),
    ):
        cert = certificate(spec(**changes), EQ23)
        cert["claims"].remove(find(cert, kind, form))
        assert verdict(cert) == 6
    cert = certificate(spec(), EQ23)
    find(cert, "stability-free").update(form="winding", margin="0")
    assert verdict(cert) == 6
    cert = certificate(spec(**SAMPLED), EQ23)
    cert["claims"].append(claim("stability-free", "hurwitz", ["0", "inf"], "0", False))
    assert verdict(cert) in (4, 6)


def test_what_the_hold_decides_at_infinity_is_not_proven() -> None:
    """An ideal actuator and C that grows like s²: a delayed term faster than the undelayed one; no C is let in that does."""
    C = {"numerator": ["1/100", "1", "2000"], "denominator": ["500"]}
    s = spec(constraints=LIMITS, actuator={"type": "ideal"}, controller={"type": "dynamic-feedback"}, **SAMPLED)
    cert = certificate(
        spec(constraints=LIMITS, controller={"type": "dynamic-feedback"}), {"type": "dynamic-feedback", "C": EQ23["C"]}
    )
    cert["spec"], cert["controller"]["C"] = s, C
    for end in ("free", "locked"):
        find(cert, f"stability-{end}").update(form="winding", margin="0")
    assert check_bytes(data(seal(cert))).message == "controller.C: must be proper"
    prover = CellProver(read(data(seal(cert))), monotonic() + 30)
    with pytest.raises(CheckError, match="depends on the hold"):
        prover.fault(("stability-locked", "winding"), Fraction(0), (Fraction(0), inf), True)


def test_time_limits() -> None:
    cert = certificate(spec(**SAMPLED, **RANGE), EQ23)
    for limit in (float("nan"), 1e-9, 0.01):
        start = monotonic()
        assert check_bytes(data(cert), time_limit=limit).exit_code == 5
        assert monotonic() - start < 1


def test_a_store_of_joints_that_is_emptied_while_one_is_made_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(claims, "VIEWS", 2)
    verdict = check_bytes((Path(__file__).parents[1] / "data/golden/sampled-range.json").read_bytes(), time_limit=300)
    assert verdict.exit_code == 0, verdict.message
