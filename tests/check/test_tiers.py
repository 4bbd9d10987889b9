"""The checker's two tiers: what the first alone re-proves, that it fits in one sitting, and that the second agrees."""

from __future__ import annotations

import ast
import io
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tokenize
from fractions import Fraction
from math import inf
from pathlib import Path
from time import monotonic
from typing import Any

import pytest
from certificate_builder import EQ23, certificate, data, seal, spec

from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.joint import stiffness
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.polynomials import ONE, ZERO, Poly, limit
from robimp.synthesis.check.positivity import Inequality, counterexample, one_is_positive
from robimp.synthesis.check.reader import read

ROOT = Path(__file__).parents[2]
CHECK = ROOT / "synthesis" / "check"
MOST_LINES = 1000
LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
POLYNOMIAL = ["haninger2016.json", "haninger2016-eq23.json", "hyq-leg.json", "ut-sea.json"]


def code_lines(source: str) -> int:
    """Lines that are not blank, comment or docstring."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    lines = {n for t in tokens if t.type not in LAYOUT for n in range(t.start[0], t.end[0] + 1)}
    for node in ast.walk(ast.parse(source)):
        documented = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node)
        if documented:
            text = node.body[0]  # type: ignore[attr-defined]
            lines -= set(range(text.lineno, text.end_lineno + 1))
    return len(lines)


def lines_of(folder: Path) -> int:
    return sum(code_lines(file.read_text(encoding="utf-8")) for file in folder.glob("*.py"))


def test_lines_of_code_are_counted_without_blank_lines_comments_and_docstrings() -> None:
    source = (
        '"""Module.\n\nTwo lines."""\n\n# why\nx = [\n    1,\n]\n\n\ndef f():\n    """One."""\n    return """a\nb"""\n'
    )
    assert code_lines(source) == 6


def test_what_decides_polynomials_is_read_in_one_sitting() -> None:
    """The README's two figures are those of the files, to ten lines."""
    first, second = lines_of(CHECK), lines_of(CHECK / "enclosure")
    assert 500 < first < MOST_LINES < first + second
    said = [int(n) for n in re.findall(r"\((\d+) lines of code\)", (CHECK / "README.md").read_text(encoding="utf-8"))]
    assert said == pytest.approx([first, second], abs=10)


def late_imports(source: str) -> list[str]:
    """Functions that import the second tier; `module` for what is imported with the file."""
    found = []
    for place in ast.walk(ast.parse(source)):
        if isinstance(place, ast.FunctionDef | ast.Module):
            inside = ast.walk(place) if isinstance(place, ast.FunctionDef) else place.body
            named = [node for node in inside if isinstance(node, ast.ImportFrom) and "enclosure" in (node.module or "")]
            found += [getattr(place, "name", "module")] * len(named)
    return found


def test_the_first_tier_knows_of_the_second_at_one_place() -> None:
    assert late_imports("from .enclosure.forms import Form\ndef f():\n    from .enclosure import x") == ["module", "f"]
    found = {file.name: late_imports(file.read_text(encoding="utf-8")) for file in CHECK.glob("*.py")}
    assert set(found.pop("verdict.py")) == {"_decision", "fault"}  # one inside the other
    assert set(map(len, found.values())) == {0}


