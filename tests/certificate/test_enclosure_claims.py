"""Claims proven on cells: against the polynomials where both apply, and against plain floats where only cells do."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from math import factorial
from typing import Any

import numpy as np
import pytest
from certificate_joints import PAPER_Q, random_case, rational, spec, subject
from flint import fmpq

from robimp.models.controller import Compensator
from robimp.models.rational import exact, to_float
from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.claims import certify, counterexamples
from robimp.synthesis.certificate.enclosure.box import largest_spread
from robimp.synthesis.certificate.enclosure.cells import Cells
from robimp.synthesis.certificate.enclosure.claims import prove_constraints
from robimp.synthesis.certificate.enclosure.exclusion import crossing, excluded, plane
from robimp.synthesis.certificate.enclosure.joint import Family, JointOnCells, family_of
from robimp.synthesis.certificate.enclosure.prover import CellProver
from robimp.synthesis.certificate.enclosure.tolerance import Weakest, holds, levels, weakest
from robimp.synthesis.certificate.enclosure.winding import turns
from robimp.synthesis.certificate.hurwitz import is_hurwitz
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.grid import Evaluator, float_roots
from robimp.synthesis.problem.setting import ACTUATOR, Setting
from robimp.synthesis.spec.model import ActuatorBox, Impedance, Sampling, Spec, Table

RANGE = Impedance(inertia=Fraction("0.03"), damping=Fraction("0.35"), stiffness=(Fraction("0.2"), Fraction(10)))
DRIVE = ActuatorBox(
    motor_inertia=(Fraction("0.009"), Fraction("0.011")), spring_stiffness=(Fraction("4.5"), Fraction(5))
)
SAMPLED = Sampling(rate=Fraction(1000), delay=Fraction(1, 1000))
TABLE = Table(points=((Fraction(1), Fraction("0.05")), (Fraction(100), Fraction("0.3"))), beyond="hold")
ONE_PERCENT = Fraction("0.99"), Fraction("1.01")
Q = rational(*PAPER_Q)


def extended(**changes: Any) -> Spec:
    """The reference joint with the paper's Q and some of: sampling, impedance, drive, table, tolerance."""
    base = spec()
    uncertainty = base.uncertainty.model_copy(update={"actuator": changes.get("drive"), "table": changes.get("table")})
    demands = base.constraints.model_copy(update={"tolerance": changes.get("tolerance")})
    return base.model_copy(
        update={
            "uncertainty": uncertainty,
            "constraints": demands,
            "sampling": changes.get("sampling"),
            "impedance": changes.get("impedance", base.impedance),
        }
    )


CASES = {
    "sampling": {"sampling": SAMPLED},
    "range": {"impedance": RANGE},
    "drive": {"drive": DRIVE},
    "table": {"table": TABLE},
    "several": {"sampling": SAMPLED, "impedance": RANGE, "table": TABLE},
}


@cache
def claims_of(name: str) -> tuple[Setting, Compensator, tuple[Claim, ...]]:
    setting, C = subject(extended(**CASES[name]), Q)
    return setting, C, certify(setting, C)


def claim_named(claims: tuple[Claim, ...], id: str, form: str | None = None) -> Claim:
    return next(c for c in claims if c.id == id and form in (None, c.form))


def members(setting: Setting, count: int = 12) -> list[Setting]:
    """Every vertex of the ranges, and random joints inside."""
    rng = np.random.default_rng(3)
    ranges = {f"impedance.{k}": v for k, v in setting.impedances.items()}
    ranges |= {f"actuator.{k}": v for k, v in setting.actuators.items()}
    inside = [
        setting.at(
            {k: lo + (hi - lo) * exact(Fraction(int(rng.integers(0, 101)), 100)) for k, (lo, hi, _) in ranges.items()}
        )
        for _ in range(count if ranges else 1)
    ]
    return [*setting.vertices(), *inside]


