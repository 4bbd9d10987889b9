"""The nonlinear program: stability through Routh's table, and what happens to the search without it."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from robimp.models.closed_loop import Pencil
from robimp.models.rational import ONE, RationalFunction, descending
from robimp.synthesis.certificate.hurwitz import is_hurwitz
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Role
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.filtered import structure_of
from robimp.synthesis.solve.nlp import Candidate, Program
from robimp.synthesis.solve.places import ADDED, FIRST_BACK_OFF, Grids, Places, numbered
from robimp.synthesis.solve.split import Split
from robimp.synthesis.spec import parse_spec
from robimp.synthesis.spec.model import Polynomials

ROOT = Path(__file__).parents[2]
GOOD = (ROOT / "tests" / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")
CONTROLLERS = {
    "order 2": "{type: dob, order: 2}",
    "order 3": "{type: dob, order: 3}",
    "order 4": "{type: dob, order: 4}",
    "order 5, filtered": "{type: dob, order: 5, filters: {force: 100, derivative: 1000}}",
    "P": "{type: dynamic-feedback, order: 0, filters: {force: 100}}",
    "PI, filtered twice": (
        "{type: dynamic-feedback, order: 1, filters: {force: 100, position: none, derivative: 1000}}"
    ),
}


def good(controller: str) -> Setting:
    return Setting.of(parse_spec(GOOD.replace("{type: dob, order: 4}", CONTROLLERS[controller])))


FEW = Grids(np.geomspace(0.1, 1000, 5), np.array([0.1, 1.0]))


def small(setting: Setting, omega_0: float) -> Program:
    return Program(setting, structure_of(setting.spec), FEW, omega_0)


def routh(program: Program, pencil: Pencil) -> ca.Function:
    """The first column as a function of the parameters."""
    return ca.Function("routh", [program.x], [ca.vertcat(*program._routh(pencil))])


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("end", ["locked", "free"])
def test_rouths_column_is_positive_exactly_for_stable_loops(controller: str, end: str) -> None:
    setting, omega_0 = good(controller), 25.0
    pencil = setting.loop.locked() if end == "locked" else setting.loop.free(setting.loop.nominal)
    program, structure = small(setting, omega_0), structure_of(setting.spec)
    column, rng = routh(program, pencil), np.random.default_rng(0)
    seen = set()
    for _ in range(150):
        x = structure.start(rng) * rng.choice([1.0, -1.0, 8.0, 30.0], size=structure.bounds[0].size)
        polynomial = pencil(setting.compensator(structure.rounded(x, omega_0)))
        roots = np.roots([float(c) for c in descending(polynomial / polynomial.leading_coefficient())])
        worst = roots.real.max() / np.abs(roots).max()
        if abs(worst) < 1e-7:
            continue  # too close for floats to tell
        positive = bool(np.all(np.array(column(x)) > 0))
        assert positive == (worst < 0), (x, roots)
        assert positive == is_hurwitz(polynomial)
        seen.add(positive)
    assert seen == {True, False}


def test_a_column_without_its_last_entry_would_be_caught() -> None:
    """The last entry is the constant coefficient: without it, a real pole on the right goes unseen."""
    setting = good("order 2")
    pencil = setting.loop.locked()
    column = routh(small(setting, 25.0), pencil)
    x = np.array([0.0, 0.7, 40.0])  # α = Q(0) = 40: C = Q/(1−Q) has negative gain
    entries = np.array(column(x)).ravel()
    assert not np.all(entries > 0)
    assert not is_hurwitz(pencil(setting.compensator(structure_of(setting.spec).rounded(x, 25.0))))


def slow_torque_loop(order: int) -> Setting:
    """The joint of the example whose optimum is unstable, with its controller to be found."""
    text = (ROOT / "examples" / "unstable-optimum.yaml").read_text(encoding="utf-8")
    begin, end = text.index("  coefficients:"), text.index("objective:")
    return Setting.of(parse_spec(f"{text[:begin]}  order: {order}\n\n{text[end:]}"))


def stable(setting: Setting, x: np.ndarray, omega_0: float) -> bool:
    """Of the parameters themselves: a point on the boundary may lose it to the rounding, which the proof sees."""
    sides = ([Fraction(float(c)) for c in side] for side in structure_of(setting.spec).polynomials(x))
    num, den = (tuple(c / Fraction(omega_0) ** (len(p) - 1 - k) for k, c in enumerate(p)) for p in sides)
    C, loop = setting.compensator(Polynomials(numerator=num, denominator=den)), setting.loop
    return is_hurwitz(loop.locked()(C)) and is_hurwitz(loop.free(loop.nominal)(C))


def unstable_starts(setting: Setting, omega_0: float, count: int) -> list[np.ndarray]:
    """Points all over the box of parameters whose loops are unstable."""
    structure, rng = structure_of(setting.spec), np.random.default_rng(0)
    low, high = structure.bounds
    drawn = (structure.start(rng) * rng.uniform(-3, 3, low.size) for _ in range(count))
    inside = [np.clip(x, low + 0.01, high - 0.01) for x in drawn]
    return [x for x in inside if not stable(setting, x, omega_0)]


def solved(setting: Setting, omega_0: float, starts: list[np.ndarray]) -> list[Candidate]:
    """What the program finds on a coarse grid from given starts."""
    grids = Grids.of(setting, omega_0)
    program = Program(setting, structure_of(setting.spec), grids, omega_0)
    found = [program.solve(x, 0.1 * omega_0, grids) for x in starts]
    return [candidate for candidate in found if candidate is not None]


def test_only_rouths_rows_keep_the_search_among_stable_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    setting, omega_0 = slow_torque_loop(4), 13.0
    structure, rng = structure_of(setting.spec), np.random.default_rng(0)
    grids = Grids.of(setting, omega_0)
    drawn = [structure.start(rng) for _ in range(100)]
    best_drawn = Program(setting, structure, grids, omega_0).nearest(drawn, 0.1 * omega_0, grids)[:8]
    guarded = solved(setting, omega_0, best_drawn)
    best = max(candidate.omega_B for candidate in guarded)

    with monkeypatch.context() as without:
        without.setattr(Program, "_routh", lambda self, pencil: [1.0])
        program = Program(setting, structure, grids, omega_0)
        starts = program.nearest(unstable_starts(setting, omega_0, 400), 0.1 * omega_0, grids)[:15]
        unguarded = solved(setting, omega_0, starts)
    guarded += solved(setting, omega_0, starts)
    assert len(guarded) >= 3 and all(stable(setting, c.x, omega_0) for c in guarded)
    unstable = [c.omega_B for c in unguarded if not stable(setting, c.x, omega_0)]
    assert unstable, "without the rows nothing unstable is found either: they would be superfluous"
    assert max(unstable) > 3 * best, "and it looks far better than the truth"


def test_a_start_that_satisfies_everything_has_no_violation() -> None:
    """The paper's Q on the reference joint, at its own ω_B and a little beyond."""
    setting, omega_0 = good("order 2"), 10.0
    grids = Grids.of(setting, omega_0, finer=2)
    program = Program(setting, structure_of(setting.spec), grids, omega_0)
    x = np.array([np.log(50 / omega_0), 0.7075, 0.8])
    assert program.violation(x, 8.8, grids) <= 0
    assert program.violation(x, 9.0, grids) > FIRST_BACK_OFF
    assert program.violation(x * np.nan, 8.8, grids) == np.inf


