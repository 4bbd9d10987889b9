"""`control` and NumPy at the edges: controllers in and out, exact inside, faults as clear as in a file."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from robimp.synthesis import ExitCode, InputError, Polynomials, Result, judge, load, report, simulate, synthesize
from robimp.synthesis.spec.given import given

EXACT = Polynomials(numerator=(Fraction(2000),), denominator=(Fraction(1), Fraction(283, 4), Fraction(2500)))
GIVEN: dict[str, Any] = {
    "control": control.tf([2000], [1, 70.75, 2500]),
    "lists": ([2000], [1, 70.75, 2500]),
    "arrays": (np.array([2000]), np.array([1, 70.75, 2500])),
    "exact text": (["2000"], ["1", "283/4", "2.5e3"]),
    "fractions": ([Fraction(2000)], [1, Fraction(283, 4), Decimal(2500)]),
    "its own": EXACT,
}


@pytest.mark.parametrize("system", GIVEN.values(), ids=GIVEN)
def test_a_controller_is_taken_exactly(system: Any) -> None:
    assert given(system, "dob") == EXACT


def test_one_at_infinity_is_no_matter_for_a_compensator() -> None:
    assert given(([1, 1], [1, 2]), "dynamic-feedback").numerator == (1, 1)


def test_it_is_printed_as_one_writes_it() -> None:
    assert str(given(([-1, 0, -2.5], [1, -1, 3]), "dob")) == "(-s^2 − 2.5) / (s^2 − s + 3)"


def test_a_double_is_the_number_it_is() -> None:
    assert given(([0.1], [1, 1]), "dob").numerator == (Fraction(0.1),) != (Fraction(1, 10),)
    assert given((["0.1"], [1, 1]), "dob").numerator == (Fraction(1, 10),)


REFUSED: dict[str, tuple[Any, str]] = {
    "discrete": (control.tf([1], [1, 2], 0.1), "continuous"),
    "two outputs": (control.tf([[[1]], [[1]]], [[[1, 1]], [[1, 2]]]), "one input and one output"),
    "state space": (control.ss(-1, 1, 1, 0), "transfer function"),
    "a number": (3, "found int"),
    "three lists": (([1], [2], [3]), "a pair"),
    "a bare number": ((1, [1, 2]), "write [1]"),
    "text": (("1", [1, 2]), "write ['1']"),
    "nan": (([float("nan")], [1, 2]), "must be finite"),
    "infinity": (([1], [np.inf, 2]), "denominator[0]"),
    "complex": (([1j], [1, 2]), "numerator[0]: expected a number"),
    "no number": (([None], [1, 2]), "numerator[0]: expected a number"),
    "empty": (([], [1, 2]), "an empty list"),
    "zero denominator": (([1], [0, 0]), "every coefficient is zero"),
    "improper": (([1, 2, 3], [1, 2]), "at most 2 coefficients"),
    "Q of 1 at infinity": (([1, 1], [1, 2]), "expected Q(∞) ≠ 1"),
    "its own, of 1 at infinity": (Polynomials(numerator=(Fraction(1),), denominator=(Fraction(1),)), "Q(∞) = 1"),
    "too long": (([1], [1] * 70), "degree of at most 60"),
}


@pytest.mark.parametrize(("system", "message"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_controller_is_refused(system: Any, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        given(system, "dob")
    assert message in str(refusal.value) and str(refusal.value).startswith("controller: ")


def test_a_result_goes_to_control_and_back(result: Result) -> None:
    assert result.Q is not None and given(result.Q.to_control(), "dob") == result.Q == EXACT
    omega = np.geomspace(0.1, 1000, 20)
    Q, C = (part.to_control()(1j * omega) for part in (result.Q, result.C))
    assert np.allclose(C, Q / (1 - Q)), "(10)"


def test_a_controller_from_control_is_certified_like_the_specifications(result: Result, folder: Path) -> None:
    searched = folder / "searched.yaml"
    text = Path("examples/haninger2016-paper.yaml").read_text(encoding="utf-8")
    head, _, tail = text.partition("  coefficients:")
    searched.write_text(f"{head}  order: 4\n{tail.partition(chr(10))[2]}", encoding="utf-8")
    assert load(searched).controller.order == 4
    certified = synthesize(searched, controller=control.tf([2000], [1, 70.75, 2500]))
    assert (certified.omega_B, certified.exit_code) == (result.omega_B, ExitCode.PROVEN)
    assert certified.spec.controller.order is None
    with pytest.raises(InputError, match="not proper"):
        synthesize(searched, controller=([1, 2], [1, 2]))


def test_a_file_and_what_was_loaded_from_it_are_one(folder: Path) -> None:
    path = "examples/haninger2016-paper.yaml"
    assert judge("certificate.json", spec=path).exit_code == judge("certificate.json", spec=load(path)).exit_code == 0
    assert load(path) == load(Path(path))


def test_a_page_is_written_and_its_outcome_told(folder: Path) -> None:
    assert report(["certificate.json"], folder / "page.html", time_limit=30) == (ExitCode.PROVEN,)
    assert (folder / "page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    with pytest.raises(InputError, match="would overwrite"):
        report("certificate.json", "certificate.json")


def test_what_is_no_certificate_is_refused(folder: Path) -> None:
    Path("broken.json").write_text("{}", encoding="utf-8")
    for use in (simulate, lambda file: report(file, "page.html")):
        with pytest.raises(InputError, match=r"broken\.json"):
            use("broken.json")
