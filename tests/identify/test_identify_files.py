"""Frequency responses from CSV files: the same numbers in every wrapping, and every fault at its line and column."""

from __future__ import annotations

import cmath
from fractions import Fraction
from pathlib import Path

import control
import numpy as np
import pytest
from command_line import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from identify_data import HERTZ, TRUTH, compliance, csv_text, polar_text

from robimp.synthesis.errors import ExitCode, InputError
from robimp.synthesis.identify import read_files, record_of
from robimp.synthesis.spec.polar import cartesian, ratio_of_decibels
from robimp.synthesis.spec.record import Record
from robimp.synthesis.spec.response_file import read_responses
from robimp.synthesis.spec.units import TWO_PI

PLAIN = b"omega [rad/s],real,imaginary\n1,0.5,-0.25\n2,1/4,-1e-1\n"


def read(data: bytes | str) -> tuple[Record, ...]:
    return read_responses(data.encode() if isinstance(data, str) else data, "frf.csv", "frf")


def numbers(record: Record) -> list[tuple[Fraction, Fraction, Fraction]]:
    return [(s.omega, s.re, s.im) for s in record.samples]


@pytest.mark.parametrize(
    "data",
    [
        PLAIN,
        b"\xef\xbb\xbf" + PLAIN,
        PLAIN.replace(b"\n", b"\r\n"),
        PLAIN.replace(b"\n", b"\n\n"),
        b"re,im,omega\n0.5,-0.25,1\n0.25,-0.1,2\n",
        "ω (rad/s),Re,Imag\n1,0.5,-0.25\n2,0.25,-0.1\n".encode(),
        b"f_rad/s,real [rad/(N*m)],imag [rad/(N*m)]\n1,0.5,-0.25\n2,0.25,-0.1\n",
    ],
    ids=["plain", "BOM", "CRLF", "blank lines", "other order", "Greek", "underscore and units"],
)
def test_the_same_numbers_in_another_wrapping(data: bytes) -> None:
    (record,) = read(data)
    assert numbers(record) == [(1, Fraction(1, 2), Fraction(-1, 4)), (2, Fraction(1, 4), Fraction(-1, 10))]
    assert all(sample.error == 0 for sample in record.samples), "nothing was rounded"


def test_hertz_are_exact_and_gain_and_phase_as_near_as_they_say() -> None:
    (plain,), (polar,) = read(csv_text()), read(polar_text())
    assert [s.omega for s in plain.samples] == [Fraction(str(f)) * TWO_PI for f in HERTZ]
    for hertz, sample in zip(HERTZ, polar.samples, strict=True):
        assert abs(complex(sample.re, sample.im) / compliance(TRUTH, hertz) - 1) < 1e-10
        assert 0 < sample.error < abs(sample.re + sample.im) * 10 ** -Fraction(28)


@given(st.fractions(-1000, 1000), st.sampled_from(["deg", "rad"]))
def test_polar_is_what_the_library_says(phase: Fraction, unit: str) -> None:
    re, im = cartesian(Fraction(3), phase, unit)  # type: ignore[arg-type]
    angle = np.radians(float(phase % 360)) if unit == "deg" else float(phase)
    assert abs(complex(re, im) - 3 * cmath.exp(1j * angle)) < 1e-11
    assert abs(re**2 + im**2 - 9) < Fraction(1, 10**35), "far closer than doubles"


def test_decibels() -> None:
    assert ratio_of_decibels(Fraction(20)) == 10 and ratio_of_decibels(Fraction(-40)) == Fraction(1, 100)
    with pytest.raises(ValueError, match="400 dB"):
        ratio_of_decibels(Fraction(401))


