"""`robimp identify`, as its user sees it: files in, a specification out that the other commands accept."""

from __future__ import annotations

import json
import runpy
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from command_line import refused, robimp
from identify_data import HERTZ, TRUTH, compliance, csv_text

from robimp.synthesis import ExitCode, load, synthesize
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.simulation import Load, assemble
from robimp.synthesis.spec import Spec, canonical
from robimp.synthesis.spec.load import build_spec
from robimp.synthesis.spec.reader import read_tree

EXAMPLE = Path(__file__).parents[2] / "examples" / "measured"
LOADS = (TRUTH, (0.055, 0.33, 2.1), (0.045, 0.27, 1.9))


@pytest.fixture
def sweeps(tmp_path: Path) -> list[Path]:
    """Three sweeps of three loads and a dead one."""
    for k, truth in enumerate(LOADS):
        (tmp_path / f"s{k}.csv").write_text(csv_text(truth), encoding="utf-8")
    (tmp_path / "dead.csv").write_text(csv_text(scale=1e-4), encoding="utf-8")
    return sorted(tmp_path.glob("*.csv"))


def test_the_written_specification_is_accepted_and_covers_the_truth(sweeps: list[Path], tmp_path: Path) -> None:
    run = robimp("identify", *sweeps, "--beyond", "hold", "-o", tmp_path / "joint.yaml")
    assert run.code == 0
    assert run.err == "left out: dead: dead: gain below 0.05 of the other records' at 7 of 7 points\n"
    assert run.out.startswith("IDENTIFIED  load from 3 records; 1 left out\nnominal: inertia 0.0")
    text = (tmp_path / "joint.yaml").read_text(encoding="utf-8")
    assert "#   left out: dead: dead: gain" in text and "NOT MEASURED" in text
    plant_lines = text[text.index("plant:") : text.index("uncertainty:")].split()
    assert plant_lines.count("#") == 4, "every number says where it is from, or its unit"
    spec = load(tmp_path / "joint.yaml")
    plant = tuple(float(v) for v in (spec.plant.inertia, spec.plant.damping, spec.plant.stiffness))
    for truth in LOADS:
        delta = [abs(compliance(truth, f) / compliance(plant, f) - 1) for f in HERTZ]
        assert (delta <= gain(spec)).all()


def test_a_file_name_cannot_write_into_the_specification(sweeps: list[Path], tmp_path: Path) -> None:
    odd = tmp_path / "s\nplant: {}.csv"
    sweeps[1].rename(odd)
    run = robimp("identify", odd, *sweeps[2:], "--beyond", "hold", "-o", tmp_path / "joint.yaml")
    assert run.code == 0
    text = (tmp_path / "joint.yaml").read_text(encoding="utf-8")
    assert "#   kept: s?plant: {}\n" in text and text.count("\nplant:") == 1


def test_json_says_the_same(sweeps: list[Path]) -> None:
    run = robimp("identify", *sweeps, "--beyond", "hold", "--json", "--order", "0")
    found = json.loads(run.out)
    assert found["kept"] == ["s0", "s1", "s2"] and list(found["left_out"]) == ["dead"] and found["file"] is None
    assert [Fraction(c) for c in found["weight"]["denominator"]] == [1]
    assert max(found["from_nominal"]) == pytest.approx(float(Fraction(found["weight"]["numerator"][0])), rel=1e-3)
    assert len(found["omega"]) == len(HERTZ) and max(found["from_mean"]) < 0.5


def test_a_base_lends_its_other_sections_and_loses_nothing_silently(sweeps: list[Path], tmp_path: Path) -> None:
    base = (EXAMPLE / "wishes.yaml").read_text(encoding="utf-8")
    (tmp_path / "base.yaml").write_text(base, encoding="utf-8")
    arguments = (
        "identify",
        *sweeps,
        "--beyond",
        "0.5:1",
        "--base",
        tmp_path / "base.yaml",
        "-o",
        tmp_path / "new.yaml",
    )
    assert robimp(*arguments).code == 0
    written = (tmp_path / "new.yaml").read_text(encoding="utf-8")
    new, document = load(tmp_path / "new.yaml"), canonical(load(EXAMPLE / "joint.yaml"))
    for key in ("name", "actuator", "controller", "objective", "constraints"):
        assert canonical(new)[key] == document[key]
    assert "motor behind a spring" in written and "replaced by what is measured" not in written
    for section, key in (("{actuator: {motor_inertia: ±10 %}}", "uncertainty.actuator"),):
        (tmp_path / "base.yaml").write_text(
            base.replace("uncertainty: {}", f"uncertainty: {section}"), encoding="utf-8"
        )
        assert f"{key}: would be lost" in refused_after_notes(*arguments)
    (tmp_path / "base.yaml").write_text("{robimp: 1, name: x}", encoding="utf-8")
    assert "begin at the left margin" in refused_after_notes(*arguments)
    assert (tmp_path / "new.yaml").read_text(encoding="utf-8") == written, "a refusal leaves what is there"


