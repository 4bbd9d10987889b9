"""Every fault in the keys for sampling, ranges, tables, actuators, noise and tolerance: line, key, remedy."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from spec_texts import TWO_PORT, Pair, actuator, demand, inertia, loose_actuator, sampling, stiffness, table

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import parse_spec

Edit = Callable[..., str]
Case = tuple[Pair, int, str, str]
BOX = "box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}"


def points(text: str) -> Pair:
    return table(f"{{points: {text}, beyond: hold}}")


SAMPLING: list[Case] = [
    (sampling(text), 12, f"sampling{key}", fragment)
    for text, key, fragment in [
        ("{rate: 1 kHz, delay: -1 ms}", ".delay", "expected a time ≥ 0; found '-1 ms'"),
        ("{rate: 0, delay: 0}", ".rate", "expected a sampling rate > 0"),
        ("{rate: -1 kHz, delay: 0}", ".rate", "expected a sampling rate > 0; found '-1 kHz'"),
        ("{rate: 1 kHz}", ".delay", "it is missing, and it has no default"),
        ("{delay: 1 ms}", ".rate", "it is missing"),
        ("{rate: 6283 rad/s, delay: 0}", ".rate", "'rad/s' is not a unit of a sampling rate here: use one of Hz, kHz"),
        ("{rate: 1 ms, delay: 0}", ".rate", "'ms' is not a unit of a sampling rate"),
        ("{rate: 1 kHz, delay: 1 Hz}", ".delay", "use one of s, ms, us"),
        ("{rate: 1 kHz, delay: 1 min}", ".delay", "use one of s, ms, us"),
        ("{rate: nan, delay: 0}", ".rate", "must be finite"),
        ("{rate: inf, delay: 0}", ".rate", "must be finite"),
        ("{rate: 1 kHz, delay: 1e400}", ".delay", "exponent must lie between"),
        ("{rate: [1, 2], delay: 0}", ".rate", "found a list; write one number"),
        ("{rate: 1 kHz, delay: null}", ".delay", "null is not a number"),
        ("{rate: 1 kHz, delay: 0, period: 1 ms}", ".period", "expected one of rate, delay"),
        ("{rate: 1 kHz, dealy: 0}", ".dealy", "did you mean `delay`?"),
        ("1 kHz", "", "expected a section; found '1 kHz'; give it the keys rate, delay"),
        ("", "", "expected a section; found nothing"),
    ]
]
RANGES: list[Case] = [
    (pair, 8, f"impedance.{key}", fragment)
    for pair, key, fragment in [
        (stiffness("[10, 0.2]"), "stiffness", "expected low ≤ high; found [10, 0.2]; swap them"),
        (stiffness("[1]"), "stiffness", "expected a list [low, high]; found a list of 1"),
        (stiffness("[1, 2, 3]"), "stiffness", "found a list of 3"),
        (stiffness("[-1, 2]"), "stiffness", "expected a stiffness ≥ 0; found -1 at its low end"),
        (stiffness("[1 N/mm, 2]"), "stiffness[0]", "'N/mm' is not a unit of a stiffness here"),
        (stiffness("[1, inf]"), "stiffness[1]", "must be finite"),
        (stiffness("[[1], 2]"), "stiffness[0]", "found a list; write one number"),
        (stiffness("±20 %"), "stiffness", "say of what: write the value before it, such as 1.25 ±20 %"),
        (stiffness("1.25 ±-20 %"), "stiffness", "leave the sign out"),
        (stiffness("1.25 ±120 %"), "stiffness", "expected a stiffness ≥ 0; found -0.25 at its low end"),
        (stiffness("1.25 ±x %"), "stiffness", "write a number such as"),
        (stiffness("1.25 ± %"), "stiffness", "it is empty"),
        (stiffness("1.25 ±20"), "stiffness", "write a percent sign behind it, such as 1.25 ±20 %"),
        (stiffness("0 ±20 %"), "stiffness", "any share of the nominal value 0 is 0"),
        (stiffness("-1 ±20 %"), "stiffness", "expected a stiffness ≥ 0"),
        (stiffness("nominal ±20 %"), "stiffness", "only the inertia can stay the load's own: write a number"),
        (stiffness("{low: 1, high: 2}"), "stiffness", "found a section; write one number"),
        (stiffness("-1"), "stiffness", "expected a stiffness ≥ 0; found '-1'"),
        (inertia("[0, 1]"), "inertia", "expected an inertia > 0; found 0 at its low end"),
        (inertia("±100 %"), "inertia", "expected an inertia > 0; found 0 at its low end"),
        (inertia("[nominal, 1]"), "inertia[0]", "expected an inertia; found 'nominal'"),
        (inertia("nominall"), "inertia", "found 'nominall'"),
        (inertia("0"), "inertia", "expected an inertia > 0; found '0'"),
    ]
]
ACTUATOR_BOX: list[Case] = [
    (loose_actuator(text), 5, f"uncertainty.actuator{key}", fragment)
    for text, key, fragment in [
        ("{}", "", "expected one of motor_inertia, motor_damping, spring_stiffness, or several; found none"),
        ("±10 %", "", "expected a section; found '±10 %'; give it some of the keys motor_inertia"),
        ("{motor_inertia: [0.02, 0.03]}", ".motor_inertia", "holds the nominal value 0.01; found [0.02, 0.03]"),
        ("{spring_stiffness: [5, 4]}", ".spring_stiffness", "expected low ≤ high; found [5, 4]"),
        ("{motor_inertia: [0, 1]}", ".motor_inertia", "every motor_inertia is > 0; found 0 at its low end"),
        ("{spring_stiffness: ±100 %}", ".spring_stiffness", "every spring_stiffness is > 0"),
        ("{motor_damping: [-1, 1]}", ".motor_damping", "every motor_damping is ≥ 0; found -1"),
        ("{motor_damping: 0.05}", ".motor_damping", 'expected "±20 %" or [low, high]; found'),
        ("{motor_damping: 0.05 ±20 %}", ".motor_damping", 'expected "±20 %" or [low, high]; found'),
        ("{motor_inertia: [5 kg, 6]}", ".motor_inertia[0]", "'kg' is not a unit of an inertia here"),
        ("{torque_loop: ±5 %}", ".torque_loop", "unknown key; expected one of motor_inertia"),
        ("{spring_stifness: ±5 %}", ".spring_stifness", "did you mean `spring_stiffness`?"),
    ]
]
TABLE: list[Case] = [
    (pair, 5, f"uncertainty.table{key}", fragment)
    for pair, key, fragment in [
        (
            table("{points: [[1, 2]]}"),
            ".beyond",
            "write `beyond: hold` to say that the first bound holds down to ω = 0",
        ),
        (table("{points: [[1, 2]], beyond: null}"), ".beyond", "write `beyond: hold`"),
        (table("{points: [[1, 2]], beyond: zero}"), ".beyond", "expected hold; found 'zero'"),
        (table("{points: [[1, 2]], beyond: hodl}"), ".beyond", "did you mean `hold`?"),
        (table("{beyond: hold}"), "", "expected exactly one of file, points; found none"),
        (table("{file: a.csv, points: [[1, 2]], beyond: hold}"), "", "found file and points"),
        (table("bound.csv"), "", "expected a section; found 'bound.csv'"),
        (table("{file: bound.csv, beyond: hold}"), ".file", "write `table:` with `points:`"),
        (table("{points: [[1, 2]], beyond: hold, interpolation: log}"), ".interpolation", "unknown key"),
        (points("[]"), ".points", "expected at least one point"),
        (points("5"), ".points", "expected a list of points, [[10, 0.1], [100, 0.5]]; found '5'"),
        (points("[10, 0.1]"), ".points[0]", "expected a point [frequency, bound]; found '10'"),
        (points("[[1, 2, 3]]"), ".points[0]", "expected a point [frequency, bound]; found a list of 3"),
        (points("[[1, 1], [3, 1], [2, 1]]"), ".points[2]", "increase; found 2 after 3 rad/s; sort the rows"),
        (points("[[1, 1], [1.0, 2]]"), ".points[1]", "each frequency once; found 1 after 1 rad/s; keep the larger"),
        (points("[[-1, 1]]"), ".points[0]", "expected a frequency ≥ 0; found -1"),
        (points("[[1, -0.1]]"), ".points[0]", "expected a bound ≥ 0; found -0.1"),
        (points("[[1, nan]]"), ".points[0][1]", "must be finite"),
        (points("[[x, 1]]"), ".points[0][0]", "expected an angular frequency; found 'x'"),
        (points("[[1 rpm, 1]]"), ".points[0][0]", "use one of rad/s, Hz, kHz"),
        (points("[[1, -20 dB]]"), ".points[0][1]", "write 0.1 (= 10^(-20/20))"),
        (
            points("[" + ", ".join(f"[{k}, 1]" for k in range(1001)) + "]"),
            ".points[1000]",
            "most 1000",
        ),
    ]
]
TWO: list[Case] = [
    (actuator(TWO_PORT.replace(old, new, 1)), line, f"actuator{key}", fragment)
    for old, new, line, key, fragment in [
        ("[1/100, 1]", "[1/100, 1, 0], x: 1", 7, ".impedance.x", "unknown key"),
        ("[1/100, 1]", "[1/100, 1]", 7, ".impedance.numerator", "expected a proper rational function"),
        ("[100],", "[1, 0, 0, 0],", 6, ".transfer.numerator", "expected a proper rational function"),
        ("[100],", "[0],", 6, ".transfer.numerator", "every coefficient is zero"),
        ("[1, 20, 100]", "[0, 0]", 6, ".transfer.denominator", "every coefficient is zero"),
        ("[1, 20, 100]", "[0, 1]", 6, ".transfer.denominator", "non-zero leading coefficient"),
        ("[1/100, 1]", "[1" + ", 1" * 61 + "]", 7, ".impedance.denominator", "a degree of at most 60; found 61"),
        ("[1, 20, 100]", "[1, 20 Hz, 100]", 6, ".transfer.denominator[1]", "write a bare number"),
        ("[1/100, 1]", "[1/100, x]", 7, ".impedance.denominator[1]", "found 'x'"),
        ("transfer: {numerator: [100], denominator: [1, 20, 100]},", "", 6, ".transfer", "it is missing"),
        ("two-port,", "two-prot,", 6, ".type", "did you mean `two-port`?"),
        ("two-port,", "two-port, motor_inertia: 1,", 6, ".motor_inertia", "a two-port actuator has no motor_inertia"),
        ("two-port,", "series-elastic,", 6, ".transfer", "a series-elastic actuator has no transfer; remove it"),
        ("two-port,", "ideal,", 6, ".transfer", "an ideal actuator has no transfer; remove it"),
    ]
]
DEMANDS: list[Case] = [
    (demand(text), 11, f"constraints.{key}", fragment)
    for text, key, fragment in [
        ("noise: {}", "noise.gain", "it is missing"),
        ("noise: 30", "noise", "expected a section; found '30'"),
        ("noise: {gain: 0}", "noise.gain", "expected a ratio > 0"),
        ("noise: {gain: -3}", "noise.gain", "expected a ratio > 0"),
        ("noise: {gain: 30 dB}", "noise.gain", "write 31.62 (= 10^(30/20))"),
        ("noise: {gain: 30, above: -1}", "noise.above", "expected an angular frequency ≥ 0"),
        ("noise: {gain: 30, above: 1 rpm}", "noise.above", "use one of rad/s, Hz, kHz"),
        ("noise: {gain: 30, below: 1}", "noise.below", "unknown key; expected one of gain, above"),
        ("noise: {gain: [1, 2]}", "noise.gain", "found a list; write one number"),
        ("noise: {gain: inf}", "noise.gain", "must be finite"),
        ("tolerance: 0", "tolerance", "expected a ratio > 0; found '0'"),
        ("tolerance: -1e-6", "tolerance", "expected a ratio > 0"),
        ("tolerance: 1", "tolerance", "expected a tolerance below 1"),
        ("tolerance: float64", "tolerance", "expected float32; found 'float64'"),
        ("tolerance: ±1 %", "tolerance", "found '±1 %'"),
        ("tolerance: 1e-400", "tolerance", "exponent must lie between"),
        ("tolerance: [1e-6]", "tolerance", "found a list; write one number"),
        ("tolerance: {float32: 1}", "tolerance", "found a section; write one number"),
        ("tolerance: ", "tolerance", "found nothing"),
    ]
]
CASES = [*SAMPLING, *RANGES, *ACTUATOR_BOX, *TABLE, *TWO, *DEMANDS]


@pytest.mark.parametrize(("pair", "line", "key", "fragment"), CASES, ids=[f"{c[2]}: {c[3][:50]}" for c in CASES])
def test_a_fault_is_one_line_at_its_place(pair: Pair, line: int, key: str, fragment: str, edit: Edit) -> None:
    with pytest.raises(InputError) as refusal:
        parse_spec(edit(pair))
    error = refusal.value
    assert error.location is not None and error.location.column is not None
    assert (error.location.line, error.location.key) == (line, key)
    assert fragment in error.message
    assert "\n" not in str(error) and str(error).isprintable()
    assert not any(word in str(error) for word in ("Traceback", "pydantic", "validation error", "Error"))


@pytest.mark.parametrize(
    ("other", "kind"), [("{type: ideal}", "ideal"), (TWO_PORT.replace("[1/100, 1]", "[1, 1, 1]"), "two-port")]
)
def test_a_box_of_actuators_needs_a_series_elastic_one(other: str, kind: str, edit: Edit) -> None:
    with pytest.raises(InputError, match=f"only a series-elastic actuator has .* this one is {kind}; remove the box"):
        parse_spec(edit(loose_actuator("{motor_inertia: ±10 %}"), actuator(other)))


def test_a_box_of_actuators_says_nothing_of_the_load(edit: Edit) -> None:
    with pytest.raises(InputError, match="a load known exactly has a box"):
        parse_spec(edit((BOX, "actuator: {motor_inertia: ±10 %}")))


@pytest.mark.parametrize("form", ["paper", "disc"])
def test_a_disc_form_takes_a_box_or_a_table(form: str, edit: Edit) -> None:
    with pytest.raises(InputError, match=f"the form {form} takes a box or a table, not both; write structured"):
        parse_spec(edit(points("[[1, 0.1]]"), ("form: structured", f"form: {form}")))


def test_of_a_faulty_actuator_and_its_box_the_actuator_is_told(edit: Edit) -> None:
    with pytest.raises(InputError, match=r"actuator\.motor_inertia: expected an inertia > 0"):
        parse_spec(edit(loose_actuator("{motor_inertia: ±10 %}"), ("motor_inertia: 0.01", "motor_inertia: 0")))
