"""The bound from above: a convex program on a grid that hides nothing, and what is said where it has no answer."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from good_joint import setting

from robimp.synthesis.errors import UndecidedError
from robimp.synthesis.pipeline import synthesize
from robimp.synthesis.problem.grid import frequency_scale, grid
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.band import BandProgram
from robimp.synthesis.solve.basis import Basis
from robimp.synthesis.solve.bound import Bound, resolving
from robimp.synthesis.solve.cone import Block, Failure, Solution, minimise
from robimp.synthesis.spec import from_canonical, parse_spec

bound_module, band_module = (import_module(f"robimp.synthesis.solve.{name}") for name in ("bound", "band"))
compute_bound = bound_module.bound
DATA = Path(__file__).parents[1] / "data"
IDEAL = """
robimp: 1
name: ideal
motion: rotary
plant: {inertia: 0.05, damping: 0.3, stiffness: 2}
uncertainty: {box: {inertia: ±10 %, damping: ±30 %, stiffness: [1.5, 2.5]}}
actuator: {type: ideal}
impedance: {inertia: nominal, damping: 0.5, stiffness: 5}
controller: {type: dob, order: 2}
objective: {maximize: bandwidth, attenuation: 0.5}
constraints: {eq9: {}, eq12: {form: structured}, peak: 1.8}
"""


def ideal() -> Setting:
    return Setting.of(parse_spec(IDEAL))


@pytest.fixture(scope="module")
def bounds() -> dict[int | None, Bound]:
    return {terms: compute_bound(setting(), terms) for terms in (20, 32, 75, None)}


def test_a_larger_basis_never_lowers_the_bound_until_it_has_converged(bounds: dict[int | None, Bound]) -> None:
    converged = bounds[None]
    assert 35 < bounds[20].omega_B < 0.99 * bounds[32].omega_B < 0.99 * converged.omega_B, "a coarse basis gives less"
    assert bounds[20].growth is None, "one basis says nothing about its convergence"
    assert converged.growth is not None and 0 <= converged.growth < 0.01 and converged.stopped == ""
    assert converged.omega_B <= bounds[75].omega_B < 1.01 * converged.omega_B, "and enlarging it further adds little"
    assert 52.5 < converged.omega_B < 54.5 and converged.dropped == ("eq9", "eq18")


def limit(joint: Setting, omega: np.ndarray, basis: Basis) -> float:
    found = BandProgram(joint, omega, basis).largest_band(basis.around)
    assert isinstance(found, float)
    return found


@pytest.mark.parametrize(("joint", "around"), [(setting, 53.4), (ideal, 150.8)], ids=["series-elastic", "ideal"])
def test_a_grid_twice_as_fine_changes_nothing_and_a_coarse_one_flatters(joint: Any, around: float) -> None:
    basis = Basis(around, 48, 2, frequency_scale(joint())[1])
    used = limit(joint(), resolving(joint(), basis), basis)
    assert limit(joint(), resolving(joint(), basis, 8), basis) == pytest.approx(used, rel=0.002)
    coarse = grid(joint(), around=around, spread=80, dense=160)
    assert limit(joint(), coarse, basis) > 1.02 * used, "between its points every constraint is violated"


def test_poles_that_end_below_the_joints_own_frequencies_would_set_the_limit_themselves() -> None:
    narrow, wide = (Basis(53.0, 48, 2, highest) for highest in (0.0, frequency_scale(setting())[1]))
    assert limit(setting(), resolving(setting(), narrow), narrow) < limit(setting(), resolving(setting(), wide), wide)


def test_the_bound_says_what_binds_and_where(bounds: dict[int | None, Bound]) -> None:
    binding = {b.constraint: b for b in bounds[None].binding}
    assert set(binding) == {"eq12", "bandwidth"}, "passivity limits this joint, not the peak"
    assert binding["bandwidth"].high <= 1.001 * bounds[None].omega_B < binding["eq12"].low
    assert all(b.low <= b.most <= b.high for b in binding.values())


def test_without_passivity_the_bound_is_far_higher(bounds: dict[int | None, Bound]) -> None:
    without = compute_bound(setting(("eq12: {form: structured}, ", "")), 20)
    assert without is not None and without.omega_B > 1.5 * bounds[20].omega_B


def test_a_range_of_impedances_and_a_hold_lower_the_bound(bounds: dict[int | None, Bound]) -> None:
    for changed in (
        ("stiffness: 1.25", "stiffness: [0.2, 10]"),
        ("peak: 2.0}", "peak: 2.0}\nsampling: {rate: 100 Hz, delay: 5 ms}"),
    ):
        lower = compute_bound(setting(changed), 20)
        assert lower is not None and lower.omega_B < 0.97 * bounds[20].omega_B


# A bound below what is proven would be none


@pytest.mark.parametrize("file", sorted((DATA / "golden").glob("*.json")), ids=lambda f: f.stem)
def test_no_certificate_has_more_than_the_bound(file: Path) -> None:
    certificate = json.loads(file.read_text(encoding="utf-8"))
    found = compute_bound(Setting.of(from_canonical(certificate["spec"], file.name)), 24)
    assert found is not None and found.omega_B > float(Fraction(certificate["bandwidth"]["proven"]))


def test_a_bound_below_the_proven_bandwidth_is_computed_again_or_withdrawn(
    monkeypatch: pytest.MonkeyPatch, bounds: dict[int | None, Bound]
) -> None:
    text = (Path(__file__).parents[2] / "examples" / "haninger2016-eq23.yaml").read_text(encoding="utf-8")
    low = replace(bounds[20], omega_B=10.0)
    for again, expected in ((low, None), (bounds[20], bounds[20].omega_B)):
        answers = iter([low, again])
        monkeypatch.setattr(bound_module, "bound", lambda *a, answers=answers, **k: next(answers))
        result = synthesize(parse_spec(text))
        assert result.omega_B > 13 and (result.bound and result.bound.omega_B) == expected
        assert (result.certificate["bandwidth"]["bound"] is None) == (expected is None)


# The cone programs


def program(joint: Setting) -> BandProgram:
    return BandProgram(joint, grid(joint, around=40.0, spread=60, dense=60), Basis(50.0, 24, 2, 800.0))


def test_the_level_grows_with_the_band_and_is_attained() -> None:
    """At every frequency, also those the cone program did not see: X is looked at with NumPy."""
    found = program(setting())
    levels = [found.level(omega_B) for omega_B in (20.0, 40.0, 60.0)]
    assert levels[0] < levels[1] < 1 < levels[2]  # type: ignore[operator]
    omega_B = found.largest_band(40.0)
    assert isinstance(omega_B, float)
    inside = found.omega <= omega_B
    left = np.abs(1 - found.X)
    assert left[inside].max() == pytest.approx(0.3, rel=2e-3)
    assert left.max() <= 2 + 1e-3
    for load in setting().uncertainty.corners():
        Z = found.X * setting().loop.G_imp.at(found.omega) + (1 - found.X) * setting().loop.Z0(load).at(found.omega)
        assert (Z / (1j * found.omega)).real.min() > -1e-3
    assert left[found.omega > omega_B].max() > 1, "beyond the band nothing is attenuated"


def test_frequencies_that_leave_the_program_make_it_smaller_and_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    solve, rows = band_module.minimise, list[int]()

    def counting(objective: Any, blocks: Any) -> Any:
        rows.append(sum(block.b.size for block in blocks))
        return solve(objective, blocks)

    def found() -> tuple[float, float]:
        rows.clear()
        omega_B = program(setting()).largest_band(40.0)
        assert isinstance(omega_B, float)
        return omega_B, float(np.mean(rows))

    monkeypatch.setattr(band_module, "minimise", counting)
    some, mean = found()
    monkeypatch.setattr(band_module._Watched, "release", lambda self: None)
    everything, mean_of_everything = found()
    assert some == pytest.approx(everything, rel=2 * band_module.LEVEL)
    assert mean < 0.8 * mean_of_everything


def test_a_frequency_leaves_the_program_only_once() -> None:
    """Or the same ones could come and go for ever."""
    none = np.zeros(0, int)
    watched = band_module._Watched(SimpleNamespace(), False, none, spread=np.array([0, 5, 9]))
    watched.begin()
    watched.tight = np.array([5])
    watched.release()
    assert list(watched.chosen) == [5]
    assert watched.join(np.array([5, 9])) and list(watched.chosen) == [5, 9]
    watched.release()
    assert list(watched.chosen) == [5, 9], "9 has come back, though it is not tight"
    assert not watched.join(np.array([5])), "nothing new"
    assert watched.join(np.array([3]))
    watched.release()
    assert list(watched.chosen) == [5, 9], "3 has not been here before"
    watched.begin()
    watched.release()
    assert list(watched.chosen) == [5], "another ω_B begins anew"


def test_the_basis_is_rational_stable_and_of_the_relative_degree() -> None:
    fast = np.array([1e7, 1e8])
    for roll_off in (0, 1, 2):
        values = Basis(50.0, 31, roll_off, 0.0).at(fast)
        assert values.shape == (2, 31)
        np.testing.assert_allclose(np.abs(values[0, 0] / values[1, 0]), 10.0**roll_off, rtol=1e-2)


def test_a_program_says_whether_it_has_no_solution_or_none_was_found() -> None:
    """minimise y subject to |y − 1| ≤ b: y = 1 − b, nothing for b < 0, no program at all for b not a number."""

    def of(b: float) -> Solution | Failure:
        disc = Block([(np.ones((1, 1), complex), -np.ones(1, complex))], np.zeros((1, 1)), np.array([b]))
        return minimise(np.ones(1), [disc])

    found = of(0.25)
    assert isinstance(found, Solution) and found.value == pytest.approx(0.75, abs=1e-5)
    assert of(-0.25) is Failure.INFEASIBLE
    assert of(np.nan) is Failure.UNSOLVED


def answering(monkeypatch: pytest.MonkeyPatch, status: str, scale: float) -> None:
    """Clarabel's status replaced, and its solution by a multiple of it."""
    import clarabel

    genuine = clarabel.DefaultSolver

    def solver(*arguments: Any) -> Any:
        found = genuine(*arguments).solve()
        answer = SimpleNamespace(x=scale * np.array(found.x), z=found.z, status=status)
        return SimpleNamespace(solve=lambda: answer)

    monkeypatch.setattr(clarabel, "DefaultSolver", solver)


