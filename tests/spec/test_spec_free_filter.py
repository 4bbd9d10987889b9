"""`filters: {force: free}`: what may be free, what is said of the rest, and what a certificate's corner stands for."""

from __future__ import annotations

import copy
from collections.abc import Callable
from fractions import Fraction
from io import StringIO
from typing import Any

import jsonschema
import pytest
from ruamel.yaml import YAML

from robimp.synthesis.errors import InputError
from robimp.synthesis.report.difference import differences
from robimp.synthesis.spec import canonical, from_canonical, json_schema, parse_spec, spec_sha256, spec_warnings
from robimp.synthesis.spec.free_corner import as_certified, resolved
from robimp.synthesis.spec.model import FREE

Edit = Callable[..., str]
Json = dict[str, Any]
VALIDATOR = jsonschema.Draft202012Validator(json_schema())


def with_filters(edit: Edit, filters: str, controller: str = "order: 4") -> str:
    return edit(("order: 4", f"{controller}, filters: {filters}"))


@pytest.mark.parametrize("written", ["free", '"free"'])
def test_a_force_filter_may_be_free(edit: Edit, written: str) -> None:
    spec = parse_spec(with_filters(edit, f"{{force: {written}, derivative: 900}}"))
    assert (spec.controller.filters.force, spec.controller.filters.derivative) == (FREE, 900)
    assert spec_warnings(spec) == ()
    assert from_canonical(canonical(spec)) == spec, "a map's journal carries it"
    VALIDATOR.validate(YAML(typ="safe", pure=True).load(StringIO(with_filters(edit, "{force: free}"))))


GIVEN = "coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}"
REFUSED = {
    '{force: "free "}': ("force", "expected an angular frequency > 0, or free; found 'free '; write free"),
    "{force: FREE}": ("force", "expected an angular frequency > 0, or free; found 'FREE'; write free"),
    "{force: 0}": ("force", "expected an angular frequency > 0; found '0'"),
    "{force: -3}": ("force", "expected an angular frequency > 0; found '-3'"),
    "{force: fre}": ("force", "expected an angular frequency; found 'fre'"),
    "{force: none}": ("force", "expected an angular frequency; found 'none'"),
    "{force: [free]}": ("force", "expected an angular frequency; found a list"),
    "{position: free}": ("position", "leave `position` out: θ then has the filter of τ_int"),
    "{derivative: free}": ("derivative", "give the one the drive differentiates with"),
    "{force: free, position: none}": ("position", "leave `position` out, or give both corners"),
    "{force: free, position: 100}": ("position", "leave `position` out, or give both corners"),
}


@pytest.mark.parametrize("filters", REFUSED)
def test_what_cannot_be_free_is_refused_at_its_place(edit: Edit, filters: str) -> None:
    key, remedy = REFUSED[filters]
    with pytest.raises(InputError) as refusal:
        parse_spec(with_filters(edit, filters))
    where = refusal.value.location
    assert where is not None and where.key == f"controller.filters.{key}" and where.line is not None
    assert remedy in refusal.value.message


def test_nothing_is_free_where_nothing_is_searched(edit: Edit) -> None:
    with pytest.raises(InputError, match="give the corner they were made for") as refusal:
        parse_spec(with_filters(edit, "{force: free}", GIVEN))
    assert refusal.value.location is not None and refusal.value.location.key == "controller.filters.force"
    assert parse_spec(with_filters(edit, "{force: 100}", GIVEN)).controller.filters.force == 100


@pytest.mark.parametrize("value", ["FREE", "Free", "none", 0, -1, ["free"]])
def test_the_schema_refuses_it_too(edit: Edit, value: object) -> None:
    document = YAML(typ="safe", pure=True).load(StringIO(with_filters(edit, "{force: free}")))
    document["controller"]["filters"]["force"] = value
    assert not VALIDATOR.is_valid(document)


# The corner that was found


def test_a_found_corner_resolves_the_specification(edit: Edit) -> None:
    free, given = (parse_spec(with_filters(edit, f"{{force: {f}}}")) for f in ("free", "183.2"))
    assert resolved(free, Fraction("183.2")) == given != free
    assert resolved(given, None) is given, "nothing was free"
    assert resolved(given, Fraction(7)) is given, "a given corner stays"
    with pytest.raises(InputError, match=r"controller\.filters\.force"):
        resolved(free, None)
    assert spec_sha256(free) != spec_sha256(given)
    with pytest.raises(ValueError, match="only a search gives it a corner"):
        _ = free.controller.filters.force_corner


def compared(certified: Json, asked: Json) -> list[str]:
    return list(differences(certified, as_certified(asked, certified), "specification"))


def test_a_certificates_corner_stands_for_a_free_one_and_for_nothing_else(edit: Edit) -> None:
    free, found, other = (canonical(parse_spec(with_filters(edit, f"{{force: {f}}}"))) for f in ("free", "183.2", "50"))
    assert compared(found, free) == [] == compared(other, free)
    assert compared(other, found) == ["controller.filters.force 50 → 183.2"], "a given corner has to be that one"
    assert free["controller"]["filters"]["force"] == FREE, "what was asked is not changed"  # type: ignore[index]
    changed: Json = copy.deepcopy(found)
    changed["plant"]["inertia"], changed["controller"]["filters"]["derivative"] = "1/20", "900"
    assert [line.split(" ")[0].rstrip(":") for line in compared(changed, free)] == [
        "plant.inertia",
        "controller.filters.derivative",
    ]


@pytest.mark.parametrize("corner", [None, "free", "0", "-5", "", "1/0", "0x10", 100, ["100"]])
def test_only_a_positive_number_takes_the_place_of_free(edit: Edit, corner: object) -> None:
    free = canonical(parse_spec(with_filters(edit, "{force: free}")))
    certified: Json = copy.deepcopy(free)
    certified["controller"]["filters"]["force"] = corner
    assert as_certified(free, certified) is free
    if corner != FREE:
        assert compared(certified, free)[0].startswith("controller.filters.force")


def test_a_certificate_without_filters_is_of_another_specification(edit: Edit) -> None:
    free = canonical(parse_spec(with_filters(edit, "{force: free}")))
    certified: Json = copy.deepcopy(free)
    certified["controller"]["filters"] = None
    assert any("controller.filters" in line for line in compared(certified, free))
