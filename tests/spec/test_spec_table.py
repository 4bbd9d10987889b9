"""A bound from a CSV file: the same numbers in every wrapping, and every fault at its line."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from spec_texts import table

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import Spec, canonical, from_canonical, load_spec, parse_spec
from robimp.synthesis.spec.units import TWO_PI

Edit = Callable[..., str]
Load = Callable[[bytes], Spec]
NAMED = table("{file: bound.csv, beyond: hold}")
PLAIN = b"omega [rad/s],bound\n0.5,0.1\n10,1e-3\n100,2\n"


@pytest.fixture
def load(tmp_path: Path, edit: Edit) -> Load:
    """The specification whose table is a file of these bytes."""

    def loaded(data: bytes) -> Spec:
        (tmp_path / "bound.csv").write_bytes(data)
        (tmp_path / "spec.yaml").write_text(edit(NAMED), encoding="utf-8")
        return load_spec(tmp_path / "spec.yaml")

    return loaded


def points(spec: Spec) -> tuple[tuple[Fraction, Fraction], ...]:
    assert spec.uncertainty.table is not None and spec.uncertainty.table.beyond == "hold"
    return spec.uncertainty.table.points


@pytest.mark.parametrize(
    "data",
    [
        PLAIN,
        b"\xef\xbb\xbf" + PLAIN,
        PLAIN.replace(b"\n", b"\r\n"),
        PLAIN.replace(b"\n", b"\r"),
        PLAIN.rstrip(),
        PLAIN.replace(b"\n", b"\n\n  \n"),
        PLAIN.replace(b",", b" ,  "),
        PLAIN.partition(b"\n")[2],
        b'"omega (rad/s)","bound"\n"0.5","0.1"\n"10","0.001"\n"100","2"\n',
        "ω [rad/s],bound\n0.5,0.1\n10,0.001\n100,2\n".encode(),
        b"Frequency,Bound\n5e-1,.1\n1e1,1/1000\n+100,2.0\n",
        b"frequency,bound [%]\n0.5,10\n10,0.1\n100,200\n",
    ],
    ids=["plain", "BOM", "CRLF", "CR", "no last newline", "blank lines", "spaces", "no heading", "quotes", "ω", "bare",
         "percent"],
)  # fmt: skip
def test_the_same_table_in_another_wrapping(data: bytes, load: Load) -> None:
    expected = [("1/2", "1/10"), ("10", "1/1000"), ("100", "2")]
    assert points(load(data)) == tuple((Fraction(omega), Fraction(bound)) for omega, bound in expected)


@pytest.mark.parametrize(
    ("heading", "factor"), [("frequency [Hz]", TWO_PI), ("omega (kHz)", 1000 * TWO_PI), ("frequency[ rad/s ]", 1)]
)
def test_the_heading_says_the_unit(heading: str, factor: Fraction, load: Load) -> None:
    assert points(load(f"{heading},bound\n0,0\n3,0.25\n".encode())) == ((0, 0), (3 * factor, Fraction(1, 4)))


def test_a_file_and_its_points_are_one_specification(load: Load, edit: Edit) -> None:
    spec = load(PLAIN)
    assert spec == parse_spec(edit(table("{points: [[0.5, 0.1], [10, 1e-3], [100, 2]], beyond: hold}")))
    assert from_canonical(canonical(spec)) == spec


def test_a_thousand_points_in_a_folder_below(tmp_path: Path, edit: Edit) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "b.csv").write_text("".join(f"{k},1\n" for k in range(1000)), encoding="utf-8")
    (tmp_path / "spec.yaml").write_text(edit(table("{file: data/b.csv, beyond: hold}")), encoding="utf-8")
    assert len(points(load_spec(tmp_path / "spec.yaml"))) == 1000


def test_the_folder_is_that_of_the_specification(tmp_path: Path, load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = load(PLAIN)
    monkeypatch.chdir(tmp_path)
    assert load_spec("spec.yaml") == spec
    monkeypatch.chdir("/")
    assert load_spec(tmp_path / "spec.yaml") == spec


@pytest.mark.parametrize(
    ("data", "line", "key", "fragment"),
    [
        (b"", 1, None, "expected at least one point, a frequency and a bound; found none"),
        (b"\n\r\n  \n", 1, None, "expected at least one point"),
        (b"omega [rad/s],bound\n", 1, None, "expected at least one point"),
        (b"1,0.1\n3,0.1\n2,0.1\n", 3, None, "expected frequencies that increase; found 2 after 3 rad/s; sort the rows"),
        (b"f,b\n", 1, None, "found 'f'; write `frequency [Hz],bound` or `omega [rad/s],bound`"),
        (b"1,0.1\n\n1.0,0.2\n", 3, None, "expected each frequency once; found 1 after 1 rad/s"),
        (b"0,0.1\n0,0.2\n", 2, None, "expected each frequency once"),
        (b"-1,0.1\n", 1, None, "expected a frequency"),
        (b"1,0.1\n2,-0.1\n", 2, None, "expected a bound"),
        (b"1,nan\n", 1, "bound", "must be finite"),
        (b"nan,1\n", 1, "frequency", "must be finite"),
        (b"1,0.1\n2,inf\n", 2, "bound", "must be finite"),
        (b"1,1e400\n", 1, "bound", "exponent must lie between"),
        (b"1,0.1\n2,text\n", 2, "bound", "found 'text': write a number such as"),
        (b"1,0.1\n2,\n", 2, "bound", "found nothing: it is empty"),
        (b"1,0.1\n,\n", 2, "frequency", "found nothing: it is empty"),
        (b"1,0.1\n,0.2\n", 2, "frequency", "found nothing: it is empty"),
        (b"1,0.1\nomega,bound\n", 2, "frequency", "found 'omega'"),
        (b"1;0.1\n", 1, None, "expected a comma between the columns; found ';'"),
        (b"1;0,1\n", 1, None, "found ';'; write `10.5,0.1`: a comma, and decimal points"),
        (b"omega;bound\n1;1\n", 1, None, "found ';'"),
        (b"1\t0.1\n", 1, None, "found '\\t'"),
        (b"1 0.1\n", 1, None, "expected two columns, frequency and bound; found 1"),
        (b"1,0.1\n2,0.1,3\n", 2, None, "expected two columns, frequency and bound; found 3"),
        (b"omega [rpm],bound\n1,1\n", 1, None, "'rpm' is not a unit of an angular frequency here: use one of rad/s"),
        (b"omega [2],bound\n1,1\n", 1, None, "found 'omega [2]'"),
        (b"omega,bound [dB]\n1,1\n", 1, None, "expected the heading bound or bound [%]; found 'bound [dB]'"),
        (b"bound,omega\n1,1\n", 1, None, "found 'bound'; write `frequency [Hz],bound`"),
        (b"omega,phase\n1,1\n", 1, None, "expected the heading bound or bound [%]; found 'phase'"),
        (b"1 Hz,0.1\n", 1, "frequency", "units go into the heading"),
        (b"# omega,bound\n1,1\n", 1, None, "found '# omega'"),
        (b"1,0.1\n2,\x00\n", 2, "bound", "found '\\x00'"),
        (b"\x00" * 100, 1, None, "expected two columns"),
        ("1,0.1\n".encode("utf-16"), 1, None, "expected UTF-8 text; found the byte 0xff; save the file as UTF-8"),
        (b"1,0.1\n2,\xfc\n", 2, None, "found the byte 0xfc"),
        (b'1,"0.1\n', 1, None, "not valid CSV: unexpected end of data; check the quotes"),
        (b'1,"0.1"x\n', 1, None, "not valid CSV"),
        (b"1," + b"9." + b"9" * 200 + b"\n", 1, "bound", "at most 100 digits"),
        (b"1," + b"9" * 30_000 + b"\n", 1, None, "break the line"),
        (b"".join(b"%d,1\n" % k for k in range(1001)), 1001, None, "expected at most 1000 points; found more"),
        (b"\n" * 30_000, 20_000, None, "expected at most 20000 lines"),
        (b"1e300,1\n", None, None, ""),
        (b"frequency [Hz],bound\n1e300,1\n", 2, "frequency", "magnitude in SI must lie between"),
        ("1,−0.1\n".encode(), 1, "bound", "found '−0.1'"),
        (b"1_000,1\n", 1, "frequency", "without underscores"),
    ],
)  # fmt: skip
def test_a_fault_in_the_file_is_told_at_its_line(
    data: bytes, line: int | None, key: str | None, fragment: str, load: Load, tmp_path: Path
) -> None:
    if line is None:  # at the limit, and accepted
        assert points(load(data)) == ((10**300, 1),)
        return
    with pytest.raises(InputError) as refusal:
        load(data)
    error = refusal.value
    assert error.location is not None
    assert (error.location.file, error.location.line, error.location.key) == (str(tmp_path / "bound.csv"), line, key)
    assert fragment in error.message
    assert "\n" not in str(error) and str(error).isprintable()


def test_a_huge_file_is_refused_soon_and_unread(tmp_path: Path, load: Load) -> None:
    with (tmp_path / "huge").open("wb") as stream:
        stream.truncate(50_000_000)
    load(PLAIN)
    (tmp_path / "bound.csv").unlink()
    (tmp_path / "huge").rename(tmp_path / "bound.csv")
    start = time.process_time()
    with pytest.raises(InputError, match=r"bound\.csv: expected at most 1000000 bytes"):
        load_spec(tmp_path / "spec.yaml")
    assert time.process_time() - start < 1


@pytest.mark.parametrize(
    ("file", "fragment"),
    [
        ("../bound.csv", "expected a path below the specification's folder; found '../bound.csv'"),
        ("../..", "found '../..'"),
        ("sub/../bound.csv", "found 'sub/../bound.csv'"),
        ("/etc/hostname", "found '/etc/hostname'; put the file into the specification's folder"),
        ("C:\\bound.csv", "expected a path below"),
        ("..\\bound.csv", "expected a path below"),
        ("\\\\host\\bound.csv", "expected a path below"),
        (".", "'.' is no regular file"),
        ("sub", "'sub' is no regular file"),
        ("fifo", "'fifo' is no regular file"),
        ("absent.csv", "expected a CSV file; 'absent.csv' does not exist"),
        ("outside.csv", "this is a link to outside of it"),
        ("loop.csv", "loop.csv"),
        ("long" * 100, "too long"),
        ("''", "expected the name of a CSV file; found nothing"),
        ("[a.csv]", "expected the name of a CSV file; found a list"),
        ('"nul\\0.csv"', "cannot be read"),
    ],
)
def test_only_a_regular_file_inside_the_folder_is_read(file: str, fragment: str, tmp_path: Path, edit: Edit) -> None:
    home = tmp_path / "home"
    (home / "sub").mkdir(parents=True)
    (home / "bound.csv").write_bytes(PLAIN)
    (tmp_path / "bound.csv").write_bytes(PLAIN)
    (home / "outside.csv").symlink_to(tmp_path / "bound.csv")
    (home / "loop.csv").symlink_to(home / "loop.csv")
    os.mkfifo(home / "fifo")
    (home / "spec.yaml").write_text(edit(table(f"{{file: {file}, beyond: hold}}")), encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        load_spec(home / "spec.yaml")
    error = refusal.value
    assert error.location is not None
    assert (error.location.file, error.location.line) == (str(home / "spec.yaml"), 5)
    assert error.location.key == "uncertainty.table.file"
    assert fragment in error.message
    assert "\n" not in str(error) and str(error).isprintable()


def test_an_unreadable_file_is_refused(tmp_path: Path, load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    load(PLAIN)
    whole = Path.open

    def denied(path: Path, mode: str) -> object:
        if path.name == "bound.csv":
            raise PermissionError(13, "Permission denied")
        return whole(path, mode)

    monkeypatch.setattr(Path, "open", denied)
    with pytest.raises(InputError, match=r"uncertainty\.table\.file: the file cannot be read: Permission denied"):
        load_spec(tmp_path / "spec.yaml")


def test_a_certificate_reads_no_file(load: Load, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    document = canonical(load(PLAIN))
    document["uncertainty"]["table"] = {"file": "bound.csv", "beyond": "hold"}  # type: ignore[index]
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="has no folder to look in"):
        from_canonical(document)


def test_of_a_fault_in_the_file_and_one_in_the_specification_the_first_is_told(tmp_path: Path, edit: Edit) -> None:
    (tmp_path / "bound.csv").write_bytes(b"1,1\n" * 50)
    for pair, told in ((("damping: 0.2,", "damping: x,"), "spec.yaml:4:"), (("0.35", "x"), "bound.csv:2")):
        (tmp_path / "spec.yaml").write_text(edit(NAMED, pair), encoding="utf-8")
        with pytest.raises(InputError, match=told):
            load_spec(tmp_path / "spec.yaml")


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.one_of(
        st.binary(max_size=60),
        st.lists(
            st.sampled_from(["1", "2", ",", "\n", ";", '"', "omega", "bound", "[Hz]", "[", "]", "(", "-", "nan", "\r",
                             "\x00", "é", "1e300", "%", " ", "1/0", "0x1", "\u2028", "'", "\ufeff"]),
            max_size=30,
        ).map(lambda parts: "".join(parts).encode()),
    )
)  # fmt: skip
def test_whatever_the_bytes(load: Load, data: bytes) -> None:
    try:
        spec = load(data)
    except InputError as error:
        assert "\n" not in str(error)
        return
    found = points(spec)
    assert all(earlier[0] < later[0] for earlier, later in pairwise(found))
    assert from_canonical(canonical(spec)) == spec