def run(folder: Path, *files: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-I", "-S", "-X", "importtime", str(folder), *map(str, files)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=100)


@pytest.fixture(scope="module")
def first_tier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder's own files, and nothing else."""
    folder = tmp_path_factory.mktemp("vendored") / "check"
    folder.mkdir()
    for file in CHECK.glob("*.py"):
        shutil.copy(file, folder)
    return folder


def test_a_certificate_of_polynomials_is_re_proven_by_the_first_tier_alone(first_tier: Path) -> None:
    files = [ROOT / "examples/certificates" / name for name in POLYNOMIAL]
    done = run(first_tier, *files)
    assert done.returncode == 0 and done.stdout.count("PROVEN") == len(files), done.stderr[-300:]
    whole = run(CHECK, *files)
    assert whole.returncode == 0 and "check.positivity" in whole.stderr and "enclosure" not in whole.stderr


def test_a_false_one_is_refused_by_the_first_tier_alone(first_tier: Path) -> None:
    done = run(first_tier, ROOT / "tests/data/must-reject/haninger2016--eq9-raised.json")
    assert (done.returncode, done.stdout) == (4, "")


def test_a_sampled_certificate_needs_the_second_tier_and_gets_it(first_tier: Path) -> None:
    sampled = ROOT / "examples/certificates/haninger2016-sampled.json"
    done = run(CHECK, sampled)
    assert done.returncode == 0 and "enclosure.claims" in done.stderr and "PROVEN" in done.stdout
    alone = run(first_tier, sampled, ROOT / "examples/certificates/haninger2016.json")
    assert alone.returncode == 5 and "needs `enclosure`, which is absent" in alone.stderr
    assert alone.stdout.count("PROVEN") == 1, "what follows is checked all the same"


def test_a_pipe_and_a_forged_line_are_refused(tmp_path: Path) -> None:
    pipe, forged = tmp_path / "pipe", tmp_path / "a\nPROVEN  b.json  x"
    os.mkfifo(pipe)
    shutil.copy(ROOT / "examples/certificates/haninger2016.json", forged)
    done = run(CHECK, pipe, forged)
    assert done.returncode == 2 and "a named pipe, not a file" in done.stderr
    assert done.stdout.count("\n") == 1 and f"PROVEN  {tmp_path}/a\\nPROVEN" in done.stdout


def test_a_tolerance_of_many_coefficients_keeps_to_its_time() -> None:
    """Every pair of coefficients is a joint of its own: thousands, before the first cell."""
    content = read((ROOT / "tests/data/golden/sampled-range.json").read_bytes())
    prover = CellProver(content, monotonic() + 60)
    prover.deadline = monotonic() - 1
    symbols = {("denominator", k): (Fraction(-1), Fraction(1)) for k in range(3)}
    with pytest.raises(CheckError, match="time limit"):
        prover.generators("stability-free", {}, symbols)


def test_no_more_than_64_ranges_are_paired() -> None:
    """Each pair is kept as a polynomial, so what they fill would be as large as the certificate says."""
    prover = CellProver(read((ROOT / "tests/data/golden/sampled-range.json").read_bytes()), monotonic() + 60)
    symbols = {("denominator", k): (Fraction(-1), Fraction(1)) for k in range(65)}
    with pytest.raises(CheckError, match="too many ranges at once") as stop:
        prover.generators("stability-free", {}, symbols)
    assert stop.value.code == 5
    del symbols["denominator", 64]
    prover.deadline = monotonic() - 1
    with pytest.raises(CheckError, match="time limit"):
        prover.generators("stability-free", {}, symbols)


def test_a_limit_is_that_of_the_leading_coefficients() -> None:
    p, q = Poly.of(0, 3, 1, 2), Poly.of(0, 4, 5)
    assert limit(p, q, far=False) == Poly.of(Fraction(3, 4)) and limit(p, q, far=True) is None
    assert limit(q, p, far=True) == ZERO and limit(p, ONE, far=False) == ZERO and limit(ONE, p, far=False) is None
    assert limit(ZERO, q, far=True) == ZERO and limit(p, ZERO, far=False) is None


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([[-1, 1], [2, -1]], True),  # x > 1 or x < 2
        ([[-2, 1], [1, -1]], False),  # neither in [1, 2]
        ([[-1, 1], [1, -1]], False),  # both zero at 1
        ([[1, -2, 1], [1, -1]], False),  # (x − 1)² touches where the other one is zero
        ([[1, -2, 1], [2, -1]], True),
        ([[-1, 1], [0, 0]], False),
        ([[0, 1]], False),  # zero at 0
    ],
)
def test_one_of_several_polynomials_is_positive_everywhere_or_not(rows: list[list[int]], said: bool) -> None:
    assert one_is_positive(rows, (0, 1), (1, 0), monotonic() + 5) == said


def test_three_roots_are_not_decided_by_polynomials() -> None:
    with pytest.raises(CheckError, match="more than two roots"):
        counterexample(Inequality([ONE, ONE, ONE], Poly.of(100)), (0, 1), (1, 0), monotonic() + 5)


SOFT: dict[str, Any] = {
    "plant": {"inertia": "3/100", "damping": "1/5", "stiffness": "10"},
    "uncertainty": {"box": {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["5", "20"]}},
    "constraints": {"eq9": None, "eq12": None, "eq18": None},
}
PI = {"type": "dynamic-feedback", "C": {"numerator": ["2", "30"], "denominator": ["1", "0"]}}
JOINTS = {
    "observer": (spec(constraints=SOFT["constraints"]), EQ23),
    "spring": (spec(**SOFT), EQ23),
    "integral": (spec(**SOFT, controller={"type": "dynamic-feedback"}), PI),
}


