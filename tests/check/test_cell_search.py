"""The search on cells: in which order it looks, what it halves, where it stops, and what one look says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import pairwise, product
from math import inf
from time import monotonic
from typing import Any

import pytest

from robimp.synthesis.check.enclosure import search
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import UnresolvedError
from robimp.synthesis.check.enclosure.search import cover
from robimp.synthesis.check.outcome import UNDECIDED, CheckError
from robimp.synthesis.check.positivity import Inequality

Key = tuple[str, Any]
Box = dict[Key, tuple[Fraction, Fraction]]
Said = tuple[int, list[int]]
A, B, C = ("impedance", "a"), ("impedance", "b"), ("actuator", "c")


def cell(lo: int | str, hi: int | str, far: bool = False) -> Cell:
    return Cell(Fraction(lo), Fraction(hi), far, {})


def box(*keys: Key) -> Box:
    return {key: (Fraction(0), Fraction(1)) for key in keys}


def nothing(_: Cell, __: dict[Key, Fraction]) -> list[Any]:
    return []


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[Cell, Box, int], Said]], list[tuple[Cell, Box]]]:
    """Lets a function of the cell, the box and the number of looks before take the place of one look; lists them."""

    def put(say: Callable[[Cell, Box, int], Said]) -> list[tuple[Cell, Box]]:
        seen: list[tuple[Cell, Box]] = []

        def look(cell: Cell, box: Box, *_: Any) -> Said:
            seen.append((cell, box))
            return say(cell, box, len(seen) - 1)

        monkeypatch.setattr(search, "_look", look)
        return seen

    return put


def later() -> float:
    return monotonic() + 60


def test_every_cell_is_looked_at_once_in_the_order_of_frequency(looks: Any) -> None:
    cells = [cell(0, 1), cell(1, 2), cell(2, 4), cell(0, "1/4", far=True)]
    seen = looks(lambda *_: (1, []))
    assert cover(cells, nothing, later(), {A: (Fraction(2), Fraction(3))}) == ""
    assert [c for c, _ in seen] == cells
    assert all(around == {A: (2, 3)} for _, around in seen)
    assert cover([], nothing, later()) == ""


def test_a_look_is_asked_for_the_parts_the_degree_and_the_time_given(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def look(*given: Any) -> Said:
        asked.append(given[1:])
        return 1, []

    monkeypatch.setattr(search, "_look", look)
    deadline = later()
    cover([cell(1, 2)], nothing, deadline)
    cover([cell(1, 2)], nothing, deadline, box(A), 4)
    assert asked == [({}, nothing, 2, deadline), (box(A), nothing, 4, deadline)]


def test_the_first_cell_that_fails_is_named_and_none_is_looked_at_after_it(looks: Any) -> None:
    seen = looks(lambda c, *_: (-1, []) if c.lo == 4 else (1, []))
    assert cover([cell(1, 4), cell(4, 9), cell(9, 16)], nothing, later()) == " at ω = 2 rad/s"
    assert len(seen) == 2
    looks(lambda *_: (-1, []))
    assert cover([cell(0, 1, far=True)], nothing, later()) == " at ω = inf"


def test_an_undecided_cell_is_halved_at_once_the_lower_half_first(looks: Any) -> None:
    seen = looks(lambda c, *_: (int(c.hi - c.lo <= 1), []))
    assert cover([cell(1, 3), cell(3, 7)], nothing, later()) == ""
    order = [(1, 3), (1, 2), (2, 3), (3, 7), (3, 5), (3, 4), (4, 5), (5, 7), (5, 6), (6, 7)]
    assert [(c.lo, c.hi) for c, _ in seen] == order


def test_the_cell_at_infinity_is_halved_into_one_that_ends_and_one_that_does_not(looks: Any) -> None:
    seen = looks(lambda _, __, k: (int(k > 0), []))
    assert cover([cell(0, "1/4", far=True)], nothing, later()) == ""
    assert [(c.lo, c.hi, c.far) for c, _ in seen] == [
        (0, Fraction(1, 4), True),
        (4, 16, False),
        (0, Fraction(1, 16), True),
    ]


@pytest.mark.parametrize(("axes", "key"), [([0], A), ([1], B), ([2], C), ([2, 0], C)])
def test_the_parameter_that_matters_is_halved_the_lower_half_first(looks: Any, axes: list[int], key: Key) -> None:
    around = {A: (Fraction(0), Fraction(1)), B: (Fraction(-3), Fraction(5)), C: (Fraction(2), Fraction(6))}
    lo, hi = around[key]
    seen = looks(lambda _, __, k: (int(k > 0), axes))
    assert cover([cell(1, 2)], nothing, later(), around) == ""
    assert all((c.lo, c.hi) == (1, 2) for c, _ in seen)
    middle = (lo + hi) / 2
    assert [around for _, around in seen] == [around, {**around, key: (lo, middle)}, {**around, key: (middle, hi)}]
    assert all([*b] == [A, B, C] for _, b in seen)  # in the same order


def halved(seen: list[tuple[Cell, Box]]) -> str:
    """What became smaller from one look to the next: ω, or the name of a parameter."""
    found = ""
    for (c, around), (d, inside) in pairwise(seen):
        names = [key[1] for key in around if around[key] != inside[key]]
        names += ["ω"] if (c.lo, c.hi) != (d.lo, d.hi) else []
        found += "".join(names) or "-"
    return found


# Down to the lowest corner: what a look says matters, but in every fourth step the other kind is tried.
PATHS = [
    ("2", (), [], "ω" * 60),
    ("2", (A,), [], "ωωωωωωωa" * 8),
    ("2", (A, B, C), [], "ωωωωωωωbωωωωωωωaωωωωωωωc" * 3),
    ("2", (A,), [0], "aaaω" * 16),
    ("2", (A, B), [1], "bbbω" * 16),
    ("2", (A, B), [0, 1], "abaω" * 16),
    ("2", (A, B, C), [0, 1, 2], "abcωbcaωcabω" * 6),
    ("2", (A, B, C), [0, 2], "acaω" * 16),
    ("1", (A, B), [], "ab" * 32),
    ("1", (A, B, C), [], "abc" * 22),
    ("1", (A, B, C), [1], "bbbabbbbbbbc" * 5),
    ("1", (A, B, C), [0, 2], "acaaacabacac" * 6),
]


@pytest.mark.parametrize(("hi", "keys", "axes", "path"), PATHS)
def test_sixty_halvings_and_what_each_of_them_halves(
    looks: Any, hi: str, keys: tuple[Key, ...], axes: list[int], path: str
) -> None:
    seen = looks(lambda *_: (0, axes))
    with pytest.raises(CheckError, match=r"^neither proven nor refuted at ω = 1 rad/s$") as undecided:
        cover([cell(1, hi)], nothing, later(), box(*keys))
    assert undecided.value.code == UNDECIDED
    assert halved(seen) == path[:60]
    assert len(seen) == 61


def test_a_point_without_parameters_cannot_be_halved(looks: Any) -> None:
    seen = looks(lambda *_: (0, []))
    with pytest.raises(CheckError, match="neither proven nor refuted at ω = 3 rad/s") as undecided:
        cover([cell(9, 9)], nothing, later())
    assert undecided.value.code == UNDECIDED and len(seen) == 1


def test_forty_thousand_cells_are_too_many(looks: Any) -> None:
    seen, one = looks(lambda *_: (1, [])), cell(1, 1)
    assert cover([one] * 39_999, nothing, inf) == ""
    assert len(seen) == 39_999
    with pytest.raises(CheckError, match=r"^neither proven nor refuted$") as undecided:
        cover([one] * 40_000, nothing, inf)
    assert undecided.value.code == UNDECIDED


def test_the_clock_is_looked_at_before_every_cell(looks: Any) -> None:
    seen = looks(lambda *_: (1, []))
    with pytest.raises(CheckError, match="time limit"):
        cover([cell(1, 2)], nothing, monotonic() - 1)
    assert seen == []


@pytest.mark.parametrize("degree", [1, 2, 4])
def test_a_look_evaluates_the_parts_on_a_grid_the_last_parameter_fastest(degree: int) -> None:
    there, points = cell(1, 2), list[dict[Key, Fraction]]()

    def parts(c: Cell, at: dict[Key, Fraction]) -> list[Any]:
        assert c is there
        points.append(at)
        return []

    around = {B: (Fraction(1), Fraction(3)), A: (Fraction(-1), Fraction(0))}
    assert search._look(there, around, parts, degree, later()) == (1, [])
    steps = [Fraction(k, degree) for k in range(degree + 1)]
    assert points == [{B: 1 + 2 * u, A: w - 1} for u, w in product(steps, repeat=2)]
    assert all([*at] == [B, A] for at in points)


def test_without_parameters_one_look_is_at_one_point() -> None:
    seen: list[Any] = []

    def parts(_: Cell, at: dict[Key, Fraction]) -> list[Any]:
        seen.append(at)
        return []

    assert search._look(cell(1, 2), {}, parts, 2, later()) == (1, [])
    assert seen == [{}]


@pytest.mark.parametrize(
    ("said", "together"),
    [
        ([], (1, [])),
        ([(1, [])], (1, [])),
        ([(0, [1])], (0, [1])),
        ([(-1, [])], (-1, [])),
        ([(1, []), (1, [])], (1, [])),
        ([(1, []), (0, [1]), (1, [])], (0, [1])),
        ([(0, [1]), (0, [0])], (0, [1])),  # the first that is open says what to halve
        ([(0, [0]), (1, []), (-1, [])], (-1, [])),
        ([(1, []), (-1, [])], (-1, [])),
        ([(0, []), (-1, [])], (-1, [])),
    ],
)
def test_all_parts_have_to_be_proven_and_one_that_fails_is_enough(
    said: list[Said], together: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every part is compared with itself over the grid: values of the same part, in the order of the points."""
    there, asked = cell(1, 2), list[Any]()

    def compare(*given: Any) -> Said:
        asked.append(given)
        return said[len(asked) - 1]

    def parts(_: Cell, at: dict[Key, Fraction]) -> list[tuple[int, Fraction]]:
        return [(k, at[A]) for k in range(len(said))]

    monkeypatch.setattr(search, "compare", compare)
    assert search._look(there, box(A), parts, 2, later()) == together
    grid = [Fraction(0), Fraction(1, 2), Fraction(1)]
    assert asked == [(there, tuple((k, u) for u in grid), 2, 1) for k in range(len(asked))]
    assert len(asked) == len(said) or together[0] == -1


