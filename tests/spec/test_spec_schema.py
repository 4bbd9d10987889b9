"""The JSON Schema knows the same keys, words and ranges as the reader."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from pydantic import BaseModel
from ruamel.yaml import YAML
from spec_texts import (
    EVERY_NEW_KEY,
    TWO_PORT,
    Pair,
    actuator,
    demand,
    inertia,
    loose_actuator,
    sampling,
    stiffness,
    table,
)

from robimp.synthesis.spec import Spec, json_schema
from robimp.synthesis.spec.model import SeriesElasticActuator

SPECS = Path(__file__).parents[1] / "data" / "specs"
Edit = Callable[..., str]
VALIDATOR = jsonschema.Draft202012Validator(json_schema())

# Faults that JSON Schema can see; the others need arithmetic or an order of reading, and are the reader's.
SEEN = (
    "foreign-key", "misspelt-key", "misspelt-section", "missing-key", "missing-section", "no-version", "version-2",
    "null-section", "null-number", "empty-eq9", "eq9-true", "motion-misspelt", "table", "measured", "noise",
    "plant-interval", "number-word", "number-truth-word", "number-list-for-number",
    "inertia-zero", "damping-negative", "spring-zero", "corner-zero", "ideal-with-motor", "uncertainty-none",
    "box-number", "box-no-sign", "box-three", "weight-empty", "weight-degree", "controller-type", "controller-two",
    "controller-none", "order-9", "order-fraction", "filter-none", "maximise-stiffness", "attenuation-1", "peak-1",
    "eq12-no-form", "eq12-form", "eq18-no-coupling", "friction", "name-path",
)  # fmt: skip


def content(text: str) -> Any:
    return YAML(typ="safe", pure=True).load(text)


def test_it_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(json_schema())


@pytest.mark.parametrize("path", [SPECS / "good.yaml", SPECS.parents[2] / "examples" / "haninger2016.yaml"])
def test_good_specifications_validate(path: Path) -> None:
    VALIDATOR.validate(content(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    "pair",
    [
        ("inertia: 0.03", "inertia: 300 g·cm²"),
        ("inertia: 0.03", "inertia: 3/100"),
        ("derivative_corner: 1000", "derivative_corner: 160 Hz"),
        ("order: 4", "order: 4, filters: {force: 100, position: none, derivative: 1 kHz}"),
        ("order: 4", "form: eq23"),
        ("attenuation: 0.3", "attenuation: 30 %"),
        ("name: joint", "name: 2016"),
        *EVERY_NEW_KEY,
        sampling("{rate: 1000, delay: 0}"),
        stiffness("1.25 ±20 %"),
        stiffness('"1.25 N·m/rad +/- 20 %"'),
        stiffness("1.25+-20%"),
        stiffness("[1 N·m/rad, 2]"),
        inertia("±10 %"),
        inertia("0.02"),
        inertia("[0.02, 0.04]"),
        loose_actuator("{spring_stiffness: [4, 5], motor_damping: ±10 %}"),
        table("{file: data/bound.csv, beyond: hold}"),
        actuator(TWO_PORT),
        actuator("{type: ideal}"),
        demand("noise: {gain: 30}"),
        demand("tolerance: 1e-6"),
        demand("tolerance: 0.1 %"),
    ],
)
def test_units_and_options_validate(pair: tuple[str, str], edit: Edit) -> None:
    VALIDATOR.validate(content(edit(pair)))


@pytest.mark.parametrize("name", SEEN)
def test_bad_specifications_do_not(name: str) -> None:
    document = content((SPECS / "bad" / f"{name}.yaml").read_text(encoding="utf-8"))
    assert not VALIDATOR.is_valid(document)


@pytest.mark.parametrize(
    "pair",
    [
        sampling("{rate: 1000}"),
        sampling("{delay: 0}"),
        sampling("{rate: 1000, delay: -0.001}"),
        sampling("{rate: 0, delay: 0}"),
        sampling("{rate: 1000, delay: fast}"),
        sampling("{rate: 1000, delay: 0, period: 1}"),
        sampling("1 kHz"),
        stiffness("[1]"),
        stiffness("[1, 2, 3]"),
        stiffness("[-1, 2]"),
        stiffness("±20 %"),
        stiffness("nominal"),
        stiffness("-1"),
        stiffness("{low: 1, high: 2}"),
        inertia("0"),
        inertia("nominall"),
        inertia("''"),
        inertia("[1, 2, 3]"),
        inertia("about ±20 %"),
        loose_actuator("{}"),
        loose_actuator("{torque_loop: ±5 %}"),
        loose_actuator("{motor_inertia: 0.01}"),
        loose_actuator("{motor_inertia: [1]}"),
        loose_actuator("{motor_damping: [-1, 1]}"),
        ("box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}", "actuator: {motor_inertia: ±10 %}"),
        table("{points: [[1, 1]]}"),
        table("{points: [[1, 1]], beyond: zero}"),
        table("{points: [], beyond: hold}"),
        table("{points: [[1]], beyond: hold}"),
        table("{points: [[1, 2, 3]], beyond: hold}"),
        table("{points: [[-1, 2]], beyond: hold}"),
        table("{points: [[1, -2]], beyond: hold}"),
        table("{points: [" + "[1, 1], " * 1001 + "], beyond: hold}"),
        table("{file: bound.csv}"),
        table("{file: '', beyond: hold}"),
        table("{file: bound.csv, points: [[1, 1]], beyond: hold}"),
        table("{beyond: hold}"),
        actuator("{type: two-port}"),
        actuator(TWO_PORT.replace("two-port", "ideal")),
        actuator(TWO_PORT.replace("two-port", "two-port, kp: 1")),
        actuator(TWO_PORT.replace("[1, 20, 100]", "[]")),
        actuator(TWO_PORT.replace("[100]", "100")),
        demand("noise: {}"),
        demand("noise: {gain: 0}"),
        demand("noise: {gain: 30, above: -1}"),
        demand("noise: {gain: 30, below: 1}"),
        demand("noise: 30"),
        demand("tolerance: 0"),
        demand("tolerance: 1"),
        demand("tolerance: float64"),
        demand("tolerance: [1e-6]"),
        demand("tolerance: {}"),
    ],
    ids=lambda pair: pair[1][-40:],
)
def test_bad_new_keys_do_not(pair: Pair, edit: Edit) -> None:
    assert not VALIDATOR.is_valid(content(edit(pair)))


def keys(schema: dict[str, Any], prefix: str = "") -> set[str]:
    """Dotted keys of the sections of a schema."""
    found: set[str] = set()
    for key, value in schema.get("properties", {}).items():
        found |= {f"{prefix}{key}"} | keys(value, f"{prefix}{key}.")
        found |= keys(value["items"], f"{prefix}{key}.") if isinstance(value.get("items"), dict) else set()
    for choice in schema.get("oneOf", ()):
        found |= keys(choice, prefix)
    return found


def fields(model: type[BaseModel], prefix: str = "") -> set[str]:
    """Dotted fields of a model and of the models inside it."""
    found: set[str] = set()
    for name, field in model.model_fields.items():
        found.add(f"{prefix}{name}")
        for kind in getattr(field.annotation, "__args__", (field.annotation,)):
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                found |= fields(kind, f"{prefix}{name}.")
    return found


def test_the_schema_has_the_keys_of_the_model() -> None:
    files = {"table.file", "measured", *(f"measured.{key}" for key in ("files", "amplitude", "exclude", "beyond"))}
    become_points = {f"uncertainty.{key}" for key in files}
    assert keys(json_schema()) == fields(Spec) | become_points
    assert "actuator.torque_loop.kd" in fields(Spec)
    assert keys(json_schema()) != fields(SeriesElasticActuator)


def test_every_key_is_described() -> None:
    def described(schema: dict[str, Any]) -> bool:
        return all(
            "const" in value or (value.get("description") and described(value))
            for part in (schema, *schema.get("oneOf", ()))
            for value in part.get("properties", {}).values()
        )

    schema = json_schema()
    assert described(schema)
    del schema["properties"]["constraints"]["properties"]["peak"]["description"]
    assert not described(schema)