def prover_of(name: str) -> CellProver:
    s, controller = JOINTS[name]
    whole = certificate(spec(), EQ23) | {"spec": s, "controller": controller}
    return CellProver(read(data(seal(whole))), monotonic() + 60)


def largest(holds: Any, lo: float = 0.0, hi: float = 64.0) -> float:
    """Where what holds at first stops holding, to 0.1 %."""
    while hi - lo > 1e-3 * hi:
        middle = (lo + hi) / 2
        lo, hi = (middle, hi) if holds(Fraction(middle)) else (lo, middle)
    return lo


def by_cells(prover: CellProver, kind: tuple[str, str], interval: Any, v: Fraction) -> bool:
    try:
        if kind[1] == "box":
            return not prover._box(kind[0], v, {})
        return not prover._on_cells(kind, v, interval, False, None, {}, {})
    except CheckError:  # too close to tell
        return False


@pytest.mark.parametrize("name", JOINTS)
def test_the_widest_box_is_the_same_by_polynomials_and_on_cells(name: str) -> None:
    """And no load in it has a root on the right, while one of a box a little wider than the widest does."""
    prover = prover_of(name)
    widest = largest(lambda v: prover._excluded("stability-free", v))
    assert 1 < widest < 60
    assert by_cells(prover, ("stability-free", "box"), None, Fraction(widest * 0.99))
    assert not by_cells(prover, ("stability-free", "box"), None, Fraction(widest * 1.01))
    plant, box = prover.spec["plant"], prover.spec["uncertainty"]["box"]
    rng = random.Random(name)

    def unstable(v: Fraction, u: list[float]) -> bool:
        point = {}
        for (key, n), share in zip(plant.items(), u, strict=True):
            lo, hi = (n + v * (end - n) for end in box[key])
            point["plant", key] = lo + (hi - lo) * Fraction(share)
        return bool(prover._unstable("stability-free", Fraction(0), point))

    shares = [[rng.choice((0, 1, rng.random())) for _ in plant] for _ in range(60)]
    assert not any(unstable(Fraction(widest), u) for u in shares)
    assert any(unstable(Fraction(widest * 1.3), u) for u in shares)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("spring", ("eq9", "printed")),
        ("spring", ("eq18", "half-plane/physical")),
        ("integral", ("eq18", "half-plane/frozen")),
        ("observer", ("eq9", "printed")),
        ("observer", ("eq12", "paper")),
    ],
)
def test_a_margin_is_the_same_by_polynomials_and_on_cells(name: str, kind: tuple[str, str]) -> None:
    prover = prover_of(name)
    interval: Any = (Fraction(1), Fraction(30)) if kind[0] == "eq12" else (Fraction(0), inf)

    def exactly(v: Fraction) -> bool:
        return super(CellProver, prover).fault(kind, v, interval, False) == ""

    margin = largest(exactly)
    assert 0 < margin < 60
    assert by_cells(prover, kind, interval, Fraction(margin * 0.995))
    assert not by_cells(prover, kind, interval, Fraction(margin * 1.005))


def test_on_the_edge_a_margin_is_smaller_than_at_the_corners() -> None:
    """Without the edge a false claim would pass."""
    s = spec(
        constraints=SOFT["constraints"],
        actuator={"type": "ideal"},
        plant={"inertia": "3/100", "damping": "1/5", "stiffness": "10"},
        uncertainty={"box": {"inertia": ["3/100"] * 2, "damping": ["1/5"] * 2, "stiffness": ["5", "40"]}},
    )
    prover = CellProver(read(data(seal(certificate(spec(), EQ23) | {"spec": s}))), monotonic() + 60)
    kind, band = ("eq9", "printed"), (Fraction(24), Fraction(26))
    corners = largest(lambda v: prover._statement(kind, v, band, False, None, {}) == "")
    edge = largest(lambda v: super(CellProver, prover).fault(kind, v, band, False) == "")
    assert edge < 0.9 * corners
    between = Fraction((edge + corners) / 2)
    assert super(CellProver, prover).fault(kind, between, band, False) is None, "handed over"
    assert prover.fault(kind, between, band, False) != ""
    loads = [stiffness((Fraction(3, 100), Fraction(1, 5), Fraction(5 + k, 1))) for k in range(36)]
    at = [prover._statement(kind, Fraction(edge * 0.99), band, False, load, {}) for load in loads]
    assert not any(at) and math.isfinite(edge)
    assert any(prover._statement(kind, Fraction(edge * 1.02), band, False, load, {}) for load in loads)
