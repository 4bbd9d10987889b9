"""What a specification may say, and the exact number it then means."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import pytest

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import Spec, load_spec, parse_spec
from robimp.synthesis.spec.model import IdealActuator, SeriesElasticActuator
from robimp.synthesis.spec.units import DEGREES_PER_RADIAN, TWO_PI

Edit = Callable[..., str]
BOX = "{box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}"
WEIGHT = "weight: {numerator: [1.2, 0], denominator: [1, 800]}"
ELASTIC = """{type: series-elastic, motor_inertia: 0.01, motor_damping: 0.05, spring_stiffness: 4.8,
  torque_loop: {kp: 10, kd: 0.25, derivative_corner: 1000, feedforward: 1}}"""


@pytest.fixture(scope="module")
def reference(good: str) -> Spec:
    return parse_spec(good)


def test_the_example_says_what_it_shows() -> None:
    spec = load_spec(Path(__file__).parents[2] / "examples" / "haninger2016.yaml")
    assert spec.plant.inertia == spec.impedance.inertia == Fraction(3, 100)
    assert spec.uncertainty.box is not None
    assert spec.uncertainty.box.inertia == (Fraction(24, 1000), Fraction(36, 1000))
    assert spec.uncertainty.box.damping == (Fraction(12, 100), Fraction(28, 100))
    assert isinstance(spec.actuator, SeriesElasticActuator)
    assert spec.actuator.spring_stiffness == Fraction(48, 10)
    assert (spec.impedance.stiffness, spec.impedance.damping) == (Fraction(5, 4), Fraction(35, 100))
    assert (spec.controller.type, spec.controller.order) == ("dob", 4)
    assert spec.constraints.friction == "report"


@pytest.mark.parametrize(
    "wrap",
    [
        lambda text: text.encode(),
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: "%YAML 1.2\n---\n" + text + "...\n",
        lambda text: "# a comment\n\n" + text,
        lambda text: text.rstrip(),
        lambda text: text.replace("order: 4", "order: 4, form: null, filters: {force: null}"),
    ],
    ids=["bytes", "byte order mark", "CRLF", "document markers", "comment", "no last newline", "null options"],
)
def test_the_same_text_in_another_wrapping_is_the_same_specification(
    wrap: Callable[[str], str | bytes], good: str, reference: Spec
) -> None:
    assert parse_spec(wrap(good)) == reference


@pytest.mark.parametrize(
    "tolerance",
    ["±20 %", "±20%", "± 20 %", "+-20 %", "+/- 20 %", '"±20 %"', "±2e1 %", "[0.024, 0.036]", "[24 g·m², 36 g·m²]"],
)
def test_a_tolerance_in_every_spelling(tolerance: str, edit: Edit, reference: Spec) -> None:
    assert parse_spec(edit(("inertia: ±20 %", f"inertia: {tolerance}"))) == reference


@pytest.mark.parametrize("text", ["0.03", "3e-2", "3E-2", "+0.03", ".03", "3/100", '"0.03"', "0.030", "300e-4"])
def test_a_number_in_every_spelling(text: str, edit: Edit, reference: Spec) -> None:
    assert parse_spec(edit(("inertia: 0.03", f"inertia: {text}"))) == reference


def test_a_number_is_the_decimal_and_not_the_double(edit: Edit) -> None:
    spec = parse_spec(edit(("attenuation: 0.3", "attenuation: 0.1")))
    assert spec.objective.attenuation == Fraction(1, 10) != Fraction(0.1)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("inertia: 0.03", "inertia: 300 g cm^2"),
        ("inertia: 0.03", "inertia: 0.03 kg*m^2"),
        ("inertia: 0.03", "inertia: 300kg·cm²"),
        ("damping: 0.35", "damping: 350 mN·m·s/rad"),
        ("damping: 0.35", "damping: 0.35 Nms"),
        ("spring_stiffness: 4.8", "spring_stiffness: 4800 mN·m/rad"),
        ("spring_stiffness: 4.8", "spring_stiffness: 0.0048 kNm/rad"),
        ("kd: 0.25", "kd: 250 ms"),
        ("kd: 0.25", "kd: 250000 µs"),
        ("derivative_corner: 1000", "derivative_corner: 1000 rad/s"),
        ("attenuation: 0.3", "attenuation: 30 %"),
        ("peak: 2.0", "peak: 200%"),
    ],
)
def test_a_unit_is_its_exact_worth(old: str, new: str, edit: Edit, reference: Spec) -> None:
    spec = parse_spec(edit((old, new)))
    same = {"inertia: 300 g cm^2": Fraction(3, 100_000)}.get(new)  # 300 g·cm² is a thousandth of the reference
    assert (spec.plant.inertia == same and spec != reference) if same else spec == reference


def test_units_follow_the_motion(edit: Edit) -> None:
    spec = parse_spec(
        edit(
            ("motion: rotary", "motion: linear"),
            ("inertia: 0.03", "inertia: 30 g"),
            ("damping: 0.2,", "damping: 0.0002 N·s/mm,"),
            ("spring_stiffness: 4.8", "spring_stiffness: 0.0048 N/mm"),
        )
    )
    assert (spec.plant.inertia, spec.plant.damping) == (Fraction(3, 100), Fraction(1, 5))
    assert isinstance(spec.actuator, SeriesElasticActuator) and spec.actuator.spring_stiffness == Fraction(24, 5)
    with pytest.raises(InputError, match="use one of kg, g"):
        parse_spec(edit(("motion: rotary", "motion: linear"), ("inertia: 0.03", "inertia: 0.03 kg·m²")))


def test_two_irrational_factors_are_stated_decimals(edit: Edit) -> None:
    with localcontext() as context:
        context.prec = 60
        pi = Decimal("3.14159265358979323846264338327950288419716939937510582")
        for stated, ideal in ((TWO_PI, 2 * pi), (DEGREES_PER_RADIAN, 180 / pi)):
            digits = Decimal(stated.numerator) / Decimal(stated.denominator)
            assert len(digits.as_tuple().digits) == 25
            assert 0 < abs(digits - ideal) < Decimal("1e-24") * ideal
    spec = parse_spec(edit(("order: 4", "order: 4, filters: {force: 40 Hz, derivative: 0.04 kHz}")))
    assert spec.controller.filters.force == spec.controller.filters.derivative == 40 * TWO_PI


def test_every_optional_part(edit: Edit) -> None:
    spec = parse_spec(
        edit(
            (ELASTIC, "{type: ideal}"),
            (BOX, BOX.replace("}}", f"}}, {WEIGHT}}}")),
            (
                "order: 4",
                "coefficients: {numerator: [0, 2000], denominator: [1, 70.75, 2500]}, filters: {position: none}",
            ),
            ("attenuation: 0.3", "attenuation: 0.3, rendering_error: 10 %"),
            ("form: structured", "form: structured, band: [0, 100], margin: 0.02"),
            ("peak: 2.0", "peak: 2.0, friction: require"),
        )
    )
    assert spec.actuator == IdealActuator(type="ideal")
    assert spec.uncertainty.weight is not None and spec.uncertainty.box is not None
    assert spec.uncertainty.weight.numerator == (Fraction(6, 5), Fraction(0))
    assert spec.controller.coefficients is not None
    assert spec.controller.coefficients.numerator == (Fraction(2000),)  # the leading zero is dropped
    assert spec.controller.filters.position == "none"
    assert spec.objective.rendering_error == Fraction(1, 10)
    assert spec.constraints.eq12 is not None
    assert (spec.constraints.eq12.band, spec.constraints.eq12.margin) == (
        (Fraction(0), Fraction(100)),
        Fraction(1, 50),
    )
    assert spec.constraints.friction == "require"


@pytest.mark.parametrize(
    "pairs",
    [
        [(BOX, f"{{{WEIGHT}}}")],
        [("order: 4", "order: 2")],
        [("order: 4", "order: 8")],
        [("order: 4", "form: eq23")],
        [("type: dob, order: 4", "type: dynamic-feedback, order: 0")],
        [("type: dob, order: 4", "type: dynamic-feedback, order: 1")],
        [("type: dob, order: 4", "type: dynamic-feedback, coefficients: {numerator: [2.5], denominator: [1]}")],
        [("order: 4", "coefficients: {numerator: [1, 1], denominator: [2, 5]}")],
        [("order: 4", "order: 4, filters: {force: 100, position: 100}")],
        [("form: structured", "form: disc")],
        [("form: structured", "form: paper, band: [1 Hz, 10 Hz]")],
        [("eq9: {}, eq12: {form: structured}, eq18: {form: half-plane, coupling: physical}, peak: 2.0", "")],
        [("eq9: {}", "eq9: null")],
        [("inertia: nominal", "inertia: 0.02")],
        [("name: joint", "name: 2016")],
        [("name: joint", "name: " + "j" * 64)],
        [("kp: 10, kd: 0.25", "kp: 0, kd: 0")],
    ],
    ids=lambda pairs: pairs[0][1][:40],
)
def test_also_accepted(pairs: list[tuple[str, str]], edit: Edit, reference: Spec) -> None:
    assert parse_spec(edit(*pairs)) != reference
