"""The examples reach the figures they are kept for, and reach them again: proven, not hoped."""

from __future__ import annotations

import copy
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robimp.synthesis import ExitCode, Result, load, synthesize
from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.check import canonical_json, check_bytes
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.structure import QFilter
from robimp.synthesis.spec import spec_warnings
from robimp.synthesis.spec.model import SeriesElasticActuator

EXAMPLES = Path(__file__).parents[1] / "examples"
SEARCHED = ("haninger2016", "haninger2016-eq23")
ACTUATORS = {  # published ones: rounded-down ω_B [rad/s] of order 2, and the motor on its spring, output locked [Hz]
    "hyq-leg": (57, 18.9),
    "ozyegin-sea": (41, 6.7),
    "tree-avocado": (33, 60.0),
    "tree-lemon": (40, 45.0),
    "tree-orange": (27, 22.4),
    "ut-sea": (30, 5.0),
}


@pytest.fixture(scope="session")
def result() -> Callable[[str], Result]:
    """An example's result; each is computed once."""
    return cache(lambda name: synthesize(load(EXAMPLES / f"{name}.yaml")))


Results = Callable[[str], Result]


def test_order_4_on_the_reference_joint(result: Results) -> None:
    reference = result("haninger2016")
    assert reference.exit_code is ExitCode.PROVEN
    assert 40 <= reference.omega_B < 42


def test_the_papers_form_optimised(result: Results) -> None:
    eq23 = result("haninger2016-eq23")
    assert eq23.exit_code is ExitCode.PROVEN
    assert 13 <= eq23.omega_B < Fraction("13.5")
    assert len(eq23.coefficients.numerator) == 1 and len(eq23.coefficients.denominator) == 3


def test_the_papers_own_tuning(result: Results) -> None:
    paper = result("haninger2016-paper")
    assert paper.exit_code is ExitCode.PROVEN and paper.bound is None
    assert Fraction("8.87") < paper.omega_B < Fraction("8.88")


def test_the_papers_tuning_for_its_whole_range_sampled_and_rounded(result: Results) -> None:
    sampled = result("haninger2016-sampled")
    proven = {(c.id, c.form): c.margin for c in sampled.claims if c.required}
    assert sampled.exit_code is ExitCode.PROVEN
    assert Fraction("8.83") < sampled.omega_B < Fraction("8.84")
    assert proven["tolerance", "coefficients"] >= Fraction(1, 2**24)  # type: ignore[operator]
    assert {("stability-free", "winding"), ("stability-locked", "winding"), ("stability-free", "box")} <= proven.keys()


def test_each_is_better_than_the_one_before_and_none_beats_the_bound(result: Results) -> None:
    paper, eq23, reference = (result(name) for name in ("haninger2016-paper", "haninger2016-eq23", "haninger2016"))
    assert reference.bound is not None and reference.bound.growth is not None and reference.bound.growth < 0.01
    assert 51.5 <= reference.bound.omega_B < 54
    assert paper.omega_B < eq23.omega_B < reference.omega_B < reference.bound.omega_B
    assert eq23.bound is not None and eq23.bound.omega_B == pytest.approx(reference.bound.omega_B, rel=0.01)


@pytest.mark.parametrize("name", [*SEARCHED, "haninger2016-paper"])
def test_a_dense_grid_sees_what_was_proven(result: Results, name: str) -> None:
    """Floats on 20,000 frequencies: nothing here is used by the proof."""
    found = result(name)
    setting = Setting.of(found.spec)
    C, omega = setting.compensator(found.coefficients), np.geomspace(1e-3, 1e5, 20_000)
    left, omega_B = np.abs(1 - setting.loop.Q_tilde(C).at(omega)), float(found.omega_B)
    assert np.all(left[omega <= omega_B] <= 0.3 + 1e-9)
    assert np.any(left[(omega > omega_B) & (omega < 1.01 * omega_B)] > 0.3), "ω_B could be larger"
    assert left.max() <= 2
    for load_ in setting.uncertainty.corners():
        resistance = (setting.loop.Z(C, load_).at(omega) / (1j * omega)).real
        assert resistance.min() > -1e-9
    for pencil in (setting.loop.locked(), setting.loop.free(setting.loop.nominal)):
        polynomial = pencil(C)
        scaled = polynomial / polynomial.leading_coefficient()
        assert np.roots([int(c.p) / int(c.q) for c in scaled.coeffs()[::-1]]).real.max() < 0