@pytest.mark.parametrize(
    ("status", "scale", "expected"),
    [
        ("Solved", 0.98, Failure.UNSOLVED),
        ("AlmostSolved", 1 + 1e-7, None),
        ("AlmostSolved", 0.98, Failure.UNSOLVED),
        ("Solved", np.nan, Failure.UNSOLVED),
        ("NumericalError", 1.0, Failure.UNSOLVED),
        ("PrimalInfeasible", 1.0, Failure.INFEASIBLE),
    ],
)
def test_what_the_solution_attains_counts_not_the_solvers_word(
    monkeypatch: pytest.MonkeyPatch, status: str, scale: float, expected: Failure | None
) -> None:
    monkeypatch.setattr(band_module, "SHARE", 0.0)  # no level is left before it is sure of
    found = program(setting())
    answering(monkeypatch, status, scale)
    level = found.level(41.0)
    assert level is expected if expected is not None else isinstance(level, float)


def test_a_solver_that_fails_ends_the_enlargement_with_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    genuine = BandProgram.largest_band

    def up_to(most: int, self: BandProgram, start: float, *, coarse: bool = False) -> float | Failure:
        return genuine(self, start, coarse=coarse) if self.basis.terms <= most else Failure.UNSOLVED

    monkeypatch.setattr(bound_module, "FIRST_TERMS", 24)
    monkeypatch.setattr(BandProgram, "largest_band", lambda self, *a, **k: up_to(30, self, *a, **k))
    found = compute_bound(setting())
    assert found is not None and found.terms in (24, 30) and "vouches" in found.stopped
    monkeypatch.setattr(BandProgram, "largest_band", lambda self, *a, **k: up_to(20, self, *a, **k))
    fewer = compute_bound(setting())
    assert fewer is not None and fewer.terms == 19 and "vouches" in fewer.stopped and "24 terms" in fewer.stopped
    with pytest.raises(UndecidedError, match="no bound"):
        compute_bound(setting(), 24)  # what was asked for is not replaced
    monkeypatch.setattr(BandProgram, "largest_band", lambda self, *a, **k: up_to(10, self, *a, **k))
    with pytest.raises(UndecidedError, match="no bound"):
        compute_bound(setting())
    monkeypatch.setattr(BandProgram, "largest_band", lambda self, *a, **k: Failure.INFEASIBLE)
    assert compute_bound(setting()) is None
