"""Small maps: an ideal joint with a given controller, cells of a fraction of a second."""

from __future__ import annotations

from pathlib import Path

import pytest

SPEC = """
robimp: 1
name: small
motion: rotary
plant: {inertia: 0.05, damping: 0.3, stiffness: 2}
uncertainty: {box: {inertia: ±10 %, damping: ±30 %, stiffness: [2, 2]}}
actuator: {type: ideal}
impedance: {inertia: nominal, damping: 0.5, stiffness: 5}
controller: {type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}
objective: {maximize: bandwidth, attenuation: 0.5}
constraints: {eq12: {form: structured}, peak: 2}
"""


GIVEN = "coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}"


@pytest.fixture
def searched(tmp_path: Path) -> Path:
    """The same joint with a controller to find."""
    path = tmp_path / "searched.yaml"
    path.write_text(SPEC.replace(GIVEN, "order: 2"), encoding="utf-8")
    return path


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(SPEC, encoding="utf-8")
    return path