def test_several_records_in_a_file_and_several_files(tmp_path: Path) -> None:
    both = "run,amplitude [N·m],frequency [Hz],real,imaginary,coherence\n"
    rows = "a,1,1,2,0,0.9\na,1,2,2,0,1\nb,1,1,3,0,0\nb,1,2,3,0,1\nb,5,1,4,0,1\nb,5,2,4,0,1\n"
    records = read(both + rows)
    assert [r.name for r in records] == ["frf:a", "frf:b at 1", "frf:b at 5"]
    assert [r.amplitude for r in records] == [1, 1, 5]
    assert [s.coherence for s in records[0].samples] == [Fraction(9, 10), 1]
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "x.csv").write_text(csv_text(), encoding="utf-8")
    names = [r.name for r in read_files([tmp_path / "one" / "x.csv", tmp_path / "two" / "x.csv"])]
    assert len(set(names)) == 2
    assert [r.name for r in read_files([tmp_path / "one" / "x.csv"])] == ["x"]


HEADING = "omega,real,imaginary\n"
FAULTS = [
    ("", 1, None, "expected a heading and rows; found none"),
    ("omega,real,imaginary\n", 1, None, "found none"),
    (HEADING + "1,text,0\n", 2, "real", "found 'text': write a number"),
    (HEADING + "1,nan,0\n", 2, "real", "must be finite"),
    (HEADING + "1,0,inf\n", 2, "imaginary", "must be finite"),
    (HEADING + "1,,0\n", 2, "real", "found nothing"),
    (HEADING + "2,1,0\n1,1,0\n", 3, "omega", "increase within a record; found 1 after 2 rad/s; sort the rows"),
    (HEADING + "1,1,0\n1,1,0\n", 3, "omega", "each frequency once in a record; found 1 after 1 rad/s"),
    (HEADING + "0,1,0\n", 2, "omega", "expected a frequency > 0; found 0"),
    (HEADING + "-1,1,0\n", 2, "omega", "expected a frequency > 0; found -1"),
    (HEADING + "1,1,0\n", 2, None, "at least two frequencies"),
    (HEADING + "1;1;0\n", 2, None, "expected a comma between the columns; found ';'"),
    ("omega;real;imaginary\n1;1;0\n", 1, None, "found ';'; write `10.5,0.1`"),
    (HEADING + "1,5,1,0\n", 2, None, "expected 3 columns as in the heading; found 4; write decimals with a point"),
    (HEADING + '"1,5",1,0\n', 2, "omega", "write the decimal point as a point"),
    (HEADING + "1,1\n", 2, None, "expected 3 columns as in the heading; found 2"),
    (HEADING + "1 Hz,1,0\n", 2, "omega", "units go into the heading"),
    ("1,2,3\n", 1, None, "expected a heading, one of frequency, real"),
    ("omega,real\n1,1\n", 1, None, "imaginary is missing"),
    ("real,imaginary\n1,1\n", 1, None, "frequency is missing"),
    ("omega,coherence\n1,1\n", 1, None, "found neither"),
    ("omega,real,imaginary,gain\n1,1,1,1\n", 1, None, "found some of both; keep one pair"),
    (
        "omega,frequency [Hz],real,imaginary\n1,1,1,1\n",
        1,
        None,
        "expected one column frequency; found a second one, 'frequency [Hz]'",
    ),
    ("frequency,real,imaginary\n1,1,1\n", 1, None, "'frequency': its unit is missing; use rad/s, Hz, kHz"),
    ("frequency [rpm],real,imaginary\n1,1,1\n", 1, None, "'rpm' is not a unit of a frequency here; use rad/s, Hz"),
    ("omega,gain [%],phase [deg]\n1,1,1\n", 1, None, "'%' is not a unit of a gain here"),
    ("omega,gain,phase\n1,1,1\n", 1, None, "'phase': its unit is missing; use deg, °, rad"),
    ("omega,gain,phase [turns]\n1,1,1\n", 1, None, "'turns' is not a unit of a phase"),
    ("omega,gain,phase [deg]\n1,-2,0\n", 2, "gain", "expected a gain ≥ 0; found -2; if it is in decibels"),
    ("omega,gain,phase [deg]\n1,1,1e12\n", 2, "phase [deg]", "less than a million turns"),
    ("omega,real,imaginary,coherence\n1,1,1,1.2\n", 2, "coherence", "a coherence from 0 to 1; found 1.2"),
    ("omega,real,imaginary,coherence\n1,1,1,-0.1\n", 2, "coherence", "found -0.1"),
    ("omega,real,imaginary,amplitude\n1,1,1,0\n", 2, "amplitude", "expected an amplitude > 0"),
    ("omega,real,imaginary,colour\n", 1, None, "found 'colour'"),
    (HEADING + '1,"1,0\n', 2, None, "not valid CSV"),
    ('record,omega,real,imaginary\n"a\nplant: 1",1,1,0\n', 3, None, "expected the name of a record"),
    (HEADING + "1,9." + "9" * 200 + ",0\n", 2, "real", "at most 100 digits"),
]