@pytest.mark.parametrize("seed", range(1000, 1012))
def test_cells_and_polynomials_find_the_same_margins(seed: int) -> None:
    setting, C = subject(*random_case(seed))
    by_cells = {(c.id, c.form): c for c in prove_constraints(setting, C)}
    for exact_claim in certify(setting, C):
        other = by_cells.get((exact_claim.id, exact_claim.form))
        if other is None or Outcome.UNDECIDED in (other.status, exact_claim.status):
            continue
        assert other.status is exact_claim.status, (exact_claim.id, exact_claim.form)
        if exact_claim.margin is not None and other.margin is not None and exact_claim.id != "rendering":
            a, b = float(exact_claim.margin), float(other.margin)
            assert abs(a - b) <= 0.02 * max(abs(a), abs(b)) + 2e-5, (exact_claim.id, exact_claim.form, a, b)


@pytest.mark.parametrize("name", CASES)
def test_what_is_proven_holds_for_every_member_on_a_dense_grid(name: str) -> None:
    setting, C, claims = claims_of(name)
    omega = np.geomspace(1e-2, 1e5, 4000)
    for member in members(setting):
        X = member.variables(C)
        for constraint in constraints(member):
            if constraint.largest_band:
                continue
            found = claim_named(claims, constraint.id, constraint.form)
            if found.status is not Outcome.PROVEN:
                continue
            margin = setting.spec.objective.attenuation if constraint.id == "bandwidth" else found.margin
            banded = replace(constraint, band=found.interval)
            assert Evaluator(member, omega).worst(banded, float(margin or 0), X)[0] > -1e-9, constraint.id


@pytest.mark.parametrize("name", CASES)
def test_every_twin_fails_at_its_witness(name: str) -> None:
    setting, C, claims = claims_of(name)
    for claim in claims:
        twin = claim.refuted_at
        if twin is None or twin.witness is None or claim.form in ("box", "winding", "hurwitz"):
            continue
        values = {}
        for part, names in (("impedance", setting.impedances), ("actuator", setting.actuators)):
            point = getattr(twin.witness, part)
            symbols = {"motor_inertia": "J", "motor_damping": "b_m", "spring_stiffness": "K_sp"}
            values |= {f"{part}.{k}": getattr(point, symbols.get(k, k)) for k in names if point is not None}
        member = setting.at(values)
        constraint = next(c for c in constraints(member, claim.id) if c.form == claim.form)
        level = setting.spec.objective.attenuation if claim.id == "bandwidth" else twin.value
        at = Evaluator(member, np.array([float(twin.witness.omega or 0) or 1e-4]))
        assert at.worst(replace(constraint, band=(Fraction(0), None)), float(level), member.variables(C))[0] < 1e-9


@pytest.mark.parametrize("name", CASES)
def test_sandwiches_are_within_one_percent(name: str) -> None:
    _, _, claims = claims_of(name)
    for claim in claims:
        if claim.status is Outcome.PROVEN and claim.form != "winding" and claim.refuted_at is not None:
            a, b = float(claim.margin or 0), float(claim.refuted_at.value)
            assert abs(a - b) <= 0.01 * max(abs(a), abs(b)) + 2e-6, (claim.id, claim.form, a, b)
        if claim.form == "box" and claim.status is Outcome.PROVEN:
            assert claim.refuted_at is not None and claim.refuted_at.witness is not None, "every box has its twin"


def test_the_cases_are_not_empty() -> None:
    """Control of the three tests above."""
    for name in CASES:
        claims = claims_of(name)[2]
        assert all(c.status is Outcome.PROVEN for c in claims if c.required and c.id != "eq12"), name
        assert sum(c.refuted_at is not None for c in claims) >= 6
    assert claim_named(claims_of("range")[2], "eq12").refuted_at.witness.impedance is not None  # type: ignore[union-attr]


def test_a_dense_grid_would_notice_a_margin_one_percent_too_hard() -> None:
    """Control: the comparison with floats can fail."""
    setting, C, claims = claims_of("range")
    passive = claim_named(claims, "eq12")
    omega, too_hard = np.geomspace(1, 1e3, 8000), float(passive.margin or 0) * 1.03
    worst = [
        Evaluator(member, omega).worst(next(iter(constraints(member, "eq12"))), too_hard, member.variables(C))[0]
        for member in setting.vertices()
    ]
    assert min(worst) < 0


# Stability -----------------------------------------------------------------------------------------------------------