def refused_after_notes(*arguments: str | Path) -> str:
    """The last line of a refusal, after notes on records left out."""
    run = robimp(*arguments)
    assert run.code == ExitCode.INPUT and run.out == ""
    return run.err.splitlines()[-1]


def test_a_locked_actuator_becomes_a_two_port(tmp_path: Path) -> None:
    s = [2j * 3.141592653589793 * f for f in HERTZ]
    for k, natural in enumerate((900, 1000, 1100)):
        H = [natural / (z * z + 20 * z + natural) for z in s]
        rows = "".join(f"{f:g},{h.real:.6g},{h.imag:.6g}\n" for f, h in zip(HERTZ, H, strict=True))
        (tmp_path / f"h{k}.csv").write_text("frequency [Hz],real,imaginary\n" + rows, encoding="utf-8")
    files = sorted(tmp_path.glob("h*.csv"))
    options = ("--of", "actuator", "--poles", "2", "--zeros", "0", "--beyond", "hold")
    run = robimp("identify", *files, *options)
    assert run.code == 0 and "minimum phase True" in run.out
    base, out = ("--base", EXAMPLE / "joint.yaml"), ("-o", tmp_path / "new.yaml")
    assert "give the spring's stiffness" in refused(ExitCode.INPUT, "identify", *files, *options, *base, *out)
    says = refused(ExitCode.INPUT, "identify", *files, *options, "--spring", "4.8", *out)
    assert "the load is not known" in says and not (tmp_path / "new.yaml").exists()
    assert robimp("identify", *files, *options, "--spring", "4.8", *base, *out).code == 0
    spec = load(tmp_path / "new.yaml")
    assert spec.actuator.type == "two-port"
    assert spec.actuator.impedance.numerator[0] == Fraction("4.8") and spec.actuator.impedance.numerator[-1] == 0
    assert "NOT COVERED by any claim" in (tmp_path / "new.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize("what", ["load", "actuator"])
def test_a_record_of_nothing_is_dead_even_if_it_is_the_only_one(what: str, tmp_path: Path) -> None:
    (tmp_path / "zero.csv").write_text("frequency [Hz],real,imaginary\n1,0,0\n2,0,0\n3,0,0\n", encoding="utf-8")
    says = refused(ExitCode.INPUT, "identify", tmp_path / "zero.csv", "--of", what, "--beyond", "hold")
    assert "'zero', 'dead: gain 0 at 3 of 3 points'" in says


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((), "--beyond: expected this option, for nothing was measured outside of the band"),
        (("--beyond", "zero"), "--beyond: expected LOW:HIGH, such as 1:5; found 'zero'"),
        (("--beyond", "0:0"), "beyond: expected at least the"),
        (("--beyond", "nan:1"), "--beyond: expected a number; found 'nan'"),
        (("--beyond", "hold", "--amplitude", "5"), "--amplitude: expected LOW:HIGH"),
        (("--beyond", "hold", "--amplitude", "-1:5"), "--amplitude: expected a number ≥ 0"),
        (("--beyond", "hold", "--of", "motor"), "--of: expected load or actuator; found 'motor'"),
        (("--beyond", "hold", "--motion", "curly"), "--motion: expected rotary or linear"),
        (("--beyond", "hold", "--exclude", "nobody"), "'nobody' matches none"),
        (("--beyond", "hold", "--order", "9"), "order of the weight from 0 to 6; found 9"),
        (("--beyond", "hold", "-o", "/dev/null"), "no ordinary file"),
    ],
)
def test_what_the_options_cannot_mean_is_refused(options: tuple[str, ...], says: str, sweeps: list[Path]) -> None:
    assert says in refused(ExitCode.INPUT, "identify", *sweeps[1:], *options)