@pytest.mark.parametrize("name", SEARCHED)
def test_what_is_shipped_has_few_digits(result: Results, name: str) -> None:
    coefficients = result(name).coefficients
    for c in (*coefficients.numerator, *coefficients.denominator):
        assert c == Fraction(f"{float(c):.5e}")
    assert float(Fraction(1, 3)) != Fraction(f"{1 / 3:.5e}")


@pytest.mark.parametrize("name", [*SEARCHED, "haninger2016-paper"])
def test_the_independent_checker_confirms_it_and_refuses_a_little_more(result: Results, name: str) -> None:
    certificate = result(name).certificate
    assert check_bytes(json.dumps(certificate).encode()).exit_code == ExitCode.PROVEN
    assert check_bytes(json.dumps(faster(certificate)).encode()).exit_code == ExitCode.REFUTED


def faster(certificate: dict[str, Any]) -> dict[str, Any]:
    """A sealed certificate that promises 0.1 % more bandwidth."""
    edited = copy.deepcopy(certificate)
    omega_B = Fraction(edited["bandwidth"]["proven"]) * Fraction("1.001")
    edited["bandwidth"] = {"proven": str(omega_B), "refuted_at": None, "bound": edited["bandwidth"]["bound"]}
    for claim in edited["claims"]:
        if claim["id"] in ("bandwidth", "rendering"):
            claim["interval"][1], claim["refuted_at"] = str(omega_B), None
        if claim["id"] == "bandwidth":
            claim["margin"] = str(omega_B)
    body = {key: part for key, part in edited.items() if key != "end"}
    edited["end"]["body_sha256"] = sha256(canonical_json(body)).hexdigest()
    return edited


def test_another_process_finds_the_same_coefficients(result: Results, tmp_path: Path) -> None:
    script = "from robimp.synthesis.cli import main\nmain()"
    subprocess.run(
        [sys.executable, "-c", script, "synth", str(EXAMPLES / "haninger2016.yaml"), "-o", str(tmp_path)],
        check=True,
        capture_output=True,
        timeout=120,
        env={**os.environ, "PYTHONHASHSEED": "12345"},
    )
    again = json.loads((tmp_path / "certificate.json").read_text(encoding="utf-8"))
    assert again == result("haninger2016").certificate
    starts = [QFilter(4).start(np.random.default_rng(seed)) for seed in (0, 0, 1)]
    assert np.array_equal(starts[0], starts[1]) and not np.array_equal(starts[0], starts[2]), "the seed decides"


def test_every_example_is_named_as_its_file_and_has_an_outcome(result: Results) -> None:
    outcomes = {
        "haninger2016": ExitCode.PROVEN,
        "haninger2016-eq23": ExitCode.PROVEN,
        "haninger2016-feedback": ExitCode.REFUTED,
        "haninger2016-paper": ExitCode.PROVEN,
        "haninger2016-sampled": ExitCode.PROVEN,
        "haninger2016-stiff": ExitCode.REFUTED,
        "hyq-leg": ExitCode.PROVEN,
        "ozyegin-sea": ExitCode.PROVEN,
        "tree-avocado": ExitCode.PROVEN,
        "tree-lemon": ExitCode.PROVEN,
        "tree-orange": ExitCode.PROVEN,
        "two-modes": ExitCode.PROVEN,
        "unstable-optimum": ExitCode.REFUTED,
        "ut-sea": ExitCode.PROVEN,
    }
    assert set(outcomes) == {path.stem for path in EXAMPLES.glob("*.yaml")}
    for name, outcome in outcomes.items():
        assert result(name).spec.name == name
        assert result(name).exit_code is outcome