def single(asked: Spec, gain: Fraction = Fraction(1)) -> CellProver:
    setting = Setting.of(asked)
    numerator = tuple(c * gain for c in Q.numerator)
    C = setting.compensator(Q.model_copy(update={"numerator": numerator}))
    return CellProver(replace(family_of(setting, C), single=True))


def pade_unstable(prover: CellProver, order: int = 10) -> bool:
    """Whether 1 + HCF, hold and delay by Padé, has a root to the right of the axis, in floats."""
    family = prover.family
    hold = family.setting.loop.actuator.hold
    assert hold is not None
    C = family.setting.build(family.numerator, family.denominator)
    pencil = family.setting.loop.locked()
    den, num = (
        np.array([to_float(c) for c in p.coeffs()[::-1]]) for p in (pencil.on_den * C.den, pencil.on_num * C.num)
    )
    T, delay = to_float(hold.period), to_float(hold.delay)
    total = delay + T / 2  # the hold is the mean of delays between delay and delay + T: close to their middle
    k = range(order + 1)
    c = [
        factorial(2 * order - j) * factorial(order) / (factorial(2 * order) * factorial(j) * factorial(order - j))
        for j in k
    ]
    up = np.array([c[j] * (-total) ** j for j in k])[::-1]
    down = np.array([c[j] * total**j for j in k])[::-1]
    closed = np.polyadd(np.polymul(den, down), np.polymul(num, up))
    return bool((np.roots(closed).real > 0).any())


@pytest.mark.parametrize("delay", [0, 5, 10, 20, 30, 45, 60, 80, 120])
def test_the_winding_number_sees_what_delay_does(delay: int) -> None:
    asked = extended(sampling=Sampling(rate=Fraction(2000), delay=Fraction(delay, 1000)))
    prover = single(asked, Fraction(9, 8))
    turned = turns(prover, "locked")
    assert turned is not None
    assert (turned != 0) == pade_unstable(prover)


def test_delay_makes_both_answers_occur() -> None:
    """Control of the test above."""
    answers = set()
    for delay in (0, 120):
        prover = single(extended(sampling=Sampling(rate=Fraction(2000), delay=Fraction(delay, 1000))), Fraction(9, 8))
        answers.add(turns(prover, "locked") != 0)
    assert answers == {True, False}


BOXED = [seed for seed in range(1000, 1035) if subject(*random_case(seed))[0].uncertainty.box is not None]


@pytest.mark.parametrize("seed", BOXED)
def test_a_box_is_stable_inside_its_margin_and_unstable_at_its_twin(seed: int) -> None:
    asked, coefficients = random_case(seed)
    setting, C = subject(asked, coefficients)
    box = setting.uncertainty.box
    assert box is not None
    found, rng = largest_spread(family_of(setting, C), "free"), np.random.default_rng(seed)
    if found.outcome is Outcome.PROVEN and found.proven is not None:
        nominal = setting.loop.nominal
        nominal_stable = float_stable(setting.loop.free(nominal)(C))
        for _ in range(60):
            values = {}
            for name in ("inertia", "damping", "stiffness"):
                low, high = getattr(box, name)
                middle = getattr(nominal, name)
                share = Fraction(int(rng.integers(-100, 101)), 100)
                reach = (high - middle) if share > 0 else (middle - low)
                values[name] = middle + exact(found.proven * share) * reach
            if nominal_stable:
                assert float_stable(setting.loop.free(replace(nominal, **values))(C), slack=1e-7)
    if found.witness is not None and found.witness.load is not None:
        assert not float_stable(setting.loop.free(found.witness.load)(C), slack=-1e-9)


def float_stable(p: Any, slack: float = 0.0) -> bool:
    coefficients = np.array([to_float(c / p.leading_coefficient()) for c in p.coeffs()[::-1]])
    return bool((np.roots(coefficients).real <= slack * np.abs(np.roots(coefficients)).max()).all())


def test_an_unstable_box_is_not_excluded() -> None:
    """Control: a box with a load that makes the joint unstable is never called free of roots on the axis."""
    setting, C = subject(*random_case(1003))
    family = family_of(setting, C)
    found = largest_spread(family, "free")
    if found.refuted is None:
        pytest.skip("never unstable")
    with np.errstate(all="ignore"):
        assert not excluded(CellProver(replace(family, spread=found.refuted * 2, loads=True)), "free")