@pytest.mark.parametrize(("text", "line", "key", "fragment"), FAULTS, ids=[fault[3][-40:] for fault in FAULTS])
def test_a_fault_is_told_at_its_line_and_column(text: str, line: int, key: str | None, fragment: str) -> None:
    with pytest.raises(InputError) as refusal:
        read(text)
    where = refusal.value.location
    assert where is not None and (where.file, where.line, where.key) == ("frf.csv", line, key)
    assert fragment in refusal.value.message
    assert "\n" not in str(refusal.value) and str(refusal.value).isprintable()


@pytest.mark.parametrize("data", [b"\xff\xfe1\x00", b"\x00" * 100, "ä".encode("latin-1")])
def test_what_is_no_text_is_refused(data: bytes) -> None:
    with pytest.raises(InputError):
        read(data)


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "huge.csv").write_bytes(b"")
    with (tmp_path / "huge.csv").open("r+b") as stream:
        stream.truncate(50_000_000)
    (tmp_path / "text.csv").write_text(HEADING + "1,x,0\n", encoding="utf-8")
    for name, says in (
        ("huge.csv", "at most 1000000 bytes"),
        ("absent.csv", "cannot be read"),
        (".", "no regular file"),
        ("text.csv", "text.csv:2: real: expected a number"),
    ):
        assert says in refused(ExitCode.INPUT, "identify", tmp_path / name, "--beyond", "hold")


@settings(max_examples=300, deadline=None)
@given(
    st.one_of(
        st.binary(max_size=80),
        st.lists(
            st.sampled_from(
                ["1", "2", "0.5", ",", "\n", ";", '"', "omega", "real", "im", "gain", "phase", "[deg]", "[dB]", "_Hz",
                 "coherence", "record", "nan", "\r", "\x00", "é", "-", "e9", "(", ")", "\ufeff"]
            ),
            max_size=40,
        ).map(lambda parts: "".join(parts).encode()),
    )
)  # fmt: skip
def test_whatever_the_bytes(data: bytes) -> None:
    try:
        records = read(data)
    except InputError as error:
        assert "\n" not in str(error)
        return
    for record in records:
        omega = [sample.omega for sample in record.samples]
        assert omega == sorted(set(omega)) and omega[0] > 0 and len(omega) > 1


def test_a_control_frd() -> None:
    omega = np.array([1.0, 2.0, 4.0])
    G = 1 / (2 - 0.05 * omega**2 + 0.3j * omega)
    record = record_of(control.frd(G, omega), "sweep", amplitude=2, coherence=[0.9, 1, 1])
    assert [complex(s.re, s.im) for s in record.samples] == list(G)
    assert (record.name, record.amplitude, record.samples[0].coherence) == ("sweep", 2, Fraction(0.9))
    for response, share in (
        (control.frd(np.ones((2, 1, 3)), omega), None),
        (control.frd(np.array([1, np.nan, 1]), omega), None),
        (control.frd(G, omega), [1, 1]),
        (control.frd(G, omega), [1, 1, 2]),
        (control.frd(G[:1], omega[:1]), None),
        (control.frd(G, np.array([0.0, 1, 2])), None),
    ):
        with pytest.raises(InputError):
            record_of(response, "sweep", coherence=share)