def test_zonotopes_go_to_the_hull_and_inequalities_to_the_comparison(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "_hull", lambda same, n: (0, [len(same), n]))
    monkeypatch.setattr(search, "compare", lambda *_: (1, []))
    assert search._look(cell(1, 2), box(A, B), lambda *_: [["zonotope"]], 1, later()) == (0, [4, 2])
    assert search._look(cell(1, 2), box(A, B), lambda *_: [("inequality",)], 1, later()) == (1, [])
    assert search._look(cell(1, 2), {}, lambda *_: [["zonotope"]], 2, later()) == (0, [1, 0])
    assert search._look(cell(1, 2), {}, lambda *_: [("inequality",)], 2, later()) == (1, [])


@pytest.mark.parametrize(
    ("everywhere", "middle", "said"),
    [(True, True, (1, [])), (False, True, (0, [])), (False, False, (0, [0, 1, 2]))],
)
def test_a_hull_halves_parameters_if_zero_is_inside_at_the_middle_too(
    everywhere: bool, middle: bool, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(search, "excludes_zero", lambda zonotopes: (everywhere, middle))
    assert search._hull([], 3) == said


def test_what_cannot_be_said_on_a_cell_asks_for_smaller_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever it comes from, and whatever another part said before."""

    def unresolved(*_: Any) -> Any:
        raise UnresolvedError

    assert search._look(cell(1, 2), box(A, B), unresolved, 2, later()) == (0, [])
    answers: Iterator[Callable[..., Said]] = iter([lambda *_: (0, [1]), unresolved])
    monkeypatch.setattr(search, "compare", lambda *given: next(answers)(*given))
    assert search._look(cell(1, 2), box(A, B), lambda *_: [(), ()], 2, later()) == (0, [])


def test_a_fault_of_another_kind_is_not_taken_for_an_open_question() -> None:
    def fault(*_: Any) -> Any:
        raise CheckError(UNDECIDED, "the loop at infinity depends on the hold")

    with pytest.raises(CheckError, match="depends on the hold"):
        search._look(cell(1, 2), {}, fault, 2, later())


def test_at_most_4096_points_are_evaluated_on_a_cell() -> None:
    keys: list[Key] = [("impedance", k) for k in range(13)]
    assert search._look(cell(1, 1), box(*keys[:12]), nothing, 1, inf) == (1, [])  # 2^12
    for around, degree in ((box(*keys), 1), (box(*keys[:6]), 4), (box(A), 4096)):
        with pytest.raises(CheckError, match="too many ranges at once") as undecided:
            search._look(cell(1, 1), around, nothing, degree, inf)
        assert undecided.value.code == UNDECIDED


def test_the_clock_is_looked_at_before_every_point() -> None:
    with pytest.raises(CheckError, match="time limit"):
        search._look(cell(1, 2), box(A), nothing, 2, monotonic() - 1)


def test_parts_of_different_number_are_not_compared() -> None:
    with pytest.raises(ValueError, match="zip"):
        search._look(cell(1, 1), box(A), lambda _, at: [Inequality([], 0)] * int(at[A] == 0), 1, later())