# Boxes with uncertain actuators: f is affine in each parameter, not in all of them together -------------------------


def drives(inertia: int = 0, damping: int = 0, spring: int = 0, **changes: Any) -> Spec:
    """The reference joint with its motor and spring off by some per cent."""

    def around(value: str, share: int) -> tuple[Fraction, Fraction] | None:
        v = Fraction(value)
        return (v * (1 - Fraction(share, 100)), v * (1 + Fraction(share, 100))) if share else None

    box = ActuatorBox(
        motor_inertia=around("0.01", inertia),
        motor_damping=around("0.05", damping),
        spring_stiffness=around("4.8", spring),
    )
    return extended(drive=box, **changes)


DRIVES = {
    "inertia": drives(20),
    "spring": drives(0, 0, 20),
    "wide": drives(40, 0, 40),
    "all": drives(20, 30, 20),
    "and impedances": drives(10, 0, 10, impedance=RANGE),
}


@cache
def spread(name: str, end: str) -> tuple[Family, Any]:
    family = family_of(*subject(DRIVES[name], Q))
    return family, largest_spread(family, end)


@pytest.mark.parametrize("end", ["free", "locked"])
@pytest.mark.parametrize("name", DRIVES)
def test_a_box_of_actuators_is_known_within_one_percent(name: str, end: str) -> None:
    _, found = spread(name, end)
    assert found.outcome is Outcome.PROVEN and found.proven is not None and found.refuted is not None
    assert found.proven < found.refuted <= found.proven * Fraction(101, 100)


@pytest.mark.parametrize("name", DRIVES)
def test_every_joint_of_a_proven_box_is_stable_and_the_twin_is_not(name: str) -> None:
    family, found = spread(name, "free")
    inside = replace(family, spread=found.proven, loads=True)
    rng, C = np.random.default_rng(5), family.setting.build(family.numerator, family.denominator)
    worst = -np.inf
    for k in range(300):
        share = rng.choice([-1.0, 1.0], len(inside.parameters)) if k % 2 else rng.uniform(-1, 1, len(inside.parameters))
        at = Cells.at(1.0, share.size).points(share[:, None])
        values = inside.point(replace(at, t=np.stack([share[:, None]] * 2)), 0)
        member = family.setting.at({key: v for key, v in values.items() if not key.startswith("load.")})
        load = {key.split(".")[1]: v for key, v in values.items() if key.startswith("load.")}
        f = member.loop.free(replace(member.loop.nominal, **load))(C)
        worst = max(worst, max(root.real for root in float_roots(f)))
    assert worst < 0
    values = {f"actuator.{k}": getattr(found.witness.actuator, ACTUATOR[k]) for k in family.setting.actuators}
    values |= {f"impedance.{k}": getattr(found.witness.impedance, k) for k in family.setting.impedances}
    assert not is_hurwitz(family.setting.at(values).loop.free(found.witness.load)(C))


def test_a_box_that_holds_an_unstable_joint_is_never_excluded() -> None:
    """Control: just beyond the twin, and far beyond, where the hull is wide; a place where f is 0 is named."""
    family, found = spread("wide", "free")
    for factor in (1, Fraction(11, 10), 2):
        prover = CellProver(replace(family, spread=found.refuted * factor, loads=True))
        at = crossing(prover, "free")
        assert at is not None and at.t.size == len(prover.family.parameters) and np.isfinite(at.omega)


def test_the_hull_of_corners_holds_what_lies_between_them() -> None:
    """f at random actuators is never farther out, in any direction, than at the corners."""
    family = replace(family_of(*subject(DRIVES["all"], Q)), loads=True)
    drive = [k for k, key in enumerate(family.parameters) if key.startswith("actuator.")]
    cells, rng = Cells.at(np.geomspace(1, 1e3, 40), len(family.parameters)), np.random.default_rng(2)
    corners = [plane(JointOnCells(family, corner).free()) for corner in cells.corners(drive)]
    assert len(corners) == 8
    for _ in range(20):
        t = rng.uniform(-1, 1, (len(family.parameters), 1)) * np.ones((1, 40))
        p, q, *_ = plane(JointOnCells(family, replace(cells, t=np.stack([t, t]))).free())
        for a, b in rng.normal(size=(10, 2)):
            b = b * np.abs(p[0]) / np.abs(q[0])
            reach = [a * P[0] + b * Q_[0] + np.abs(a * P[1:] + b * Q_[1:]).sum(axis=0) for P, Q_, *_ in corners]
            size = np.abs(a * p[0]) + np.abs(b * q[0])
            assert (a * p[0] + b * q[0] <= np.max(reach, axis=0) + 1e-9 * size).all()


