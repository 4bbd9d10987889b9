"""Whatever the bytes, the reader answers with a `Spec` or an `InputError`, soon."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from spec_texts import EVERY_NEW_KEY

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import Spec, canonical, fields, from_canonical, parse_spec, spec_warnings
from robimp.synthesis.spec.exact import number_text, parse_number

RELAXED = settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
TROUBLE = st.sampled_from(
    ["&a ", "*a", "!!int ", "!", "{", "}", "[", "]", ":", ": ", "- ", "? ", "|", ">", '"', "'", "%", "#", "\t", "\n",
     "\r", "\x00", "\x85", "\u2028", "\ufeff", "---\n", "...\n", "<<: ", "null", "~", "", "-", "0", "1e400", "1e-301",
     "nan", "±", "%", "/", "1/0", "9" * 200, "\\", "\\U00110000", "é", "±100 %", "[1, 2]", "{}", "[]", "off", "inf",
     "0x", "Hz", "1e300", "1e300 kHz", "1e-300 g·m²", "±99." + "9" * 60 + " %", "1/" + "3" * 1990 + " Hz"]
)  # fmt: skip


def answer(text: str | bytes) -> Spec | None:
    """What the reader makes of it; any exception but `InputError` goes through and fails the test."""
    start = time.process_time()
    try:
        spec = parse_spec(text)
    except InputError as error:
        assert str(error).startswith("<string>") and "\n" not in str(error)
        return None
    finally:
        assert time.process_time() - start < 2
    return spec


@RELAXED
@given(st.binary(max_size=200))
def test_bytes(data: bytes) -> None:
    answer(data)


@RELAXED
@given(st.lists(st.one_of(TROUBLE, st.text(max_size=5)), max_size=30).map("".join))
def test_yaml_like_text(text: str) -> None:
    answer(text.encode("utf-8", "surrogatepass"))


@RELAXED
@given(data=st.data())
def test_the_good_specification_with_pieces_replaced(data: st.DataObject, good: str) -> None:
    text = good
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        end = start + data.draw(st.integers(0, 6))
        text = text[:start] + data.draw(st.one_of(TROUBLE, st.text(max_size=3))) + text[end:]
    answer(text.encode("utf-8", "surrogatepass"))


@RELAXED
@given(data=st.data())
def test_the_good_specification_with_one_value_replaced(data: st.DataObject, good: str) -> None:
    values = list(re.finditer(r"(?<=: )[^\s{}\[\],]+", good))
    value = data.draw(st.sampled_from(values))
    spec = answer(good[: value.start()] + data.draw(TROUBLE) + good[value.end() :])
    if spec is not None:  # what is accepted survives its canonical form
        assert from_canonical(canonical(spec)) == spec


@RELAXED
@given(data=st.data())
def test_a_specification_of_every_new_key_with_one_value_replaced(
    data: st.DataObject, edit: Callable[..., str]
) -> None:
    text = edit(*EVERY_NEW_KEY)
    values = list(re.finditer(r"(?<=[:\[,] )[^\s{}\[\],]+|(?<=\[)[^\s{}\[\],]+", text))
    value = data.draw(st.sampled_from(values))
    spec = answer(text[: value.start()] + data.draw(TROUBLE) + text[value.end() :])
    if spec is not None:
        assert from_canonical(canonical(spec)) == spec
        assert all(isinstance(warning, str) for warning in spec_warnings(spec))


@RELAXED
@given(st.from_regex(r"\A[+-]?([1-9][0-9]{0,20}|0)(\.[0-9]{0,20})?([eE][+-]?[0-9]{1,2})?\Z"))
def test_a_decimal_is_read_exactly(text: str) -> None:
    assert parse_number(text) == Fraction(text)


@RELAXED
@given(st.fractions())
def test_number_text_is_read_back(value: Fraction) -> None:
    assert parse_number(number_text(value)) == value


def test_the_fuzz_would_notice_another_exception(good: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> Fraction:
        raise ZeroDivisionError

    assert answer(good) is not None
    monkeypatch.setattr(fields, "parse_quantity", broken)
    with pytest.raises(ZeroDivisionError):
        answer(good)