@pytest.mark.parametrize("name", ACTUATORS)
def test_a_published_actuator_is_certified_for_every_load(result: Results, name: str) -> None:
    omega_B, _ = ACTUATORS[name]
    found = result(name)
    assert found.exit_code is ExitCode.PROVEN and found.robust and not found.agreement.contradictions
    assert found.omega_B >= omega_B
    assert check_bytes(found.certificate_bytes()).exit_code == ExitCode.PROVEN


@pytest.mark.parametrize("name", ACTUATORS)
def test_a_published_actuator_has_plausible_units_and_says_which_numbers_are_published(name: str) -> None:
    path = EXAMPLES / f"{name}.yaml"
    spec, hertz = load(path), ACTUATORS[name][1]
    assert spec_warnings(spec) == ()
    assert isinstance(spec.actuator, SeriesElasticActuator)
    resonance = np.sqrt(float(spec.actuator.spring_stiffness / spec.actuator.motor_inertia)) / (2 * np.pi)
    assert resonance == pytest.approx(hertz, abs=0.06)
    text = path.read_text(encoding="utf-8")
    for key in ("inertia", "damping", "motor_inertia", "motor_damping", "spring_stiffness", "torque_loop"):
        line = next(line for line in text.splitlines() if line.startswith(f"  {key}:"))
        assert "[published]" in line or "[illustrative]" in line
    loop = spec.actuator.torque_loop  # locked: J s² + (b + K kd)s + K(1+kp), but for the derivative's corner
    natural = np.sqrt(float(spec.actuator.spring_stiffness * (1 + loop.kp) / spec.actuator.motor_inertia))
    damping = float(spec.actuator.motor_damping + spec.actuator.spring_stiffness * loop.kd)
    assert 0.6 < damping / (2 * float(spec.actuator.motor_inertia) * natural) < 0.8
    assert f"= {natural:.0f} rad/s" in text


def test_two_flexible_modes_are_those_of_the_masses_and_springs(result: Results) -> None:
    """`J₁θ̈₁ + b₁θ̇₁ = τ_m − τ_t`, `J₂θ̈₂ + b₂θ̇₂ = τ_t − τ_sea`, `τ_t = (k₁ + c₁s)(θ₁ − θ₂)`, `τ_sea = k₂(θ₂ − θ)`."""
    J1, b1, J2, b2, k1, c1, k2 = 0.008, 0.04, 0.002, 0.01, 400.0, 1.0, 4.8
    actuator = result("two-modes").spec.actuator
    for s in 1j * np.geomspace(0.3, 3000, 25):
        C_t, transmission = 10 + 0.25 * s / (1 + s / 1000), k1 + c1 * s
        A = [
            [J1 * s**2 + b1 * s + transmission, -transmission + C_t * k2],
            [-transmission, J2 * s**2 + b2 * s + transmission + k2],
        ]
        for port, torque, angle, sign in ((actuator.transfer, 1, 0, 1), (actuator.impedance, 0, 1, -1)):
            theta = np.linalg.solve(A, [(1 + C_t) * torque + C_t * k2 * angle, k2 * angle])
            numerator, denominator = (
                np.polyval([float(c) for c in part], s) for part in (port.numerator, port.denominator)
            )
            assert numerator / denominator == pytest.approx(sign * k2 * (theta[1] - angle), rel=1e-6)


def test_an_order_8_filter_on_two_flexible_modes_is_proven_and_checked_in_ten_seconds(result: Results) -> None:
    found = result("two-modes")
    assert len(found.coefficients.denominator) == 9
    assert float(found.omega_B) > 48
    began = time.process_time()
    claims = certify(Setting.of(found.spec), Setting.of(found.spec).compensator(found.coefficients))
    assert all(claim.status is Outcome.PROVEN for claim in claims if claim.required)
    assert check_bytes(found.certificate_bytes()).exit_code == ExitCode.PROVEN
    assert time.process_time() - began < 10
