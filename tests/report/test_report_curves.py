"""The curves against what is proven, what the simulation measures, and each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from report_pages import EQ23, PAPER, STIFF, UNSTABLE, study

from robimp.synthesis.problem.constraints.inequality import Role
from robimp.synthesis.report.html.curves import Level, filters, levels, nyquist, ports
from robimp.synthesis.report.html.margins import margins, sensitivity
from robimp.synthesis.report.html.study import Study
from robimp.synthesis.report.html.traces import simulated
from robimp.synthesis.simulation import assemble, loads

FEEDBACK = PAPER.parent / "feedback-both.json"
WEIGHT = PAPER.parent / "weight-disc.json"
ROUNDING = 1e-6  # relative, of values in floating point


def proven(checked: Study) -> list[Level]:
    return [
        found for found in levels(checked) if found.checked.word == "proven" and found.checked.claim.id != "bandwidth"
    ]


def violation(found: Level, checked: Study, margin: float) -> float:
    """How far a curve is on the wrong side of a margin, somewhere on the claim's interval; relative."""
    low, high = found.checked.claim.interval
    inside = (checked.omega >= float(low)) & (checked.omega <= (np.inf if high is None else float(high)))
    beyond = (margin - found.values[inside]) * found.constraint.role.harder
    return float(np.nanmax(beyond) / max(abs(margin), 1e-3))


@pytest.mark.parametrize("path", [PAPER, EQ23, FEEDBACK, WEIGHT], ids=lambda path: path.stem)
def test_every_curve_stays_on_the_proven_side_of_its_margin(path: Path) -> None:
    checked = study(path)
    found = proven(checked)
    assert len(found) >= 3
    for level in found:
        margin = float(level.checked.claim.margin or 0)
        assert violation(level, checked, margin) < ROUNDING, level.checked.claim.id
        worse = margin + level.constraint.role.harder * (abs(margin) or 1)
        if level.checked.claim.refuted_at is not None:
            assert violation(level, checked, worse) > ROUNDING, "a level that is not proven would pass, too"


@pytest.mark.parametrize("path", [PAPER, EQ23], ids=lambda path: path.stem)
def test_witnesses_lie_on_the_curves(path: Path) -> None:
    checked, seen = study(path), 0
    for level in proven(checked):
        failing = level.checked.claim.refuted_at
        if failing is None or failing.witness is None or failing.witness.omega is None:
            continue
        k = int(np.argmin(np.abs(checked.omega - float(failing.witness.omega))))
        assert checked.omega[k] == pytest.approx(float(failing.witness.omega))
        assert level.values[k] == pytest.approx(float(failing.value), rel=1e-3, abs=1e-6)
        seen += 1
    assert seen >= 4


def test_a_refuted_constraint_is_seen_to_fail() -> None:
    level = next(found for found in levels(study(STIFF)) if found.checked.claim.id == "eq12")
    assert np.nanmin(level.values) == pytest.approx(-0.053, abs=1e-3)
    assert study(STIFF).omega[np.nanargmin(level.values)] == pytest.approx(51.3, abs=0.3)


def test_a_factor_is_zero_where_nothing_holds() -> None:
    paper = next(f for f in levels(study(PAPER)) if f.checked.claim.form == "paper")
    assert paper.constraint.role is Role.RADIUS
    assert np.nanmin(paper.values) >= 0


@pytest.mark.parametrize("path", [PAPER, FEEDBACK], ids=lambda path: path.stem)
def test_the_apparent_impedance_is_what_the_simulated_joint_renders(path: Path) -> None:
    checked = study(path)
    inside = (checked.omega > 1) & (checked.omega < 300)
    nominal = next(port for port in ports(checked) if port.nominal)
    joint = assemble(checked.spec, checked.C, loads(checked.spec)[0])
    Z = 1 / joint.compliance(checked.omega[inside])
    assert np.abs(nominal.Z[inside] / Z - 1).max() < 1e-6
    corner = next(port for port in ports(checked) if not port.nominal)
    assert np.abs(corner.Z[inside] / Z - 1).max() > 1e-3


def test_discs_touch_minus_one_where_the_level_of_18_is_one() -> None:
    checked = study(PAPER)
    found = nyquist(checked)
    level = next(f for f in levels(checked) if f.checked.claim.id == "eq18")
    with np.errstate(all="ignore"):
        ratio = np.abs(1 + found.ell) / found.radius
    known = np.isfinite(ratio) & np.isfinite(level.values)
    assert known.sum() > 100
    assert np.allclose(ratio[known], level.values[known], rtol=1e-6)


def test_disturbances_are_attenuated_up_to_the_bandwidth() -> None:
    checked = study(PAPER)
    left = np.abs(dict(filters(checked))["|1−Q̃|"])
    assert left[checked.omega <= checked.omega_B].max() <= 0.3 * (1 + ROUNDING)
    assert left[checked.omega > 1.01 * checked.omega_B].max() > 0.3
    (tint,) = sensitivity(checked).shapes
    assert tint["x1"] == checked.omega_B


def test_only_what_is_verified_is_tinted() -> None:
    tinted = {figure.title: bool(figure.shapes) for figure in margins(study(STIFF))}
    assert tinted["eq9 (9) · printed"] and not tinted["eq12 (12) · structured"]
    assert not sensitivity(study(STIFF)).shapes


def test_steps_settle_where_the_desired_stiffness_says() -> None:
    found = simulated(study(PAPER))
    assert found is not None and found.wish is not None
    assert len(found.traces) == 5
    settled = found.traces[0].step.theta[-1]
    assert settled == pytest.approx(1 / 1.25, rel=2e-2)
    assert found.wish[1][-1] == pytest.approx(1 / 1.25, rel=2e-2)
    assert all(trace.tone is not None and trace.tone.energy.min() >= -1e-12 for trace in found.traces)


def test_a_refuted_passivity_shows_in_the_energy() -> None:
    found = simulated(study(STIFF))
    assert found is not None
    assert min(trace.tone.energy.min() for trace in found.traces if trace.tone is not None) < -1e-6


def test_unstable_joints_are_told_apart() -> None:
    found = simulated(study(UNSTABLE))
    assert found is not None
    assert not any(trace.stable for trace in found.traces)
    assert all(trace.tone is None for trace in found.traces)