def test_a_solution_is_feasible_inside_the_bounds_and_could_not_be_faster() -> None:
    setting, omega_0 = good("order 2"), 13.0
    structure, rng = structure_of(setting.spec), np.random.default_rng(0)
    grids = Grids.of(setting, omega_0, 4)
    program = Program(setting, structure, grids, omega_0)
    drawn = program.nearest([structure.start(rng) for _ in range(40)], 1.3, grids)
    found = next(c for c in (program.solve(x, 1.3, grids) for x in drawn) if c is not None and c.omega_B > 13)
    assert found.omega_B < 14
    low, high = structure.bounds
    assert np.all(low - 1e-6 <= found.x) and np.all(found.x <= high + 1e-6)
    assert program.violation(found.x, found.omega_B, grids) < 1e-5
    assert program.violation(found.x, 1.01 * found.omega_B, grids) > 1e-5


class Answer:
    """A solver with an answer of its own."""

    def __init__(self, x: list[float], success: bool, status: str = "Solve_Succeeded") -> None:
        self.x, self.status = x, {"success": success, "return_status": status}

    def __call__(self, **_: Any) -> dict[str, Any]:
        return {"x": np.array(self.x)}

    def stats(self) -> dict[str, Any]:
        return self.status


def test_the_solvers_word_is_not_enough() -> None:
    program, start = small(good("P"), 10.0), np.array([1.0])
    program.solvers[False] = Answer([0.7, 0.5], success=True)
    found = program.solve(start, 5.0, FEW)
    assert found is not None and found.omega_B == pytest.approx(10 * np.exp(0.5))
    for answer in ([np.nan, 0.5], [0.7, np.nan], [np.inf, 0.5]):
        program.solvers[False] = Answer(answer, success=True)
        assert program.solve(start, 5.0, FEW) is None
    program.solvers[False] = Answer([0.7, 0.5], success=False)
    assert program.solve(start, 5.0, FEW) is None


