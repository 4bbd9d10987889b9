"""The C code: compiled as strictly as compilers can, against the simulator's sections and against the law's text."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from export_joints import IDEAL, JOINT, Drive, law_of, replaced, setting_of

from robimp.synthesis.export.carried import Carried
from robimp.synthesis.export.sections import DTYPE
from robimp.synthesis.export.targets import Subject, document, files_of
from robimp.synthesis.simulation.sections import run

COMPILER = shutil.which("gcc") or shutil.which("cc")
CPP = shutil.which("g++") or shutil.which("c++")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler here (gcc or cc)")
STRICT = ["-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic", "-O2", "-ffp-contract=off"]
SAMPLES = 1_000_000
ORDER_4 = "{type: dob, coefficients: {numerator: [248560, 7434300, 559805000], "
ORDER_4 += "denominator: [1, 6040.7, 446499, 17739500, 774656000]}}"
PAPER = "{type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}"
EVERY_FILTER = (
    "{type: dynamic-feedback, coefficients: {numerator: [1, 90, 2000], denominator: [1, 40, 0]},"
    " filters: {force: 300, position: 500, derivative: 900}}"
)
JOINTS = {
    "order 4": replaced(JOINT, (PAPER, ORDER_4)),
    "every filter": replaced(JOINT, (PAPER, EVERY_FILTER)),
    "a gain alone": replaced(
        JOINT, (PAPER, "{type: dynamic-feedback, coefficients: {numerator: [2.5], denominator: [1]}}")
    ),
    "filters around a gain of 1": replaced(
        JOINT,
        (
            PAPER,
            "{type: dynamic-feedback, coefficients: {numerator: [1], denominator: [1]},"
            " filters: {force: 1000, position: none, derivative: 1000}}",
        ),
    ),
    "range": replaced(JOINT, ("stiffness: 1.25}", "stiffness: [0.2, 10]}")),
    "another inertia": replaced(JOINT, ("{inertia: nominal,", "{inertia: 0.04,")),
}
FILTERS = [
    "",
    *(
        f", filters: {{force: 400{p}{d}}}"
        for p in ("", ", position: none", ", position: 500")
        for d in ("", ", derivative: 700")
    ),
]
STRUCTURES = [PAPER, ORDER_4] + [
    f"{{type: dynamic-feedback, coefficients: {{numerator: {num}, denominator: {den}}}{filters}}}"
    for num, den in (("[1]", "[1]"), ("[2.5]", "[1]"), ("[1, 90, 2000]", "[1, 40, 0]"))
    for filters in FILTERS
]
STIFFNESSES = ("1.25", "[0.2, 10]")
HARNESS = """
#include "joint.c"
#include <stdio.h>
#include <math.h>
int main(void) { %s return 0; }
"""
READ = "real x[2]; joint c; if (joint_init(&c, 1000.0, HUGE_VAL) != JOINT_OK) return 1; "
CASCADE = "real x; static real z[9][2]; while (fread(&x, sizeof x, 1, stdin)) "
CASCADE += "{ x = filtered(COMPENSATOR, z, %d, x); fwrite(&x, sizeof x, 1, stdout); }"
STEPS = "while (fread(x, sizeof x, 1, stdin)) { x[0] = joint_step(&c, x[0], x[1]); fwrite(x, sizeof x[0], 1, stdout); }"


@dataclass(frozen=True)
class Built:
    """An export in a folder."""

    folder: Path
    subject: Subject

    @property
    def number(self) -> type:
        return np.float64 if self.subject.law.precision == "double" else np.float32

    def run(self, body: str, samples: np.ndarray, *options: str) -> np.ndarray:
        """What a `main` with this body writes for these samples."""
        (self.folder / "main.c").write_text(HARNESS % body, encoding="utf-8")
        made = self.compiled("main.c", *options, "-lm", "-o", "main")
        assert made.returncode == 0, made.stderr
        data = np.ascontiguousarray(samples, dtype=self.number).tobytes()
        done = subprocess.run([self.folder / "main"], input=data, capture_output=True, check=True)
        return np.frombuffer(done.stdout, dtype=self.number)

    def compiled(self, source: str, *options: str) -> subprocess.CompletedProcess[str]:
        assert COMPILER is not None
        return subprocess.run(
            [COMPILER, *STRICT, source, *options], cwd=self.folder, capture_output=True, text=True, check=False
        )

    def header_in_cpp(self, header: str) -> subprocess.CompletedProcess[str]:
        """A C++ translation unit with this header alone; where there is no C++ compiler, C has to do."""
        (self.folder / "main.cpp").write_text(f'#include "{header}"\n', encoding="utf-8")
        command = [CPP, "-std=c++98"] if CPP else [str(COMPILER), "-x", "c", "-std=c99"]
        return subprocess.run(
            [*command, "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only", "main.cpp"],
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
        )

    @property
    def law(self) -> Drive:
        return Drive(document(self.subject), self.number)


def built(folder: Path, text: str, precision: str = "double", name: str = "joint") -> Built:
    setting = setting_of(text)
    setting = replace(setting, spec=setting.spec.model_copy(update={"name": name}))
    claim = Carried("eq12", "structured", True, None, None, "a note with */ in it")
    subject = Subject(setting, law_of(setting, precision, 20.0), (claim,), "c0ffee", "5bec", False, "0")
    for file, content in files_of(subject, "c").items():
        (folder / file).write_text(content, encoding="utf-8")
    return Built(folder, subject)


def ulps(a: np.ndarray, b: np.ndarray) -> int:
    """Largest distance in units of the last place."""
    kind = np.int64 if a.dtype == np.float64 else np.int32
    x, y = (np.where(v < 0, np.iinfo(kind).min - v, v) for v in (a.view(kind), b.view(kind)))
    return int(np.abs(x.astype(object) - y.astype(object)).max()) if (x != y).any() else 0


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["order 4", "every filter"])
def test_sections_give_the_simulators_bits(tmp_path: Path, name: str, precision: str) -> None:
    """A million samples of noise; asked for are 4 units in the last place."""
    made = built(tmp_path, JOINTS[name], precision)
    noise = np.random.default_rng(1).standard_normal(SAMPLES).astype(made.number)
    cascade = made.subject.law.compensator
    out = made.run(CASCADE % len(cascade.sections), noise)
    expected = run(cascade.sos, noise, made.number)
    assert out.size == SAMPLES
    assert ulps(out, expected) == 0
    off = cascade.sos.copy()
    off[0, 4] = np.nextafter(off[0, 4], 0) if precision == "double" else np.nextafter(np.float32(off[0, 4]), 0)
    assert ulps(out, run(off, noise, made.number)) > 4, "the control: one coefficient off by one unit"


def test_single_precision_stays_near_double(tmp_path: Path) -> None:
    """Coefficients and arithmetic together; what the claims cover are the coefficients."""
    noise = np.random.default_rng(2).standard_normal(SAMPLES // 10)
    outputs = []
    for precision in ("double", "float"):
        made = built(tmp_path, JOINTS["order 4"], precision)
        outputs.append(made.run(CASCADE % len(made.subject.law.compensator.sections), noise).astype(float))
    error = np.std(outputs[1] - outputs[0]) / np.std(outputs[0])
    assert 1e-9 < error < 2e-4


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", JOINTS)
def test_a_step_is_the_law_as_its_text_says(tmp_path: Path, name: str, precision: str) -> None:
    made = built(tmp_path, JOINTS[name], precision)
    samples = np.random.default_rng(3).standard_normal((3000, 2)).astype(made.number)
    out = made.run(READ + STEPS, samples)
    law = made.law
    assert ulps(out, np.array([law.step(*sample) for sample in samples], dtype=made.number)) <= 4


def test_other_rates_are_refused_at_start_and_at_compile_time(tmp_path: Path) -> None:
    made = built(tmp_path, JOINT)
    body = """joint c; real r[5];
        r[0] = joint_init(&c, 1000.0, 5) == JOINT_OK; r[1] = joint_init(&c, 999.999, 5) == JOINT_WRONG_RATE;
        r[2] = joint_init(&c, 1e3 + 1e-9, 5) == JOINT_WRONG_RATE;
        r[3] = joint_init(&c, 0.0 / 0.0, 5) == JOINT_WRONG_RATE;
        r[4] = joint_init(&c, 1000.0, 0) == JOINT_BAD_LIMIT && joint_init(&c, 1000.0, 0.0 / 0.0) == JOINT_BAD_LIMIT;
        fwrite(r, sizeof r[0], 5, stdout);"""
    assert made.run(body, np.zeros(1)).tolist() == [1] * 5
    right = made.compiled("joint.c", "-c", "-DROBIMP_RATE_MILLIHZ=1000000")
    wrong = made.compiled("joint.c", "-c", "-DROBIMP_RATE_MILLIHZ=500000")
    assert right.returncode == 0, right.stderr
    assert wrong.returncode != 0
    assert "certified at 1000 Hz" in wrong.stderr


def test_halves_of_two_exports_do_not_compile(tmp_path: Path) -> None:
    made = built(tmp_path, JOINT)
    source = (tmp_path / "joint.c").read_bytes()
    built(tmp_path, JOINTS["order 4"])
    assert made.compiled("joint.c", "-c").returncode == 0
    (tmp_path / "joint.c").write_bytes(source)
    assert "two different exports" in made.compiled("joint.c", "-c").stderr


def test_a_lost_claim_is_a_macro_and_a_note_of_the_compiler(tmp_path: Path) -> None:
    """A note, for under -Werror a warning would forbid what --force was asked to allow."""
    made = built(tmp_path, JOINT)
    done = made.compiled("joint.c", "-c")
    assert done.returncode == 0
    assert "NOT PROVEN: eq12 structured not re-proven" in done.stderr
    body = "double lost = JOINT_NOT_PROVEN; fwrite(&lost, sizeof lost, 1, stdout);"
    assert made.run(body, np.zeros(1)).tolist() == [1]
    proven = replace(made.subject, carried=())
    for file, content in files_of(proven, "c").items():
        (tmp_path / file).write_text(content, encoding="utf-8")
    assert made.compiled("joint.c", "-c").stderr == ""
    assert "NOT_PROVEN" not in (tmp_path / "joint.h").read_text(encoding="utf-8")


def test_reset_starts_again(tmp_path: Path) -> None:
    made = built(tmp_path, JOINTS["every filter"])
    samples = np.random.default_rng(4).standard_normal((200, 2))
    twice = np.vstack([samples, samples])
    again = made.run(READ + "int k = 0; " + STEPS.replace("{ x[0]", "{ if (k++ == 200) joint_reset(&c); x[0]"), twice)
    through = made.run(READ + STEPS, twice)
    assert (again[:200] == again[200:]).all()
    assert not (through[:200] == through[200:]).all()


@pytest.mark.parametrize("name", ["order 4", "every filter", "range", "another inertia"])
def test_starts_under_a_torque_without_a_jump(tmp_path: Path, name: str) -> None:
    """With the same readings the first command is the torque of the start; from reset it is not."""
    made = built(tmp_path, JOINTS[name])
    samples = np.tile([0.3, 0.2], (3, 1))
    smooth = made.run(READ + "joint_bumpless(&c, 1.5, 0.3, 0.2); " + STEPS, samples)
    assert smooth[0] == pytest.approx(1.5, abs=1e-12)
    assert abs(made.run(READ + STEPS, samples)[0] - 1.5) > 0.1


def test_an_integrator_holds_a_bumpless_start(tmp_path: Path) -> None:
    """Without error: θ = 0, τ_int = 0, no inner compensation."""
    made = built(tmp_path, JOINTS["every filter"])
    held = made.run(READ + "joint_bumpless(&c, 1.5, 0, 0); " + STEPS, np.zeros((1000, 2)))
    assert np.abs(held - 1.5).max() < 1e-12


def test_back_calculation_ends_windup(tmp_path: Path) -> None:
    """Ten seconds beyond the limit, then the error changes sign: off the limit in ticks, not seconds."""
    made = built(tmp_path, JOINTS["every filter"])
    samples = np.zeros((11_000, 2))
    samples[:10_000, 0], samples[10_000:, 0] = 2.0, -0.2
    limited = READ.replace("HUGE_VAL", "1.0")
    out = made.run(limited + STEPS, samples)
    assert np.abs(out).max() <= 1.0
    assert out[9_999] == 1.0
    left = int(np.argmax(out[10_000:] < 1.0))
    assert left < 200
    frozen = STEPS.replace("{ x[0]", "{ c.excess = 0; x[0]")
    assert (made.run(limited + frozen, samples)[10_000:] == 1.0).all(), "the control: without it, seconds"


def test_only_certified_impedances_are_accepted(tmp_path: Path) -> None:
    made = built(tmp_path, JOINTS["range"])
    body = """joint c; real r[5]; joint_init(&c, 1000.0, 5);
        r[0] = joint_set_impedance(&c, c.inertia, c.damping, 0.2) == JOINT_OK;
        r[1] = joint_set_impedance(&c, c.inertia, c.damping, 10) == JOINT_OK && c.stiffness == 10;
        r[2] = joint_set_impedance(&c, c.inertia, c.damping, (real)10.01) == JOINT_OUTSIDE && c.stiffness == 10;
        r[3] = joint_set_impedance(&c, c.inertia, c.damping * 2, 5) == JOINT_OUTSIDE;
        r[4] = joint_set_impedance(&c, c.inertia, c.damping, (real)(0.0 / 0.0)) == JOINT_OUTSIDE;
        fwrite(r, sizeof r[0], 5, stdout);"""
    assert made.run(body, np.zeros(1)).tolist() == [1] * 5


@pytest.mark.parametrize("precision", DTYPE)
@pytest.mark.parametrize("ends", ["[0.7, 1.25]", "[0.1, 0.3]", "[1/3, 2/3]", "[0.2, 10]"])
def test_no_number_outside_the_certified_range_is_accepted(tmp_path: Path, ends: str, precision: str) -> None:
    """The numbers of the code's arithmetic on both sides of each end, against the exact end."""
    made = built(tmp_path, replaced(JOINT, ("stiffness: 1.25}", f"stiffness: {ends}}}")), precision)
    low, high = (Fraction(end) for end in ends.strip("[]").split(", "))
    near = [made.number(float(end)) for end in (low, high)]
    tried = [np.nextafter(x, made.number(to)) for x in near for to in (-np.inf, np.inf)] + near
    body = READ + "while (fread(x, sizeof x[0], 1, stdin)) "
    body += (
        "{ x[0] = joint_set_impedance(&c, c.inertia, c.damping, x[0]) == JOINT_OK; fwrite(x, sizeof x[0], 1, stdout); }"
    )
    expected = [float(low <= Fraction(float(x)) <= high) for x in tried]
    assert made.run(body, np.array(tried)).tolist() == expected
    assert 0 in expected
    assert 1 in expected