def test_a_level_that_is_asked_for_is_proven_where_only_a_little_is_left() -> None:
    """The band ends where the rendering error reaches what is asked for: next to nothing remains there."""
    base = extended(impedance=RANGE)
    asked = base.model_copy(
        update={"objective": base.objective.model_copy(update={"rendering_error": Fraction("0.05")})}
    )
    claims = certify(*subject(asked, Q))
    rendering, band = claim_named(claims, "rendering"), claim_named(claims, "bandwidth")
    assert rendering.required and rendering.status is Outcome.PROVEN and rendering.margin <= Fraction("0.05")
    assert 0 < band.margin < Fraction("8.8"), "control: without it the band is wider"


def test_wide_ranges_are_halved_in_ratio_and_narrow_ones_in_the_middle() -> None:
    cells = Cells.at(1.0, 2)
    offset = np.array([(10 + 0.2) / (10 - 0.2), 100.0])  # [0.2, 10] and [99, 101]
    wide, narrow = (cells.split_parameter(np.array([k]), offset).t[1, k, 0] for k in (0, 1))
    assert 0.2 + (wide + 1) / 2 * 9.8 == pytest.approx(2**0.5)
    assert narrow == 0


# Tolerance -----------------------------------------------------------------------------------------------------------


@cache
def tolerant() -> tuple[Setting, Compensator, tuple[Claim, ...]]:
    setting, C = subject(extended(tolerance=Fraction(1, 2**24)), Q)
    return setting, C, certify(setting, C)


def test_every_controller_within_the_tolerance_has_what_is_required() -> None:
    setting, _, claims = tolerant()
    found, end = claim_named(claims, "tolerance"), claim_named(claims, "bandwidth").margin
    assert found.status is Outcome.PROVEN
    assert found.margin >= Fraction(1, 2**24)  # type: ignore[operator]
    rng = np.random.default_rng(11)
    for _ in range(40):
        moved = {
            part: tuple(c * (1 + found.margin * int(rng.choice([-1, 1]))) for c in getattr(Q, part))  # type: ignore[operator]
            for part in ("numerator", "denominator")
        }
        C = setting.compensator(Q.model_copy(update=moved))
        X = setting.variables(C)
        for constraint in constraints(setting):
            if constraint.level is not None:
                band = (Fraction(0), end) if constraint.on_band else constraint.band
                omega = np.unique([*np.geomspace(0.1, 1e4, 1500), *([float(end)] if constraint.on_band else [])])
                worst = Evaluator(setting, omega).worst(replace(constraint, band=band), float(constraint.level), X)
                assert worst[0] > -1e-12, constraint.id


def test_the_twin_of_the_tolerance_names_a_controller_that_fails() -> None:
    setting, _, claims = tolerant()
    found, end = claim_named(claims, "tolerance"), claim_named(claims, "bandwidth").margin
    witness = found.refuted_at.witness  # type: ignore[union-attr]
    assert witness is not None and witness.controller is not None and witness.claim is not None
    assert float(found.refuted_at.value) < 1.01 * float(found.margin)  # type: ignore[union-attr, arg-type]
    constraint = next(c for c in constraints(setting, witness.claim[0]) if c.form == witness.claim[1])
    X = setting.variables(setting.compensator(witness.controller))
    banded = replace(constraint, band=(Fraction(0), end)) if constraint.on_band else constraint
    at = Evaluator(setting, np.array([float(witness.omega or 0)]))
    assert at.worst(banded, float(constraint.level or 0), X)[0] < 0