def test_a_keyboard_interrupt_that_the_solver_swallowed_is_raised_again() -> None:
    program = small(good("P"), 10.0)
    program.solvers[False] = Answer([0.7, 0.5], success=False, status="NonIpopt_Exception_Thrown")
    with pytest.raises(KeyboardInterrupt):
        program.solve(np.array([1.0]), 5.0, FEW)
    program.solvers[False] = Answer([0.7, 0.5], success=False, status="Infeasible_Problem_Detected")
    assert program.solve(np.array([1.0]), 5.0, FEW) is None


def test_refining_adds_points_and_the_oldest_make_room() -> None:
    finer = FEW.refined([5.0], [0.5, 1.0])
    assert finer.added == (5.0,) and finer.added_band == (0.5, 1.0)
    assert np.array_equal(finer.omega, FEW.omega) and finer.back_off == FEW.back_off
    full = finer.refined([float(w) for w in range(10, 10 + ADDED)], [])
    assert len(full.added) == ADDED and 5.0 not in full.added
    assert finer.refined([5.0], []).added == (5.0,), "a point that is there already takes no place"


def test_one_program_serves_every_grid() -> None:
    """The slack at points that were added is that of a program built with them; unused places ask for nothing."""
    setting, omega_0 = good("order 4"), 25.0
    structure, rng = structure_of(setting.spec), np.random.default_rng(5)
    narrow = Grids(np.array([20.0, 30.0]), np.array([0.5, 1.0]))
    wide = Grids(np.array([20.0, 30.0, 55.0, 90.0]), np.array([0.5, 0.8, 1.0]))
    one, other = (Program(setting, structure, grids, omega_0) for grids in (narrow, wide))
    seen = 0
    for _ in range(20):
        x = structure.start(rng)
        added = one.violation(x, 20.0, narrow.refined([55.0, 90.0], [0.8]))
        assert added == pytest.approx(other.violation(x, 20.0, wide), rel=1e-9)
        seen += one.violation(x, 20.0, narrow) < added - 1e-6
    assert seen >= 3, "the added points never matter"


def test_a_constant_takes_no_place_among_the_parameters() -> None:
    places = Places(3)
    before = len(places.columns)
    assert places.at(ONE) == 1.0 and places.at(RationalFunction.of([3], [2])) == 1.5 and len(places.columns) == before
    varying = RationalFunction.of([1], [1, 2])
    assert isinstance(places.at(varying), Split) and len(places.columns) == before + 2
    assert numbered(lambda r: r)(varying) is varying  # type: ignore[arg-type, return-value]


