"""What only the solver shows infeasible: which constraint, where, by how much; and advice that was tried."""

from __future__ import annotations

import re
from importlib import import_module

import numpy as np
import pytest
from good_joint import setting

from robimp.synthesis.errors import ExitCode, InfeasibleError, UndecidedError
from robimp.synthesis.pipeline import synthesize
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.bound import SLOW, bound, wide_program
from robimp.synthesis.solve.cone import Failure
from robimp.synthesis.solve.infeasible import impossible, unattainable
from robimp.synthesis.solve.relaxation import Relaxation, smallest_relaxation
from robimp.synthesis.solve.unmet import attainable, unmet
from robimp.synthesis.spec.model import Spec

infeasible = import_module("robimp.synthesis.solve.infeasible")
STIFF = ("damping: 0.35, stiffness: 1.25", "damping: 0.01, stiffness: 20")
NARROW = ("damping: 0.35, stiffness: 1.25", "damping: 0.35, stiffness: [0.2, 100]")
LATE = ("impedance:", "sampling: {rate: 1 kHz, delay: 500 ms}\nimpedance:")
QUIET_AND_SLOW = ("peak: 2.0", "peak: 2.0, noise: {gain: 0.05, above: 1}")
LOUD = ("peak: 2.0", "peak: 2.0, noise: {gain: 0.5}")


@pytest.mark.parametrize("change", [STIFF, NARROW, LATE], ids=["stiff", "range", "delay"])
def test_no_frequency_refutes_it_but_the_program_does(change: tuple[str, str]) -> None:
    joint = setting(change)
    assert impossible(joint) is None, "at each frequency some X does"
    found = unmet(joint)
    assert found is not None and found.what.startswith("(12) structured") and not attainable(joint)
    text = str(found.error())
    assert isinstance(found.error(), UndecidedError) and found.error().exit_code is ExitCode.UNDECIDED
    assert "no proof" in text and "48 basis functions" in text and f"ω = {found.omega:.4g} rad/s" in text


def test_a_joint_that_has_a_bound_is_not_excluded() -> None:
    assert unmet(setting()) is None and attainable(setting())


def test_the_shortfall_is_what_the_best_response_of_the_program_has() -> None:
    """On a grid of our own, between the program's points, Re(Z/jω) of its Q̃ is what the message says it is."""
    joint = setting(STIFF)
    found = unmet(joint)
    assert found is not None
    match = re.search(r"the most such a Q̃ reaches is (-[\d.]+)", found.why)
    assert match is not None
    program = wide_program(joint, 48, ["eq12"], SLOW)
    program.level(program.omega[0], "eq12")
    (constraint,) = (c for c in constraints(joint) if c.id == "eq12" and c.required)
    at = Evaluator(joint, program.omega)
    sides = [q.sides(0.0, 0.0, program.X, at.at) for q in constraint.inequalities]
    least = min(float(np.min(right - left)) for left, right in sides)
    assert least == pytest.approx(float(match[1]), rel=0.02) and least < -0.05
    with_more_damping = setting((STIFF[0], "damping: 0.3, stiffness: 20"))
    assert unmet(with_more_damping) is None, "and where it suffices nothing is said"


def test_slow_poles_are_tried_before_it_is_said_that_nothing_is_feasible() -> None:
    """Noise limited from 1 rad/s upwards leaves a band below it, which poles of the joint's own speed cannot use."""
    joint = setting(QUIET_AND_SLOW)
    fast = wide_program(joint, 48)
    assert fast.largest_band(fast.basis.around, coarse=True) is Failure.INFEASIBLE
    limit = bound(joint, 20)
    assert limit is not None and 0.1 < limit.omega_B < 1


def test_the_advice_is_tried_and_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the two kinds of infeasible joints: what a user is told to change really makes `synth` succeed."""
    for change, error in ((STIFF, UndecidedError), (LOUD, InfeasibleError)):
        advised: list[Relaxation | None] = []

        def kept(*arguments: object, to: list[Relaxation | None] = advised) -> Relaxation | None:
            to.append(smallest_relaxation(*arguments))  # type: ignore[arg-type]
            return to[-1]

        monkeypatch.setattr(infeasible, "smallest_relaxation", kept)
        with pytest.raises(error, match="with which a controller was found: ") as caught:
            synthesize(setting(change, ("order: 4", "form: eq23")).spec)
        (relaxation,) = advised
        assert relaxation is not None and relaxation.omega_B is not None and relaxation.text in str(caught.value)
        result = synthesize(relaxation.spec)
        assert result.exit_code is ExitCode.PROVEN


def test_advice_goes_as_far_as_it_takes_and_says_when_nothing_was_found() -> None:
    spec = setting(STIFF).spec
    tried: list[float] = []

    def reached(of: Spec) -> float | None:
        tried.append(float(of.impedance.damping))  # type: ignore[arg-type]
        return 3.0 if len(tried) == 3 else None

    found = smallest_relaxation(spec, lambda s: float(s.impedance.damping) >= 0.2, reached)  # type: ignore[arg-type]
    assert found is not None and found.omega_B == 3.0 and tried == sorted(tried) and len(tried) == 3
    assert float(found.text.split("→")[1]) == pytest.approx(tried[-1]) and tried[0] == pytest.approx(0.2, rel=0.03)
    vain = unattainable(setting(STIFF), lambda _: None)
    assert vain is not None and "finds no controller with it" in vain.remedy
    untried = unattainable(setting(STIFF))
    assert untried is not None and "removes it" in untried.remedy


def test_without_time_the_advice_is_not_tried() -> None:
    def late(_: Spec) -> float | None:
        raise UndecidedError("out of time")

    found = unattainable(setting(STIFF), late)
    assert found is not None and "the smallest single change that removes it" in found.remedy


def test_delay_and_ranges_are_relaxed_too() -> None:
    late, wide = setting(LATE).spec, setting(NARROW).spec
    shorter = smallest_relaxation(late, lambda s: s.sampling is not None and float(s.sampling.delay) <= 0.1)
    assert shorter is not None and shorter.text.startswith("sampling.delay 0.5 → 0.0")
    narrower = smallest_relaxation(wide, lambda s: Setting.of(s).impedances["stiffness"][1] <= 50)
    assert narrower is not None and re.match(r"impedance.stiffness \[0.2, 100\] → \[0.2, 4\d", narrower.text)
