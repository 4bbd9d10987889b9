"""Every fault in a specification is one clear line: file, line, key, what was expected, what was found, what to do."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import Spec, load_spec, parse_spec

BAD = Path(__file__).parents[1] / "data" / "specs" / "bad"
TABLE = [tuple(row.split("\t")) for row in (BAD / "expected.tsv").read_text(encoding="utf-8").splitlines()[1:]]
JARGON = ("Traceback", "pydantic", "validation error", "Error", "ruamel", "<unicode string>")


def test_the_table_and_the_folder_list_the_same_files() -> None:
    assert sorted(row[0] for row in TABLE) == sorted(path.name for path in BAD.glob("*.yaml"))
    assert len(TABLE) >= 45


@pytest.mark.parametrize(("file", "line", "key", "fragment"), TABLE, ids=[row[0] for row in TABLE])
def test_a_bad_specification_is_refused_at_its_place(file: str, line: str, key: str, fragment: str) -> None:
    with pytest.raises(InputError) as refusal:
        load_spec(BAD / file)
    error = refusal.value
    assert error.location is not None
    assert (str(error.location.line), error.location.key or "-") == (line, key)
    assert fragment in error.message
    text = str(error)
    assert text.startswith(f"{BAD / file}:{line}:{error.location.column}: ")
    assert "\n" not in text and text.isprintable()
    assert not any(word in text for word in JARGON)


def test_the_file_the_bad_ones_were_made_from_is_accepted() -> None:
    assert isinstance(load_spec(BAD.parent / "good.yaml"), Spec)


def test_a_file_beyond_the_size_limit_is_refused_and_one_below_accepted(good: str) -> None:
    filler = "#" * 999 + "\n"
    assert isinstance(parse_spec(good + filler * 990), Spec)
    with pytest.raises(InputError, match="at most 1000000 bytes"):
        parse_spec(good + filler * 1001)


def test_a_file_of_endless_lines_is_refused(good: str) -> None:
    with pytest.raises(InputError, match="at most 20000 lines"):
        parse_spec(good + "#\n" * 20_001)


@pytest.mark.parametrize(
    "text", ["[" * 19_999, "{" * 19_999, "!" * 19_999, "- " * 9_999, "? " * 9_999, "a:\n" * 19_000]
)
def test_text_made_to_be_slow_is_refused_soon(text: str) -> None:
    start = time.process_time()
    with pytest.raises(InputError):
        parse_spec(text)
    assert time.process_time() - start < 3


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    for path, reason in (
        (tmp_path / "absent.yaml", "No such file"),
        (tmp_path, "no regular file"),
        (fifo, "no regular file"),
        (Path("nul\0.yaml"), "cannot be read"),
        (tmp_path / ("long" * 100), "too long"),
    ):
        with pytest.raises(InputError, match=reason):
            load_spec(path)


def test_an_unprintable_key_is_shown_printably() -> None:
    with pytest.raises(InputError) as refusal:
        parse_spec('robimp: 1\n"\\e[31mred\\n": 1\n')
    assert str(refusal.value).isprintable()


def test_a_lone_surrogate_is_no_text(good: str) -> None:
    with pytest.raises(InputError, match="UTF-8"):
        parse_spec(good + "# \ud800")
