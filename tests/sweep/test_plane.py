"""Axes and cells: which values, which specifications, which neighbour; and what is refused at once."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from robimp.synthesis import InputError, load
from robimp.synthesis.sweep.axis import Axis
from robimp.synthesis.sweep.plane import Plane


def plane(spec: Path, first: str, second: str) -> Plane:
    return Plane.of(spec, (Axis.assignment(first), Axis.assignment(second)))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.5:2:4", ("1/2", "1", "1.5", "2")),
        ("1:2:4", ("1", "1.33333", "1.66667", "2")),
        ("0.01:100:5:log", ("1/100", "0.1", "1", "10", "100")),
        ("2:8:2", ("2", "8")),
    ],
)
def test_an_axis_has_exact_ends_and_short_values_between(text: str, values: tuple[str, ...]) -> None:
    assert Axis.parse("impedance.stiffness", text).values == values


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("impedance.stiffness", "KEY=A:B:N"),
        ("stiffness=1:2:3", "a key such as"),
        ("impedance.stiffness=1:2", "A:B:N"),
        ("impedance.stiffness=1:2:3:cubic", "A:B:N"),
        ("impedance.stiffness=a:2:3", "numbers A and B"),
        ("impedance.stiffness=nan:2:3", "finite"),
        ("impedance.stiffness=1:2:1", "from 2 to"),
        ("impedance.stiffness=1:2:²", "from 2 to"),
        ("impedance.stiffness=1:2:100000", "from 2 to"),
        ("impedance.stiffness=2:1:3", "A < B"),
        ("impedance.stiffness=0:1:3:log", "A > 0"),
    ],
)
def test_an_axis_that_makes_no_sense_is_refused(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Axis.assignment(text)


def test_every_cell_is_the_specification_with_two_keys_replaced(small: Path) -> None:
    found = plane(small, "impedance.stiffness=1:5:3", "impedance.damping=0.2:0.5:2")
    assert len(found) == 6 == len(set(found)) == len(found.specs)
    assert found.specs[2, 1] == load(small)
    cell = found.specs[1, 0].impedance
    assert (cell.stiffness, cell.damping, cell.inertia) == (Fraction(3), Fraction(1, 5), Fraction(1, 20))


def test_shares_of_the_nominal_value_follow_it(small: Path) -> None:
    found = plane(small, "plant.inertia=0.05:0.1:2", "objective.attenuation=0.2:0.5:2").specs[1, 0]
    assert found.uncertainty.box is not None
    assert found.uncertainty.box.inertia == (Fraction("0.09"), Fraction("0.11"))
    assert found.impedance.inertia == Fraction("0.1")


def test_a_specification_without_its_file_will_do(small: Path) -> None:
    axes = (Axis.assignment("impedance.stiffness=1:5:2"), Axis.assignment("impedance.damping=0.2:0.5:2"))
    assert Plane.of(load(small), axes).digest == Plane.of(small, axes).digest


def test_a_key_may_be_new_in_its_section(small: Path) -> None:
    found = plane(small, "constraints.noise.gain=1:2:2", "impedance.damping=0.2:0.5:2")
    with pytest.raises(InputError, match="no section that holds `noise`"):
        _ = found.specs
    found = plane(small, "objective.rendering_error=0.1:0.2:2", "impedance.damping=0.2:0.5:2")
    assert found.specs[1, 0].objective.rendering_error == Fraction("0.2")


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("impedance.stifness=1:2:2", "did you mean `stiffness`"),
        ("impedence.stiffness=1:2:2", "no section that holds `impedence`"),
        ("plant.inertia=-1:1:2", "> 0"),
        ("objective.attenuation=0.5:1.5:3", "below 1"),
        ("uncertainty.box=1:2:2", "this is a section"),
        ("plant.inertia.x=1:2:2", "no section that holds `x`"),
    ],
)
def test_cells_that_are_no_specification_are_refused_by_key(small: Path, key: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as refused:
        _ = plane(small, key, "impedance.damping=0.2:0.5:2").specs
    assert key.partition("=")[0].split(".")[0] in str(refused.value)


def test_two_axes_of_one_key_are_refused(small: Path) -> None:
    with pytest.raises(InputError, match="two different keys"):
        plane(small, "impedance.damping=0.1:0.5:2", "impedance.damping=0.2:0.5:2")


def test_a_neighbour_is_next_to_its_cell_and_every_chain_ends_at_the_first(searched: Path) -> None:
    found = plane(searched, "impedance.stiffness=1:5:4", "impedance.damping=0.2:0.5:3")
    for index in found:
        steps, at = 0, index
        while (parent := found.parent(at)) is not None:
            assert abs(parent[0] - at[0]) + abs(parent[1] - at[1]) == 1
            steps, at = steps + 1, parent
        assert (at, steps) == ((0, 0), sum(index))


def test_given_controllers_need_no_neighbour(small: Path) -> None:
    found = plane(small, "impedance.stiffness=1:5:4", "impedance.damping=0.2:0.5:3")
    assert all(found.parent(index) is None for index in found)