@pytest.mark.parametrize("base", [JOINT, IDEAL], ids=["series-elastic", "ideal"])
def test_every_structure_compiles_as_c_and_its_header_as_cpp(tmp_path: Path, base: str) -> None:
    """Gains, filters here and there, observers; in turn both precisions, with and without a range."""
    for structure, precision, stiffness in zip(STRUCTURES, cycle(DTYPE), cycle(STIFFNESSES[:1] * 2 + STIFFNESSES[1:])):
        made = built(tmp_path, replaced(base, (PAPER, structure), ("1.25", stiffness)), precision)
        for done in (made.compiled("joint.c", "-O0", "-c"), made.header_in_cpp("joint.h")):
            assert done.returncode == 0, f"{structure}: {done.stderr}"
    broken = (tmp_path / "joint.c").read_text(encoding="utf-8") + "static void unused(void) {}\n"
    (tmp_path / "joint.c").write_text(broken, encoding="utf-8")
    assert "defined but not used" in made.compiled("joint.c", "-O0", "-c").stderr, "the control"


@pytest.mark.parametrize(
    ("name", "identifier"),
    [
        ("ur5-wrist", "ur5_wrist"),
        ("UR5", "ur5"),
        ("4th", "joint_4th"),
        ("épaule", "epaule"),
        ("手首", "joint_b8222245"),
        ("x" * 300, "x" * 31 + "_0d4e2ca9"),
        ("size_t", "joint_size_t"),
        ("*/ #error \\", "error"),
        *(
            (taken, f"joint_{taken}")
            for taken in ("double", "true", "bool", "new", "int", "stdio", "sin", "c", "linux")
        ),
    ],
)
def test_every_name_of_a_joint_compiles_in_c_and_cpp(tmp_path: Path, name: str, identifier: str) -> None:
    made = built(tmp_path, JOINT, name=name)
    assert {file.name for file in tmp_path.iterdir()} == {"export.json", f"{identifier}.c", f"{identifier}.h"}
    for done in (made.compiled(f"{identifier}.c", "-c"), made.header_in_cpp(f"{identifier}.h")):
        assert done.returncode == 0, done.stderr
    wrong = made.compiled(f"{identifier}.c", "-c", "-DROBIMP_RATE_MILLIHZ=1")
    assert "this control loop runs at another rate" in wrong.stderr
    assert json.loads((tmp_path / "export.json").read_bytes())["name"] == name
    assert "c0ffee" in (tmp_path / f"{identifier}.h").read_text(encoding="utf-8")