def test_a_tolerance_ends_before_a_compensator_is_improper() -> None:
    """Q = (.9 s + 9)/(s + 10): the first coefficient of d_Q − n_Q may be 0 for |e| ≥ (1 − .9)/(1 + .9)."""
    setting, C = subject(extended(tolerance=Fraction(1, 100)), rational([Fraction(9, 10), 9], [1, 10]))
    limit, family = Fraction(1, 19), family_of(setting, C)
    assert family.proper_within == limit
    assert next(levels(family, None, None)) == pytest.approx(Fraction("0.998") * limit, rel=1e-5)
    single = replace(family, setting=replace(setting, uncertainty=replace(setting.uncertainty, box=None)))
    assert holds(single, [], limit * Fraction(99, 100)) and not holds(single, [], limit)
    assert family_of(setting, subject(setting.spec, Q)[1]).proper_within == 1


def test_no_tolerance_is_proven_of_a_controller_that_lacks_what_is_required_itself() -> None:
    """Roots have no frequency at which a witness could be looked at: then it is undecided."""
    asked, unstable = Fraction(1, 2**24), rational([2000], [1, Fraction("-0.75"), 2500])
    whole = extended(tolerance=asked)
    bare = whole.constraints.model_copy(update={"eq9": None, "eq12": None, "eq18": None, "peak": None})
    for peak, box, given, claim in (
        (Fraction(1), whole.uncertainty.box, Q, ("peak", "sensitivity")),
        (None, whole.uncertainty.box, unstable, ("stability-free", "box")),
        (None, None, unstable, None),
    ):
        uncertainty = whole.uncertainty.model_copy(update={"box": box})
        changes = {"constraints": bare.model_copy(update={"peak": peak}), "uncertainty": uncertainty}
        found = claim_named(certify(*subject(whole.model_copy(update=changes), given)), "tolerance")
        assert found.margin is None and found.status is (Outcome.REFUTED if claim else Outcome.UNDECIDED)
        if claim:
            witness = found.refuted_at.witness  # type: ignore[union-attr]
            assert (witness.controller, witness.claim) == (given, claim)  # type: ignore[union-attr]
            assert found.refuted_at.value == asked  # type: ignore[union-attr]


def test_within_a_tolerance_the_printed_passivity_stays_stable_behind_an_ideal_actuator() -> None:
    """C = k/(s+1)³, half the torque: 1 + C has roots on the axis at k = 8, which a band away from ω = √3 misses."""
    base = extended(tolerance=Fraction(1, 100))
    body = base.model_dump()
    body |= {
        "plant": {"inertia": Fraction(1), "damping": Fraction(1), "stiffness": Fraction(0)},
        "uncertainty": {
            "box": {"inertia": ONE_PERCENT, "damping": ONE_PERCENT, "stiffness": (Fraction(0), Fraction(0))}
        },
        "actuator": {
            "type": "two-port",
            "transfer": {"numerator": (Fraction(1),), "denominator": (Fraction(2),)},
            "impedance": {"numerator": (Fraction(0),), "denominator": (Fraction(2),)},
        },
        "impedance": {"inertia": Fraction(1), "damping": Fraction(2), "stiffness": Fraction(1)},
        "controller": {"type": "dynamic-feedback", "order": 3, "filters": {}},
        "objective": {"maximize": "bandwidth", "attenuation": Fraction(1, 2), "rendering_error": None},
        "constraints": {
            "eq12": {"form": "paper", "band": (Fraction(1, 2), Fraction(3, 5))},
            "friction": "report",
            "tolerance": Fraction(1, 100),
        },
    }
    for k, proven in (("7.99", False), ("7", True)):
        asked = Spec.model_validate(body)
        claims = certify(*subject(asked, rational([Fraction(k)], [1, 3, 3, 1])))
        assert claim_named(claims, "eq12").status is Outcome.PROVEN
        assert (claim_named(claims, "tolerance").status is Outcome.PROVEN) is proven


def test_a_search_is_told_where_a_tolerance_fails() -> None:
    setting, C = subject(extended(tolerance=Fraction(1, 100)), Q)
    found = counterexamples(setting, C, 8.87)
    assert [c.id for c in found] == ["tolerance"]
    assert np.isfinite(found[0].omega)


