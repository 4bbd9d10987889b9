"""`uncertainty: measured:`: data files become a table of bounds that is exact, self-contained and covers the truth."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from fractions import Fraction
from hashlib import sha256
from itertools import pairwise
from pathlib import Path

import pytest
from identify_data import HERTZ, TRUTH, compliance, csv_text, polar_text, spec_text

from robimp.synthesis import check, synthesize
from robimp.synthesis.check import check_bytes
from robimp.synthesis.errors import ExitCode, InputError
from robimp.synthesis.spec import (
    Spec,
    canonical,
    canonical_json,
    from_canonical,
    load_spec,
    parse_spec,
    spec_sha256,
    spec_warnings,
)
from robimp.synthesis.spec.model import Table
from robimp.synthesis.spec.units import TWO_PI

Load = Callable[[str], Spec]
OTHER = (0.06, 0.36, 2.2)
WHOLE = "{files: [frf/*.csv], beyond: hold}"


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """The specification with this `measured:` section, beside frf/a.csv (the truth) and frf/b.csv (another load)."""
    (tmp_path / "frf").mkdir()
    (tmp_path / "frf" / "a.csv").write_text(csv_text(), encoding="utf-8")
    (tmp_path / "frf" / "b.csv").write_text(csv_text(OTHER), encoding="utf-8")

    def loaded(measured: str) -> Spec:
        (tmp_path / "spec.yaml").write_text(spec_text(measured), encoding="utf-8")
        return load_spec(tmp_path / "spec.yaml")

    return loaded


def table(spec: Spec) -> Table:
    assert spec.uncertainty.table is not None
    return spec.uncertainty.table


def test_the_table_covers_every_sample_and_the_larger_of_two_between(load: Load) -> None:
    points = table(load(WHOLE)).points
    assert [omega for omega, _ in points] == [Fraction(str(f)) * TWO_PI for f in HERTZ]
    delta = [abs(compliance(OTHER, f) / compliance(TRUTH, f) - 1) for f in HERTZ]
    for k, (_, bound) in enumerate(points):
        needed = max(delta[max(k - 1, 0) : k + 2])
        assert needed * (1 - 1e-6) <= float(bound) <= needed * 1.001


def test_the_nominal_load_is_the_specifications(load: Load, tmp_path: Path) -> None:
    before = table(load("{files: frf/a.csv, beyond: hold}"))
    assert max(bound for _, bound in before.points) < Fraction(1, 10**6), "the truth deviates by its last digit"
    text = spec_text("{files: frf/a.csv, beyond: hold}").replace("inertia: 0.05", "inertia: 0.06")
    (tmp_path / "spec.yaml").write_text(text, encoding="utf-8")
    assert max(bound for _, bound in table(load_spec(tmp_path / "spec.yaml")).points) > Fraction("0.15")


def test_the_canonical_form_carries_table_and_digests_and_needs_no_file(load: Load, tmp_path: Path) -> None:
    spec = load(WHOLE)
    document = canonical(spec)
    origin = document["uncertainty"]["table"]["measured"]  # type: ignore[index]
    digest = sha256((tmp_path / "frf" / "a.csv").read_bytes()).hexdigest()
    assert origin["files"][0] == {"name": "frf/a.csv", "sha256": digest}
    assert (origin["records"], origin["excluded"]) == (2, []) and "amplitude" not in origin
    assert from_canonical(json.loads(canonical_json(document))) == spec
    assert spec_sha256(load(WHOLE)) == spec_sha256(spec)
    assert spec_sha256(load("{files: [frf/b.csv, frf/a.csv], beyond: hold}")) != spec_sha256(spec), "another order"
    (tmp_path / "frf" / "a.csv").write_text(csv_text() + "\n", encoding="utf-8")
    assert spec_sha256(load(WHOLE)) != spec_sha256(spec), "other bytes"
    assert table(load(WHOLE)).points == table(spec).points


def test_gain_and_phase_give_the_same_table(load: Load, tmp_path: Path) -> None:
    plain = table(load("{files: frf/b.csv, beyond: hold}")).points
    (tmp_path / "frf" / "b.csv").write_text(polar_text(OTHER), encoding="utf-8")
    polar = table(load("{files: frf/b.csv, beyond: hold}")).points
    for (omega, bound), (other, same) in zip(plain, polar, strict=True):
        assert omega == other and abs(float(bound / same) - 1) < 2e-3


def test_what_holds_outside_of_the_band_is_said(load: Load) -> None:
    held, stated = (table(load(f"{{files: frf/b.csv, beyond: {said}}}")) for said in ("hold", "[0.5, 200 %]"))
    assert [b for _, b in stated.points] == [Fraction(1, 2), *(b for _, b in held.points[1:-1]), 2]
    for said, reason in (
        ("zero", "expected hold or [low, high]; found 'zero'"),
        ("[1]", "expected hold or [low, high]"),
        ("[0.001, 1]", "expected at least the"),
        ("[1, 0]", "that was measured at 125.664 rad/s; found '0'"),
    ):
        with pytest.raises(InputError, match=re.escape(reason)):
            load(f"{{files: frf/b.csv, beyond: {said}}}")
    with pytest.raises(InputError, match=r"measured\.beyond: expected this key; it is missing, and it has no default"):
        load("{files: frf/b.csv}")


def test_a_dead_record_is_an_error_until_it_is_excluded(load: Load, tmp_path: Path) -> None:
    silent = "frequency [Hz],real,imaginary,coherence\n" + "".join(f"{f:g},1e-6,0,0.001\n" for f in HERTZ)
    (tmp_path / "frf" / "c.csv").write_text(silent, encoding="utf-8")
    with pytest.raises(InputError, match=r"the record 'frf/c' is dead: coherence below 0.1 at 7 of 7 points"):
        load(WHOLE)
    for name in ("c", "frf/c", "[frf/c]", '"*c"'):
        origin = table(load(f"{{files: [frf/*.csv], exclude: {name}, beyond: hold}}")).measured
        assert origin is not None and (origin.records, origin.excluded) == (2, ("frf/c",))


def test_the_amplitudes_that_count_are_stated(load: Load, tmp_path: Path) -> None:
    for name, level, truth in (("a", 1, TRUTH), ("b", "0.1", OTHER)):
        rows = csv_text(truth).splitlines()
        text = "\n".join([rows[0] + ",amplitude [N·m]", *(f"{row},{level}" for row in rows[1:])])
        (tmp_path / "frf" / f"{name}.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"taken at amplitudes 0.1 to 1, and friction"):
        load(WHOLE)
    large = table(load("{files: [frf/*.csv], amplitude: [0.5, 1], beyond: hold}"))
    assert max(bound for _, bound in large.points) < Fraction(1, 10**6)
    assert large.measured is not None and (large.measured.records, large.measured.excluded) == (1, ())
    both = table(load("{files: [frf/*.csv], amplitude: [0, 1], beyond: hold}"))
    assert max(bound for _, bound in both.points) > Fraction("0.1")


@pytest.mark.parametrize(
    ("files", "fragment"),
    [
        ("../x.csv", "expected a path below the specification's folder"),
        ("/etc/*", "expected a path below"),
        ("frf/../../*.csv", "expected a path below"),
        ("'**/*.csv'", "without `**`"),
        ("frf", "'frf' is no regular file"),
        ("frf/fifo", "'frf/fifo' is no regular file"),
        ("frf/fif*", "'frf/fifo' is no regular file"),
        ("absent.csv", "does not exist"),
        ("absent/*.csv", "nothing here is named 'absent/*.csv'"),
        ("outside.csv", "this is a link to outside of it"),
        ("out*.csv", "this is a link to outside of it"),
        ("[]", "found an empty list"),
        ("{a: b}", "found a section"),
        ("''", "expected the name of a CSV file; found nothing"),
        ('"nul\\0*.csv"', "nothing here is named"),
        ('"nul\\0.csv"', "cannot be read"),
    ],
)
def test_only_regular_files_inside_the_folder_are_read(load: Load, tmp_path: Path, files: str, fragment: str) -> None:
    (tmp_path.parent / "outside.csv").write_text(csv_text(), encoding="utf-8")
    (tmp_path / "outside.csv").symlink_to(tmp_path.parent / "outside.csv")
    os.mkfifo(tmp_path / "frf" / "fifo")
    with pytest.raises(InputError) as refusal:
        load(f"{{files: {files}, beyond: hold}}")
    where = refusal.value.location
    assert where is not None and (where.file, where.line) == (str(tmp_path / "spec.yaml"), 5)
    assert fragment in refusal.value.message
    assert "\n" not in str(refusal.value)


def test_a_fault_in_a_data_file_is_told_there(load: Load, tmp_path: Path) -> None:
    (tmp_path / "frf" / "b.csv").write_text("omega,real,imaginary\n1,1,0\n2,x,0\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"frf/b\.csv:3: real: expected a number"):
        load(WHOLE)
    (tmp_path / "frf" / "b.csv").write_bytes(b"1" * 1_100_000)
    with pytest.raises(InputError, match=r"b\.csv: expected at most 1000000 bytes"):
        load(WHOLE)
    with pytest.raises(InputError, match="has no folder to look in"):
        parse_spec(spec_text(WHOLE))
    with pytest.raises(InputError, match="expected a table or measured responses"):
        load(WHOLE + ", table: {points: [[1, 1]], beyond: hold}")


def test_what_a_table_says_of_its_origin_is_read_strictly(load: Load) -> None:
    document = canonical(load(WHOLE))
    for key, value in (("sha256", "0" * 63), ("name", ""), ("colour", "red")):
        broken = json.loads(json.dumps(document))
        broken["uncertainty"]["table"]["measured"]["files"][0][key] = value
        with pytest.raises(InputError):
            from_canonical(broken)


def test_data_that_end_below_the_resonance_are_warned_of(load: Load, tmp_path: Path) -> None:
    assert spec_warnings(load(WHOLE)) == ()
    for name in "ab":
        (tmp_path / "frf" / f"{name}.csv").write_text(csv_text(hertz=(0.2, 0.5, 1)), encoding="utf-8")
    (warning,) = spec_warnings(load(WHOLE))
    assert warning.startswith("uncertainty.measured ends at 6.28319 rad/s, below the 1.23 Hz of impedance.stiffness")
    assert "measure up to higher frequencies, or state a bound there with `beyond`" in warning


def test_a_thousand_frequencies_are_enough(load: Load, tmp_path: Path) -> None:
    for k in range(2):
        hertz = [1 + 0.01 * (2 * n + k) for n in range(600)]
        (tmp_path / "frf" / f"{'ab'[k]}.csv").write_text(csv_text(hertz=hertz), encoding="utf-8")
    with pytest.raises(InputError, match="at most 1000 frequencies in all records; found 1200"):
        load(WHOLE)


def test_the_proof_runs_on_the_table_and_tells_when_the_data_change(load: Load, tmp_path: Path) -> None:
    result = synthesize(load(WHOLE))
    assert result.exit_code is ExitCode.PROVEN
    certificate = json.loads(result.certificate_bytes())
    points = certificate["spec"]["uncertainty"]["table"]["points"]
    assert [float(Fraction(a[0])) for a in points] == sorted(float(Fraction(a[0])) for a in points)
    assert all(Fraction(a[0]) < Fraction(b[0]) for a, b in pairwise(points))
    (tmp_path / "c.json").write_bytes(result.certificate_bytes())
    assert check(tmp_path / "c.json").exit_code == 0
    forged = json.loads(result.certificate_bytes())
    forged["spec"]["uncertainty"]["table"]["measured"]["colour"] = "red"
    assert "unknown field 'colour'" in check_bytes(json.dumps(forged).encode()).message
