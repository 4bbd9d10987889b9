"""What is allowed but unlikely to be meant is said, and nothing else."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from robimp.synthesis.spec import parse_spec, spec_warnings

Edit = Callable[..., str]
Pairs = list[tuple[str, str]]


@pytest.mark.parametrize(
    ("pairs", "warned"),
    [
        ([("spring_stiffness: 4.8", "spring_stiffness: 480000")], ["637 Hz", "spring_stiffness"]),
        ([("spring_stiffness: 4.8", "spring_stiffness: 1e300")], ["9.19e+149 Hz"]),
        ([("stiffness: 1.25", "stiffness: 0.001")], ["impedance.stiffness", "0.0291 Hz"]),
        ([("stiffness: 1.25", "stiffness: 10")], ["impedance.stiffness 10 exceeds actuator.spring_stiffness 4.8"]),
        ([("order: 4", "order: 4, filters: {force: 100, position: none}")], ["equal filters render better"]),
        ([("order: 4", "order: 4, filters: {force: 100, position: 200}")], ["equal filters render better"]),
        ([("order: 4", "order: 4, filters: {position: 200}")], ["equal filters render better"]),
        ([("form: structured", "form: disc")], ["cannot hold up to ω = ∞"]),
        ([("form: structured", "form: paper")], ["write `form: structured`"]),
    ],
)
def test_a_warning(pairs: Pairs, warned: list[str], edit: Edit) -> None:
    warnings = spec_warnings(parse_spec(edit(*pairs)))
    assert len(warnings) == 1
    assert all(fragment in warnings[0] for fragment in warned)


@pytest.mark.parametrize(
    "pairs",
    [
        [],
        [("stiffness: 1.25", "stiffness: 0")],
        [("stiffness: 1.25", "stiffness: 4.8")],
        [("order: 4", "order: 4, filters: {force: 100}")],
        [("order: 4", "order: 4, filters: {force: 100, position: 100}")],
        [("order: 4", "order: 4, filters: {position: none}")],
        [("form: structured", "form: disc, band: [0, 50]")],
        [("form: structured", "form: disc"), ("inertia: ±20 %", "inertia: [0.03, 0.03]")],
    ],
)
def test_no_warning(pairs: Pairs, edit: Edit) -> None:
    assert spec_warnings(parse_spec(edit(*pairs))) == ()