def test_a_band_with_nothing_but_zero_has_nothing_that_a_perturbation_breaks() -> None:
    """As that of a bandwidth of 0 rad/s; up to 1 rad/s there is something."""
    setting, C = subject(extended(tolerance=Fraction(1, 100)), Q)
    peak, family = next(iter(constraints(setting, "peak"))), family_of(setting, C)

    def found(end: int) -> Weakest | None:
        return weakest(family, [(replace(peak, band=(Fraction(0), Fraction(end))), Fraction(2))])

    assert found(0) is None and found(1) is not None


def test_parameters_are_only_what_is_uncertain() -> None:
    setting, C = subject(extended(sampling=SAMPLED, impedance=RANGE, drive=DRIVE), Q)
    family = family_of(setting, C)
    assert set(family.parameters) == {"impedance.stiffness", "actuator.motor_inertia", "actuator.spring_stiffness"}
    stretched = replace(family, spread=Fraction(2)).parameters["impedance.stiffness"]
    assert stretched == (fmpq(-47, 10), fmpq(149, 10))
    assert Family(setting, family.numerator, family.denominator, single=True).parameters == {}
    assert isinstance(JointOnCells(family, CellProver(family).axis((Fraction(1), Fraction(2)))[0]).setting, Setting)


# ---- where nothing is left for the uncertainty


def test_a_constraint_without_room_is_refuted_at_every_level() -> None:
    """(18) as printed fails at low frequency without any uncertainty: no level, however small, holds there."""
    setting, C = subject(spec(constraints={"eq18": {"form": "paper", "coupling": "physical"}}), Q)
    band = (Fraction(1, 1000), Fraction(1, 10))
    printed = replace(next(c for c in constraints(setting) if c.form == "paper/physical"), band=band)
    prover = CellProver(family_of(setting, C))
    assert prover.hardest(printed).status is Outcome.REFUTED
    assert all(
        form.upper[k] * cells.z[:, k].max() ** form.order < -1e6
        for cells in prover.axis(band)
        for form in prover.levels(printed, cells)
        for k in range(cells.size)
    )
    above = replace(printed, band=(Fraction(30), Fraction(31)))
    assert prover.hardest(above).status is Outcome.PROVEN  # the same prover, where there is room


def test_ends_count_the_disc_for_friction_as_well() -> None:
    """A disc of radius near 1 around K = 0: Z(0) of some plant inside it is 0 or negative, relative to the nominal."""
    harmless, grave = (
        Table(points=((Fraction(1), bound), (Fraction(100), bound)), beyond="hold")
        for bound in (Fraction("0.1"), Fraction("40"))
    )
    held = []
    for table in (harmless, grave):
        setting, C = subject(extended(table=table), Q)
        friction = next(c for c in constraints(setting) if c.id == "friction")
        held.append(CellProver(family_of(setting, C)).ends(friction))
    assert held == [True, False]


# ---- a controller that answers at once, on an ideal actuator: only the hold makes its loop gain fall


def feedthrough(attenuation: str) -> tuple[Claim, ...]:
    asked = extended(sampling=SAMPLED)
    ideal = spec(actuator={"type": "ideal"}, objective={"attenuation": attenuation}, constraints={"eq18": None})
    controller = ideal.controller.model_copy(update={"type": "dynamic-feedback"})
    return certify(
        *subject(
            ideal.model_copy(update={"sampling": asked.sampling, "controller": controller}),
            rational(("1", "20"), ("1", "40")),
        )
    )


def test_a_hold_is_followed_until_it_is_small() -> None:
    claims = feedthrough("0.7")
    assert all(claim.status is not Outcome.UNDECIDED for claim in claims)
    assert claim_named(claims, "stability-free", "winding").status is Outcome.PROVEN
    assert claim_named(claims, "stability-free", "box").status is Outcome.REFUTED
    assert float(claim_named(claims, "bandwidth").margin or 0) > 900


def test_no_bandwidth_at_all_is_refuted_at_zero() -> None:
    """`|1 − Q̃(0)| = 2/3`: an attenuation of 0.6 fails at once, and nothing is said about the objective's band."""
    claims = feedthrough("0.6")
    band = claim_named(claims, "bandwidth")
    assert band.status is Outcome.REFUTED
    assert band.refuted_at is not None
    assert band.refuted_at.witness is not None
    assert band.refuted_at.witness.omega == 0
    assert claim_named(claims, "rendering").status is Outcome.UNDECIDED