@pytest.mark.parametrize("controller", ["order 4", "order 5, filtered", "PI, filtered twice"])
def test_the_slack_is_what_the_constraints_say(controller: str) -> None:
    """Each row of the grid against NumPy's view of the same constraint; up to the rounding of the controller."""
    setting, omega_0 = good(controller), 25.0
    structure, omega = structure_of(setting.spec), FEW.omega
    program, rng = small(setting, omega_0), np.random.default_rng(3)
    asked = [(c, q) for c in constraints(setting) if c.required for q in c.inequalities]
    evaluator, compared = Evaluator(setting, omega), 0
    for x in (structure.start(rng) for _ in range(5)):
        X = setting.variables(setting.compensator(structure.rounded(x, omega_0)))
        values = np.array(program.slack(np.append(x, np.log(8.0 / omega_0)), program.placed(FEW)[0])).ravel()
        for rows, (c, q) in zip(program.rows, asked, strict=True):
            if c.on_band:
                continue
            level, W = float(c.level or 0), evaluator.radius(q.source)
            left, right = q.sides(level, W, X[q.variable].at(omega), lambda r: r.at(omega))
            size = np.abs(q.right.constant.at(omega)) + np.abs(q.right.slope.at(omega))
            size = size.min() if q.role is Role.FLOOR else size
            part = values[rows.start : rows.start + omega.size]
            assert part == pytest.approx((right - left) / size, rel=1e-3, abs=1e-4)
            compared += 1
    assert compared >= 20


def test_a_finer_grid_shows_where_a_candidate_falls_short() -> None:
    setting, omega_0 = good("order 2"), 13.0
    structure = structure_of(setting.spec)
    x = np.array([np.log(50 / omega_0), 0.7075, 0.8])
    program, finer = Program(setting, structure, FEW, omega_0), Grids.of(setting, omega_0, 4)
    shipped = structure.rounded(x, omega_0)
    assert program.violated(Candidate(shipped, 8.8, x), finer) == ([], [])
    omega, band = program.violated(Candidate(shipped, 12.0, x), finer)
    assert not omega and band == [1.0], "only the attenuation at the end of the band fails"
    peaking = np.array([np.log(50 / omega_0), 0.1, 0.8])
    omega, _ = program.violated(Candidate(structure.rounded(peaking, omega_0), 8.8, peaking), finer)
    assert omega and all(20 < w < 200 for w in omega)


def test_a_peak_between_two_points_of_the_finer_grid_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pair of poles with ζ = 0.001 that zeros cancel but for one per cent: a peak of Q̃ far narrower than the grid."""
    setting, omega_0 = good("order 4"), 13.0
    structure = structure_of(setting.spec)
    zeta, tall, middle = 1e-3, 4.0, 1.0  # |1−Q̃| in the middle of the peak is about four
    grid_ = Grids.of(setting, omega_0, 4)
    gap = np.flatnonzero((grid_.omega > 50) & (grid_.omega < 60))[0]
    peak = float(np.sqrt(grid_.omega[gap] * grid_.omega[gap + 1]) / omega_0)
    zeros = [2 * zeta * tall / peak, middle / peak**2]
    x = np.array([np.log(50 / omega_0), np.log(peak), 0.7075, zeta, 0.8, *zeros])
    program = Program(setting, structure, FEW, omega_0)
    sharp = Candidate(structure.rounded(x, omega_0), 8.8, x)
    omega, _ = program.violated(sharp, grid_)
    assert omega and all(w == pytest.approx(peak * omega_0, rel=0.05) for w in omega)
    monkeypatch.setattr(Program, "resonances", lambda self, candidate: np.zeros(0))
    assert program.violated(sharp, grid_) == ([], []), "the grid alone steps over it"


def test_resonances_lie_around_the_poles_of_controller_and_loop() -> None:
    setting, omega_0 = good("order 4"), 25.0
    structure = structure_of(setting.spec)
    x = np.array([0.0, np.log(3.0), 0.02, 0.9, 0.5, 0.1, 0.1])
    program = Program(setting, structure, FEW, omega_0)
    found = program.resonances(Candidate(structure.rounded(x, omega_0), 10.0, x))
    own = found[np.abs(found / omega_0 - 1) < 0.1]
    assert np.min(np.abs(own / omega_0 - 1)) < 1e-9 and own.size >= 19, "the pole itself, and around it"
    assert not np.any(np.abs(found / (3 * omega_0) - 1) < 1e-3), "the other pair is no resonance"
    C = setting.compensator(structure.rounded(x, omega_0))
    closed = np.roots([float(c) for c in descending(setting.loop.Q_tilde(C).den)])
    light = closed[(closed.imag > 0) & (-closed.real < 0.3 * np.abs(closed))]
    assert light.size and all(np.min(np.abs(found / abs(pole) - 1)) < 1e-3 for pole in light)
