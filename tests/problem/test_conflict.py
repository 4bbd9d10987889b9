"""Contradictions between constraints: found where there are some, named, measured, and removed by what is advised."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

import cvxpy as cp
import numpy as np
import pytest
from written_out import BOX, setting

from robimp.synthesis import load
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Variable
from robimp.synthesis.problem.grid import frequency_scale
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.alone import alone
from robimp.synthesis.solve.conflict import _best, conflicting, groups_of
from robimp.synthesis.solve.infeasible import RELAXED, impossible
from robimp.synthesis.solve.plane import EXISTS, NONE, Demand, Disc, Plane
from robimp.synthesis.solve.relaxation import _with, shrunk, smallest_relaxation
from robimp.synthesis.solve.unmet import attainable
from robimp.synthesis.spec.model import Spec

EXAMPLES = Path(__file__).parents[2] / "examples"
REFERENCE = "eq9: {}, eq12: {form: structured}, eq18: {form: half-plane, coupling: physical}, peak: 2"
DAMPED = "{inertia: nominal, damping: 0.02, stiffness: 1.25}"
QUIET = "noise: {gain: 0.3, above: 30}"


# ---- discs


def test_a_disc_of_values_holds_every_value() -> None:
    rng = np.random.default_rng(1)

    def draw() -> complex:
        return complex(*rng.normal(size=2))

    for _ in range(300):
        p, s, t, a, b = (draw() for _ in range(5))
        disc = Disc(np.array([draw()]), np.array([rng.uniform(0, 1.5)]))
        inside = disc.centre + disc.radius * np.sqrt(rng.uniform(size=200)) * np.exp(2j * np.pi * rng.uniform(size=200))
        edge = disc.centre + disc.radius * np.exp(2j * np.pi * rng.uniform(size=200))
        points = np.concatenate([inside, edge])
        pairs = [
            (disc.moebius(p, s, t), p * points / (s * points + t)),
            (abs(disc * b + a), np.abs(points * b + a)),
            ((a - disc).real, (a - points).real),
            (disc - b * disc, points - b * points),
        ]
        for image, values in pairs:
            assert np.all(np.abs(values - image.centre) <= image.radius * (1 + 1e-9) + 1e-12)


def test_a_disc_of_a_moebius_image_is_no_larger_than_it_must_be() -> None:
    disc = Disc(np.array([0.3 + 0.4j]), np.array([0.2]))
    image = disc.moebius(2.0, 0.5, 1.0)
    edge = disc.centre + disc.radius * np.exp(2j * np.pi * np.linspace(0, 1, 2000))
    assert np.max(np.abs(2 * edge / (0.5 * edge + 1) - image.centre)) == pytest.approx(image.radius[0], rel=1e-3)
    assert np.isinf(Disc(np.array([-2.0 + 0j]), np.array([0.1])).moebius(2.0, 0.5, 1.0).radius[0]), "a pole inside"


# ---- what can be done is never called impossible


@pytest.mark.parametrize("name", ["haninger2016-paper", "haninger2016-eq23", "haninger2016-sampled", "haninger2016"])
def test_a_joint_with_a_proven_controller_has_no_reason(name: str) -> None:
    assert impossible(Setting.of(load(EXAMPLES / f"{name}.yaml"))) is None


def test_where_the_papers_controller_meets_everything_the_search_finds_an_answer() -> None:
    joint = Setting.of(load(EXAMPLES / "haninger2016-paper.yaml"))
    low, high = frequency_scale(joint)
    omega = np.geomspace(low, high, 60)
    demands = [Demand(c, joint, float(c.level)) for c in constraints(joint) if c.level is not None and not c.on_band]
    assert np.all(Plane(joint, omega).search(demands) == EXISTS)
    tight = [Demand(d.constraint, joint, d.level * 1e-3) if d.constraint.id == "peak" else d for d in demands]
    assert np.all(Plane(joint, omega).search(tight) != NONE), "X = 1 has no peak at all"


# ---- the search against a convex program


def passivity_left(joint: Setting, omega: float, gain: float) -> float:
    """The best `min_v Re(Z_v/jω)` over |X/H| ≤ gain, by a cone program in one complex variable."""
    w = np.array([omega])
    X, v = cp.Variable(complex=True), cp.Variable()
    (passive,) = (c for c in constraints(joint) if (c.id, c.form) == ("eq12", "structured"))
    rows = [cp.abs(X) <= gain * abs(complex(joint.loop.actuator.H.at(w)[0]))]
    for q in passive.inequalities:
        assert q.variable is Variable.Q_TILDE and not q.moduli and not q.modulus_right
        constant, slope = (complex(np.broadcast_to(r.at(w), 1)[0]) for r in (q.right.constant, q.right.slope))
        rows.append(cp.real(constant + slope * X) >= v)
    problem = cp.Problem(cp.Maximize(v), rows)
    problem.solve(solver=cp.CLARABEL)
    return float(v.value)


@pytest.mark.parametrize("gain", [0.1, 0.3, 0.6])
def test_the_best_level_is_that_of_a_convex_program(gain: float) -> None:
    joint = setting(f"{{eq12: {{form: structured}}, noise: {{gain: {gain}}}}}", impedance=DAMPED)
    passive, _, noise = groups_of(joint)
    assert (passive[0].constraint.id, noise[0].constraint.id) == ("eq12", "noise")
    omega = np.array([10.0, 25.0, 40.0, 70.0])
    expected = np.array([passivity_left(joint, w, gain) for w in omega])
    found = Plane(joint, omega).search([*passive, *noise])
    assert np.array_equal(found == NONE, expected < 0)
    some = expected < 0
    assert _best(joint, omega[some], passive, [noise]) == pytest.approx(expected[some], abs=2e-5)


# ---- what is said


ATTENUATION_NOISE = ("attenuation and noise", "least any X reaches is 0.8 ", "least any X reaches is 0.7 ")
CASES = [
    ("attenuation, noise", {"constraints_": f"{{{REFERENCE}, noise: {{gain: 0.2}}}}"}, ATTENUATION_NOISE),
    (
        "passivity, noise",
        {"constraints_": f"{{{REFERENCE}, {QUIET}}}", "impedance": DAMPED},
        ("(12) structured and noise",),
    ),
    (
        "range",
        {
            "constraints_": f"{{{REFERENCE}, noise: {{gain: 0.2}}}}",
            "impedance": "{inertia: nominal, damping: 0.35, stiffness: [0.2, 10]}",
        },
        ATTENUATION_NOISE,
    ),
    (
        "rendering, noise",
        {
            "constraints_": "{eq9: {}, noise: {gain: 0.72}}",
            "objective": "{maximize: bandwidth, attenuation: 0.9, rendering_error: 0.01}",
            "plant": "{inertia: 0.03, damping: 0.2, stiffness: 2}",
            "uncertainty": "{box: {inertia: ±20 %, damping: ±40 %, stiffness: [1, 3]}}",
        },
        ("rendering error and noise",),
    ),
    (
        "uncertain actuator",
        {
            "constraints_": "{peak: 2, noise: {gain: 0.2}}",
            "uncertainty": f"{{box: {BOX}, actuator: {{motor_inertia: ±10 %}}}}",
        },
        ("attenuation and noise",),
    ),
    (
        "sampling",
        {"constraints_": f"{{{REFERENCE}, noise: {{gain: 0.2}}}}", "sampling": "{rate: 100 Hz, delay: 10 ms}"},
        ATTENUATION_NOISE,
    ),
    (
        "table",
        {
            "constraints_": "{peak: 2, noise: {gain: 0.2}, eq12: {form: structured, band: [0, 20]}}",
            "uncertainty": f"{{box: {BOX}, table: {{points: [[1, 0.05], [30, 0.3]], beyond: hold}}}}",
        },
        ("attenuation and noise",),
    ),
    ("limit", {"constraints_": "{eq12: {form: structured, margin: 0.15}}"}, ("(12) structured", "ω → ∞")),
]


@pytest.mark.parametrize(("changes", "said"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_a_contradiction_is_named_measured_and_removed_by_the_advice(
    changes: dict[str, str], said: tuple[str, ...]
) -> None:
    joint = setting(**changes)
    assert alone(joint) is None, "no constraint is impossible by itself"
    found = impossible(joint)
    assert found is not None
    assert all(text in str(found) for text in said), str(found)
    assert RELAXED in found.remedy
    assert found.error().what == found.what
    less, advised = (re.search(p, found.remedy) for p in (r"all uncertainty × (\S+)$", r"([\w.]+) \S+ → (\S+)$"))
    assert less is not None or advised is not None
    spec = joint.spec
    mended = _with(spec, advised[1], Fraction(advised[2])) if advised else shrunk(spec, float(less[1] if less else 1))
    assert not conflicting(Setting.of(mended)) and attainable(Setting.of(mended)), "the advice helps"


def test_half_of_the_advice_is_not_enough() -> None:
    """|X| ≥ 1 − δ = 0.7 against |X/H| ≤ gain, H(0) = 1."""
    for gain, contradicts in (("0.69", True), ("0.71", False)):
        joint = setting(f"{{{REFERENCE}, noise: {{gain: {gain}}}}}")
        assert conflicting(joint) is contradicts


def test_at_infinity_the_least_damping_of_the_loads_is_what_is_left() -> None:
    """The actuator is gone there: Re(Z/jω) → B ≥ 0.2·(1 − 0.4) = 0.12."""
    for margin, contradicts in (("0.1201", True), ("0.1199", False)):
        assert conflicting(setting(f"{{eq12: {{form: structured, margin: {margin}}}}}")) is contradicts


def test_one_constraint_alone_is_named_alone() -> None:
    joint = setting("{noise: {gain: 0.2}}", objective="{maximize: bandwidth, attenuation: 0.9}")
    assert impossible(joint) is None
    found = impossible(setting("{eq12: {form: structured, margin: 0.15}}"))
    assert found is not None and " and " not in found.what


TABLE = "{{box: {box}, table: {{points: [[1, 0.1], [30, {bound}]], beyond: hold}}}}"


@pytest.mark.parametrize("sampling", [None, "{rate: 1 kHz, delay: 1 ms}"])
def test_a_table_contradicts_passivity_where_it_says_so_and_nowhere_else(sampling: str | None) -> None:
    """Beyond the actuator X = 0, and Re(Z/jω) ≥ 0 for every load with a disc of 20 % on top cannot hold as ω → ∞."""
    for bound, band, contradicts in (
        ("0.2", "", True),
        ("0.2", ", band: [0, 20]", False),
        ("1.5", ", band: [0, 25]", True),  # the table reaches W = 1 at 20.3 rad/s
        ("1.5", ", band: [0, 15]", False),
    ):
        joint = setting(
            f"{{eq12: {{form: structured{band}}}}}",
            uncertainty=TABLE.format(box=BOX, bound=bound),
            sampling=sampling if band else None,  # with a hold nothing is said about ω → ∞
        )
        found = impossible(joint)
        assert (found is not None) is contradicts, (bound, band, found)
        assert found is None or "(12) structured" in str(found)


def test_what_no_number_mends_is_to_be_dropped() -> None:
    found = impossible(setting("{eq18: {form: paper, coupling: physical}}"))
    assert found is not None
    assert "without constraints.eq18" in found.remedy


def test_relaxations_are_compared_and_the_least_is_taken() -> None:
    spec = setting("{peak: 2}").spec
    needed = {"attenuation": 0.6, "peak": 2.5}
    for key, expected in (("both", "peak"), ("attenuation", "attenuation")):

        def holds(s: Spec, both: bool = key == "both") -> bool:
            calm = both and float(s.constraints.peak or 0) >= needed["peak"]
            return calm or float(s.objective.attenuation) >= needed["attenuation"]

        found = smallest_relaxation(spec, holds)
        assert found is not None and expected in found.text
        assert needed[expected] <= float(found.text.split("→")[1]) <= 1.03 * needed[expected]
    assert smallest_relaxation(spec, lambda _: False) is None


def test_less_uncertainty_keeps_the_nominal_joint_inside() -> None:
    joint = setting(uncertainty=f"{{box: {BOX}, actuator: {{motor_inertia: [0.009, 0.012]}}}}")
    half = shrunk(joint.spec, 0.5)
    assert half.uncertainty.box is not None and half.uncertainty.actuator is not None
    assert [float(v) for v in half.uncertainty.box.damping] == pytest.approx([0.16, 0.24])
    assert [float(v) for v in half.uncertainty.actuator.motor_inertia or ()] == pytest.approx([0.0095, 0.011])
