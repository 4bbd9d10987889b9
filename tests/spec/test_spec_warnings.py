"""What is allowed but unlikely to be meant is said, and nothing else."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from spec_texts import EVERY_NEW_KEY, actuator, demand, motor, sampling, spring, stiffness, table

from robimp.synthesis.spec import parse_spec, spec_warnings

Edit = Callable[..., str]
Pairs = list[tuple[str, str]]


@pytest.mark.parametrize(
    ("pairs", "warned"),
    [
        ([("spring_stiffness: 4.8", "spring_stiffness: 480000")], ["637 Hz", "spring_stiffness"]),
        ([("spring_stiffness: 4.8", "spring_stiffness: 1e300")], ["9.19e+149 Hz"]),
        # the UT-SEA's linear spring on its rotary motor inertia, as a widely copied course file has it
        ([spring("3.5e5"), motor("0.225"), ("{inertia: 0.03", "{inertia: 1")], ["motor_inertia", "199 Hz", "rotary"]),
        ([spring("3.5e5"), motor("360"), ("{inertia: 0.03", "{inertia: 0.225")], ["plant.inertia", "199 Hz", "rotary"]),
        ([("stiffness: 1.25", "stiffness: 0.001")], ["impedance.stiffness", "0.0291 Hz"]),
        ([("stiffness: 1.25", "stiffness: 10")], ["impedance.stiffness 10 exceeds actuator.spring_stiffness 4.8"]),
        ([("order: 4", "order: 4, filters: {force: 100, position: none}")], ["equal filters render better"]),
        ([("order: 4", "order: 4, filters: {force: 100, position: 200}")], ["equal filters render better"]),
        ([("order: 4", "order: 4, filters: {position: 200}")], ["equal filters render better"]),
        ([("form: structured", "form: disc")], ["cannot hold up to ω = ∞"]),
        ([("form: structured", "form: paper")], ["write `form: structured`"]),
        ([stiffness("[0.2, 10]")], ["impedance.stiffness 10 exceeds actuator.spring_stiffness 4.8"]),
        ([stiffness("[0.0001, 4]")], ["impedance.stiffness", "0.00919 Hz"]),
        ([actuator("{type: ideal}"), stiffness("[1e6, 1e7]")], ["impedance.stiffness", "919 Hz"]),
        ([sampling("{rate: 100, delay: 0}")], ["sampling.rate 100 Hz is below 10 times the 11.6 Hz of", "torque_loop"]),
        ([sampling("{rate: 1, delay: 1 ms}")], ["check its unit, Hz or kHz"]),
        (
            [actuator("{type: ideal}"), sampling("{rate: 10, delay: 0}")],
            ["10 times the 1.03 Hz of impedance.stiffness"],
        ),
        ([actuator("{type: ideal}"), sampling("{rate: 15, delay: 0}"), stiffness("[1, 4]")], ["the 1.84 Hz of"]),
        ([sampling("{rate: 1 kHz, delay: 1}")], ["sampling.delay 1 s is 1000 sampling periods", "write ms"]),
        ([sampling("{rate: 1 kHz, delay: 101 ms}")], ["is 101 sampling periods"]),
        ([sampling("{rate: 6283.2, delay: 0}")], ["sampling.rate 6283.2 Hz is 2π·1000", "write 1000 Hz"]),
        ([sampling("{rate: 1571, delay: 0}")], ["2π·250"]),
        ([table("{points: [[0.1, 0.1], [1, 0.5]], beyond: hold}")], ["ends at 1 rad/s, below the 2.01 Hz of", "in Hz"]),
        (
            [sampling("{rate: 1 kHz, delay: 0}"), demand("noise: {gain: 3, above: 3142}")],
            ["above 3142 rad/s lies beyond"],
        ),
        (
            [sampling("{rate: 1 kHz, delay: 0}"), demand("noise: {gain: 3, above: 2 kHz}")],
            ["constraints.noise.above 12566.4 rad/s lies beyond half of sampling.rate, 3141.59 rad/s"],
        ),
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
        list(EVERY_NEW_KEY),
        [spring("218.75"), motor("0.225")],  # the same actuator, both rotary
        [spring("21000"), motor("0.148"), ("{inertia: 0.03", "{inertia: 0.5")],
        [stiffness("[0, 4.8]")],
        [sampling("{rate: 117, delay: 0}")],
        [sampling("{rate: 1 kHz, delay: 100 ms}")],
        *(
            [sampling(f"{{rate: {rate}, delay: 0}}")]
            for rate in ("125", "6280", "500", "1024", "2e3", "4e3", "8000", "1e300")
        ),
        [table("{points: [[1, 0.1]], beyond: hold}")],
        [table("{points: [[1, 0.1], [13, 0.2]], beyond: hold}")],
        [demand("noise: {gain: 3, above: 2 kHz}")],
        [sampling("{rate: 1 kHz, delay: 0}"), demand("noise: {gain: 3, above: 3141}")],
        [actuator("{type: ideal}"), sampling("{rate: 11, delay: 0}")],
    ],
)
def test_no_warning(pairs: Pairs, edit: Edit) -> None:
    assert spec_warnings(parse_spec(edit(*pairs))) == ()