def gain(spec: Spec, hertz: Sequence[float] = HERTZ) -> np.ndarray:
    """`|W|` of a specification, (n,)."""
    weight, s = spec.uncertainty.weight, 2j * np.pi * np.asarray(hertz)
    assert weight is not None and spec.uncertainty.table is None
    N, D = (np.polyval([float(c) for c in part], s) for part in (weight.numerator, weight.denominator))
    return abs(N / D)


class TestExample:
    """examples/measured: sweeps from the simulator, what is identified from them, and a proof."""

    def test_the_sweeps_are_the_simulators(self) -> None:
        sweeps = runpy.run_path(str(EXAMPLE / "measure.py"))["sweeps"]()
        assert sorted(sweeps) == sorted(path.name for path in (EXAMPLE / "frf").iterdir())
        for name, text in sweeps.items():
            kept = (EXAMPLE / "frf" / name).read_text(encoding="utf-8").splitlines()
            for one, other in zip(text.splitlines()[1:], kept[1:], strict=True):
                numbers = [[float(cell) for cell in row.split(",")] for row in (one, other)]
                assert numbers[0] == pytest.approx(numbers[1], rel=1e-3, abs=1e-8)

    def test_the_specification_is_what_is_identified(self, tmp_path: Path) -> None:
        out = tmp_path / "joint.yaml"
        options = ("--amplitude", "1:2", "--beyond", "0.3:0.5", "--base", EXAMPLE / "wishes.yaml", "-o", out)
        run = robimp("identify", *sorted((EXAMPLE / "frf").glob("*.csv")), *options)
        assert run.code == 0 and "unplugged: dead: coherence below 0.1 at 15 of 15 points" in run.err
        assert "1 left out, 1 of other amplitudes" in run.out
        for key in ("inertia", "damping", "stiffness"):
            kept, found = (float(getattr(load(path).plant, key)) for path in (EXAMPLE / "joint.yaml", out))
            assert found == pytest.approx(kept, rel=1e-3)
        kept_gain, found_gain = (gain(load(path)) for path in (EXAMPLE / "joint.yaml", out))
        assert found_gain == pytest.approx(kept_gain, rel=0.05)

    def test_the_identified_joint_covers_the_truth_and_is_proven(self) -> None:
        spec = load(EXAMPLE / "joint.yaml")
        result = synthesize(spec)
        assert result.exit_code is ExitCode.PROVEN
        assert 95 < result.omega_B < 105
        C = result.certificate["controller"]["C"]
        compensator = tuple(tuple(Fraction(c) for c in C[part]) for part in ("numerator", "denominator"))
        plant = spec.plant
        nominal = (float(plant.inertia), float(plant.damping), float(plant.stiffness))
        hertz = np.geomspace(0.2, 28, 1001)
        for amplitude, truth in runpy.run_path(str(EXAMPLE / "measure.py"))["LOADS"].values():
            delta = np.array([compliance(truth, f) / compliance(nominal, f) - 1 for f in hertz])
            covered = bool((abs(delta) <= gain(spec, hertz)).all())
            assert covered == (amplitude >= 1), (
                "also between the measured frequencies; the small sweep is another joint"
            )
            joint = assemble(spec, (compensator[0], compensator[1]), Load(*(Fraction(str(value)) for value in truth)))
            assert joint.poles.stable or not covered

    def test_the_same_controller_is_proven_against_the_responses_themselves(self) -> None:
        result = synthesize(load(EXAMPLE / "measured.yaml"))
        assert result.exit_code is ExitCode.PROVEN and result.robust
        assert 98 < result.omega_B < 99

    def test_with_the_sweep_at_a_small_amplitude_it_is_refuted(self) -> None:
        """A negative control: friction at 0.2 N·m makes another joint of it, and the same controller fails (18)."""
        text = (EXAMPLE / "measured.yaml").read_text(encoding="utf-8")
        text = text.replace("[1, 2] ", "[0.1, 2] ").replace("beyond: [0.3, 0.5]", "beyond: hold")
        spec = build_spec(read_tree(text.encode(), "all-amplitudes.yaml"), EXAMPLE)
        result = synthesize(spec)
        assert result.exit_code is ExitCode.REFUTED
        assert [claim.id for claim in result.claims if claim.status is Outcome.REFUTED and claim.required] == ["eq18"]
