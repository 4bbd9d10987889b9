"""Dead and incoherent records, and the bound that covers the others: exact, and never too small."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from identify_data import record

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec.record import (
    Sample,
    deviations,
    dynamic_stiffness,
    envelope,
    rounded_up,
    stepped,
    unusable,
)
from robimp.synthesis.spec.selection import select

GOOD = record([1] * 5, "good", coherence=[0.9, 1, 0.8, 0.05, 0.9])
IDENTITY = dynamic_stiffness(Fraction(0), Fraction(0), Fraction(1))  # the model 1


def test_a_dead_record_is_found_by_its_coherence_and_by_its_gain() -> None:
    silent = record([1, 1, 1, 1], "silent", coherence=[0.9, 0.02, 0.0002, 0.9])
    assert unusable([GOOD]) == {}, "one silent point in five is a bad point, not a dead sensor"
    found = unusable([GOOD, silent])
    assert list(found) == ["silent"]
    assert found["silent"].startswith("dead: coherence below 0.1 at 2 of 4 points, the least 0.0002 at 3 rad/s")
    others = [record([1, 1, 1, 1], name) for name in "abc"]
    quiet = record([1, 0.01, 0.01, 1], "quiet")
    assert unusable([*others, quiet]) == {"quiet": "dead: gain below 0.05 of the other records' at 2 of 4 points"}
    assert unusable([*others[:1], quiet]) == {}, "of two records nobody knows which is dead"


def test_an_incoherent_record_is_found_by_its_median() -> None:
    poor = record([1, 1, 1, 1], "poor", coherence=[0.4, 0.45, 0.4, 1])
    assert unusable([poor]) == {"poor": "incoherent: median coherence 0.425"}
    assert unusable([record([1] * 4, coherence=[0.5, 0.5, 0.5, 0.5])]) == {}


@given(st.fractions(0, 10**6, max_denominator=10**9))
def test_a_root_is_rounded_up_to_four_digits(squared: Fraction) -> None:
    root = rounded_up(squared)
    assert root**2 >= squared
    if squared:
        assert (root * (1 - Fraction(1, 999))) ** 2 < squared, "and by less than one in the fourth digit"
        assert len(str(root.numerator * 10**12 // root.denominator).strip("0")) <= 4


def test_the_deviation_covers_what_arithmetic_may_be_off() -> None:
    inverse = dynamic_stiffness(Fraction("0.05"), Fraction("0.3"), Fraction(2))
    values = [complex(1 / (2 - 0.05 * w * w + 0.3j * w)) * 1.25 for w in (1, 2, 3)]
    exact = deviations(record(values), inverse)
    assert all(Fraction("0.25") <= bound <= Fraction("0.2501") for bound in exact)
    sample = Sample(Fraction(1), Fraction("1.25"), Fraction(0), error=Fraction("0.01"))
    blurred = deviations(type(GOOD)("b", (sample,)), IDENTITY)
    assert blurred[0] >= Fraction("0.26")


def test_between_its_samples_a_record_counts_with_the_larger_and_outside_not_at_all() -> None:
    wide, dense = record([1.5, 1.1], "wide", omega=[2, 6]), record([1.2] * 4, "dense", omega=[1, 3, 5, 7])
    bounds = envelope([wide, dense], IDENTITY)
    assert [float(w) for w, _ in bounds] == [1, 2, 3, 5, 6, 7]
    assert [round(float(b), 3) for _, b in bounds] == [0.2, 0.5, 0.5, 0.5, 0.2, 0.2]
    assert envelope([dense, wide], IDENTITY) == bounds


@given(st.lists(st.fractions(0, 5), min_size=2, max_size=9), st.floats(0, 1))
def test_straight_lines_between_raised_points_stay_above_both_neighbours(values: list[Fraction], t: float) -> None:
    raised = stepped(tuple(enumerate(map(Fraction, values))))  # type: ignore[arg-type]
    lines = np.interp(np.arange(len(values) - 1) + t, *np.array([[float(x) for x in row] for row in raised]).T)
    steps = [float(max(pair)) for pair in pairwise(values)]
    assert all(line >= step * (1 - 1e-12) for line, step in zip(lines, steps, strict=True))


def test_the_amplitude_selects_and_must_be_stated_where_there_are_several() -> None:
    records = [record([1, 1], name, amplitude=a) for name, a in (("x:a", 0.1), ("x:b", 1), ("x:c", 5))]
    chosen = select(records, (Fraction(1), Fraction(5)), ["c"], None)
    assert [r.name for r in chosen.kept] == ["x:b"]
    assert (chosen.excluded, chosen.other_amplitudes) == (("x:c",), ("x:a",))
    assert len(select(records[:1], None, (), None).kept) == 1
    for amplitude, exclude, says in (
        (None, [], r"amplitudes 0.1 to 5, and friction makes .* amplitude: \[0.1, 5\]"),
        ((Fraction(2), Fraction(3)), [], "leave none of 3"),
        ((Fraction(1), Fraction(5)), ["d"], "'d' matches none"),
        ((Fraction(1), Fraction(5)), ["*"], "leave none"),
    ):
        with pytest.raises(InputError, match=says):
            select(records, amplitude, exclude, None)
    with pytest.raises(InputError, match="two records are named"):
        select([records[0], records[0]], None, (), None)
