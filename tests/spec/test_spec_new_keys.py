"""Sampling, ranges, actuator boxes, tables, two-ports, noise, tolerance: what may be said, and what it means."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import get_type_hints

import pytest
from spec_texts import TWO_PORT, Pair, actuator, demand, inertia, loose_actuator, sampling, stiffness, table

from robimp.synthesis.spec import parse_spec
from robimp.synthesis.spec.model import (
    ActuatorBox,
    Impedance,
    Interval,
    Noise,
    Polynomials,
    Sampling,
    Table,
    TwoPortActuator,
)
from robimp.synthesis.spec.units import TWO_PI

Edit = Callable[..., str]
BOX = "box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}"


def test_what_is_not_said_is_none(good: str) -> None:
    spec = parse_spec(good)
    assert spec.sampling is spec.uncertainty.actuator is spec.uncertainty.table is None
    assert spec.constraints.noise is spec.constraints.tolerance is None
    assert parse_spec(good + "sampling: null\n") == spec


@pytest.mark.parametrize(
    ("text", "rate", "delay"),
    [
        ("{rate: 1 kHz, delay: 1 ms}", Fraction(1000), Fraction(1, 1000)),
        ("{rate: 1000, delay: 0.001}", Fraction(1000), Fraction(1, 1000)),
        ("{rate: 2500 Hz, delay: 0}", Fraction(2500), Fraction(0)),
        ("{rate: 1000/3, delay: 150 us}", Fraction(1000, 3), Fraction(3, 20000)),
        ("{delay: 0 s, rate: 0.5 kHz}", Fraction(500), Fraction(0)),
    ],
)
def test_sampling(text: str, rate: Fraction, delay: Fraction, edit: Edit) -> None:
    assert parse_spec(edit(sampling(text))).sampling == Sampling(rate=rate, delay=delay)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("[0.2, 10]", (Fraction(1, 5), Fraction(10))),
        ("[200 mN·m/rad, 0.01 kN·m/rad]", (Fraction(1, 5), Fraction(10))),
        ("1.25 ±20 %", (Fraction(1), Fraction(3, 2))),
        ("1.25 N·m/rad ±20 %", (Fraction(1), Fraction(3, 2))),
        ("1.25+-20%", (Fraction(1), Fraction(3, 2))),
        ('"5/4 +/- 20 %"', (Fraction(1), Fraction(3, 2))),
        ("1.25 ±100 %", (Fraction(0), Fraction(5, 2))),
        ("[0, 1]", (Fraction(0), Fraction(1))),
        ("[3, 3]", Fraction(3)),
        ("[0, 0]", Fraction(0)),
        ("3 ±0 %", Fraction(3)),
        ("3", Fraction(3)),
    ],
)
def test_a_range_of_impedances(text: str, value: Fraction | Interval, edit: Edit) -> None:
    assert parse_spec(edit(stiffness(text))).impedance.stiffness == value
    damping = text.replace("mN·m/rad", "mN·m·s/rad").replace("kN·m/rad", "kN·m/rad")
    if "N·m" not in damping:
        assert parse_spec(edit(("damping: 0.35", f"damping: {damping}"))).impedance.damping == value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("nominal", Fraction(3, 100)),
        ("nominal ±0 %", Fraction(3, 100)),
        ("nominal ±10 %", (Fraction(27, 1000), Fraction(33, 1000))),
        ("±10 %", (Fraction(27, 1000), Fraction(33, 1000))),
        ("0.02 ±10 %", (Fraction(18, 1000), Fraction(22, 1000))),
        ("[20 g·m², 0.05]", (Fraction(2, 100), Fraction(5, 100))),  # the nominal one need not lie inside
    ],
)
def test_a_range_of_inertias(text: str, value: Fraction | Interval, edit: Edit) -> None:
    assert parse_spec(edit(inertia(text))).impedance.inertia == value


@pytest.mark.parametrize(
    ("text", "box"),
    [
        ("{motor_inertia: ±10 %}", ActuatorBox(motor_inertia=(Fraction(9, 1000), Fraction(11, 1000)))),
        ("{motor_damping: [0, 0.1]}", ActuatorBox(motor_damping=(Fraction(0), Fraction(1, 10)))),
        ("{spring_stiffness: [4.8, 4.8]}", ActuatorBox(spring_stiffness=(Fraction(24, 5), Fraction(24, 5)))),
        (
            "{motor_inertia: [5 g·m², 0.01], motor_damping: ±100 %, spring_stiffness: ±5%}",
            ActuatorBox(
                motor_inertia=(Fraction(5, 1000), Fraction(1, 100)),
                motor_damping=(Fraction(0), Fraction(1, 10)),
                spring_stiffness=(Fraction(456, 100), Fraction(504, 100)),
            ),
        ),
        (
            "{motor_inertia: ±10 %, motor_damping: null}",
            ActuatorBox(motor_inertia=(Fraction(9, 1000), Fraction(11, 1000))),
        ),
    ],
)
def test_a_box_of_actuators(text: str, box: ActuatorBox, edit: Edit) -> None:
    assert parse_spec(edit(loose_actuator(text))).uncertainty.actuator == box


@pytest.mark.parametrize(
    ("text", "points"),
    [
        ("[[10, 0.1]]", ((Fraction(10), Fraction(1, 10)),)),
        (
            "[[0, 0], [1 Hz, 20 %], [100 rad/s, 1/3]]",
            ((Fraction(0), Fraction(0)), (TWO_PI, Fraction(1, 5)), (Fraction(100), Fraction(1, 3))),
        ),
        ("[[1, 5], [2, 5]]", ((Fraction(1), Fraction(5)), (Fraction(2), Fraction(5)))),
        (
            "[" + ", ".join(f"[{k}, 1]" for k in range(1000)) + "]",
            tuple((Fraction(k), Fraction(1)) for k in range(1000)),
        ),
    ],
    ids=["one", "units", "above 1", "1000"],
)
def test_a_table_of_points(text: str, points: tuple[tuple[Fraction, Fraction], ...], edit: Edit) -> None:
    spec = parse_spec(edit(table(f"{{points: {text}, beyond: hold}}")))
    assert spec.uncertainty.table == Table(points=points, beyond="hold")


def test_a_table_alone_and_with_a_weight(edit: Edit) -> None:
    points = "table: {points: [[10, 0.1]], beyond: hold}"
    alone = parse_spec(edit((BOX, points))).uncertainty
    assert alone.box is None and alone.table is not None
    weight = "weight: {numerator: [1.2, 0], denominator: [1, 800]}"
    for form in ("paper", "disc", "structured"):
        both = parse_spec(edit((BOX, f"{weight}, {points}"), ("form: structured", f"form: {form}"))).uncertainty
        assert both.weight is not None and both.table is not None


def test_a_two_port(edit: Edit) -> None:
    transfer = Polynomials(numerator=(Fraction(100),), denominator=(Fraction(1), Fraction(20), Fraction(100)))
    proper = TWO_PORT.replace("[1/100, 1]", "[1/100, 1, 0]")
    port = Polynomials(
        numerator=(Fraction(1, 100), Fraction(1, 20), Fraction(0)),
        denominator=(Fraction(1, 100), Fraction(1), Fraction(0)),
    )
    expected = TwoPortActuator(type="two-port", transfer=transfer, impedance=port)
    assert parse_spec(edit(actuator(proper))).actuator == expected
    rigid = proper.replace("[0.01, 0.05, 0]", "[0, 0]")
    found = parse_spec(edit(actuator(rigid))).actuator
    assert isinstance(found, TwoPortActuator) and found.impedance.numerator == (Fraction(0),)


def test_what_another_actuator_has_may_be_null(good: str, edit: Edit) -> None:
    assert parse_spec(edit(("type: series-elastic,", "type: series-elastic, transfer: null,"))) == parse_spec(good)
    assert parse_spec(edit(actuator("{type: ideal, impedance: null, motor_inertia: null}"))).actuator.type == "ideal"


@pytest.mark.parametrize(
    ("text", "noise"),
    [
        ("{gain: 30, above: 200 rad/s}", Noise(gain=Fraction(30), above=Fraction(200))),
        ("{gain: 30}", Noise(gain=Fraction(30), above=Fraction(0))),
        ("{gain: 150 %, above: 10 Hz}", Noise(gain=Fraction(3, 2), above=10 * TWO_PI)),
        ("{gain: 1/3, above: 0}", Noise(gain=Fraction(1, 3), above=Fraction(0))),
        ("{gain: 1, above: null}", Noise(gain=Fraction(1), above=Fraction(0))),
    ],
)
def test_noise(text: str, noise: Noise, edit: Edit) -> None:
    assert parse_spec(edit(demand(f"noise: {text}"))).constraints.noise == noise


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("float32", Fraction(1, 16777216)),
        ("1e-6", Fraction(1, 10**6)),
        ("0.1 %", Fraction(1, 1000)),
        ("1/3", Fraction(1, 3)),
        ("0.5", Fraction(1, 2)),
    ],
)
def test_tolerance(text: str, value: Fraction, edit: Edit) -> None:
    assert parse_spec(edit(demand(f"tolerance: {text}"))).constraints.tolerance == value


def test_motion_decides_the_units_here_too(edit: Edit) -> None:
    linear: list[Pair] = [("motion: rotary", "motion: linear"), stiffness("[1 N/m, 0.001 N/mm]")]
    assert parse_spec(edit(*linear)).impedance.stiffness == 1
    box = parse_spec(edit(linear[0], loose_actuator("{motor_inertia: [5 g, 20 g]}"))).uncertainty.actuator
    assert box is not None and box.motor_inertia == (Fraction(1, 200), Fraction(1, 50))


def test_an_impedance_is_a_number_or_an_interval() -> None:
    assert get_type_hints(Impedance)["stiffness"] == Fraction | Interval
