"""What a terminal shows: honest colours, three lines of Bode plot, plain text in a pipe, nothing rounded upwards."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from rich.cells import cell_len
from rich.console import Console

from robimp.synthesis import Result, synthesize
from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.report.sparkline import BELOW_ZERO, BLOCKS, SPAN, bode_lines
from robimp.synthesis.report.terminal import COLOUR, cells, decimal, show

EXAMPLES = Path(__file__).parents[2] / "examples"
ESCAPE = "\x1b["


@pytest.fixture(scope="module")
def passive() -> Result:
    return synthesize(EXAMPLES / "haninger2016-paper.yaml")


@pytest.fixture(scope="module")
def active() -> Result:
    """Not passive near 51.3 rad/s."""
    return synthesize(EXAMPLES / "haninger2016-stiff.yaml")


def said(result: Result, *, width: int = 100, terminal: bool = False, encoding: str = "utf-8") -> str:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors="backslashreplace")
    colours = "standard" if terminal else "auto"
    show(result, Console(file=stream, width=width, force_terminal=terminal, highlight=False, color_system=colours))  # type: ignore[arg-type]
    stream.flush()
    stream.buffer.seek(0)
    return stream.buffer.read().decode(encoding)  # type: ignore[union-attr]


def bode(result: Result, width: int = 100) -> list[str]:
    console = Console(file=io.StringIO(), width=width)
    lines = bode_lines(
        result.spec, result.coefficients, float(result.omega_B), result.outcome is Outcome.PROVEN, console
    )
    return [line.plain for line in lines]


def test_a_pipe_gets_plain_text(passive: Result) -> None:
    assert ESCAPE not in said(passive) and "PROVEN" in said(passive)
    assert ESCAPE in said(passive, terminal=True), "colours would be seen"


@pytest.mark.parametrize("encoding", ["latin-1", "ascii"])
def test_blocks_are_drawn_only_where_they_can_be_written(passive: Result, encoding: str) -> None:
    assert set(BLOCKS) & set(said(passive))
    plain = said(passive, encoding=encoding)
    assert "PROVEN" in plain and not set(BLOCKS) & set(plain) and "u2588" not in plain


def test_the_plot_has_three_lines_as_wide_as_there_is_room(passive: Result) -> None:
    for width in (60, 80, 100, 200):
        lines = bode(passive, width)
        assert len(lines) == 3
        assert max(map(cell_len, lines)) <= width
        assert len({len(re.findall(rf"[{BLOCKS}]+", line)[0]) for line in lines[:2]}) == 1
    assert bode(passive, 50) == [], "too narrow for a plot"


def test_the_plot_shows_where_the_port_gives_energy_back(passive: Result, active: Result) -> None:
    assert not any(BELOW_ZERO in line for line in bode(passive))
    curve = bode(active)[1][10:66]
    (first, last) = curve.index(BELOW_ZERO), curve.rindex(BELOW_ZERO)
    omega_B, width = float(active.omega_B), len(bode(active)[1][10:].split("  ")[0])
    edges = np.geomspace(omega_B / SPAN, omega_B * SPAN, width + 1)
    assert edges[first] < 51.3 < edges[last + 1], "the witness of (12)"
    assert last - first < width / 4


def test_the_plot_follows_the_curve(passive: Result) -> None:
    left = bode(passive)[0]
    curve = left[left.index("▂") :].split("  ")[0]
    assert "█" in curve and curve[0] == BLOCKS[1], "0.2 of a peak of 1.52 lies in the second eighth"
    assert "0.2 … 1.52" in left
    assert "−0.0" not in left


def test_only_the_proven_band_is_green(passive: Result, active: Result) -> None:
    line = next(line for line in said(passive, terminal=True).splitlines() if line.startswith("|1−"))
    green = line.count(f"{ESCAPE}32m")
    columns = len([c for c in line if c in BLOCKS])
    assert 0.45 * columns < green <= 0.5 * columns, "up to ω_B, the middle of the axis"
    refuted = next(line for line in said(active, terminal=True).splitlines() if line.startswith("|1−"))
    assert f"{ESCAPE}32m" not in refuted


def test_colours_say_what_a_claim_is_worth(active: Result) -> None:
    text = said(active, terminal=True, width=200)
    assert COLOUR == {Outcome.PROVEN: "green", Outcome.REFUTED: "red", Outcome.UNDECIDED: "yellow"}
    required = next(line for line in text.splitlines() if "eq12" in line and "structured" in line)
    assert f"{ESCAPE}31mrefuted" in required
    reported = next(line for line in text.splitlines() if line.startswith("friction"))
    assert f"{ESCAPE}2mrefuted" in reported and f"{ESCAPE}31m" not in reported


def claim(form: str, margin: Fraction) -> Claim:
    return Claim("any", "(1)", form, "", "", (Fraction(0), margin), True, Outcome.PROVEN, margin, None)


def test_what_is_proven_is_rounded_to_where_it_holds() -> None:
    third, more = Fraction(1, 3), Fraction(2, 3)
    assert (decimal(third), decimal(more)) == ("0.333333", "0.666666")
    assert cells(claim("attenuation", more), "rotary")[4] == "ω_B ≥ 0.666666 rad/s"
    assert cells(claim("sensitivity", third), "rotary")[4] == "peak ≤ 0.333334"
    assert cells(claim("attenuation", more), "rotary")[2] == "[0, 0.666666]"
    assert decimal(Fraction(1, 4)) == "0.25", "an exact decimal stays what it is"


def test_an_undecided_result_is_not_called_proven(passive: Result) -> None:
    first, *rest = passive.claims
    text = said(replace(passive, claims=(replace(first, status=Outcome.UNDECIDED), *rest)))
    assert text.startswith("UNDECIDED") and "not proven: stability-free" in text


@pytest.mark.parametrize(("encoding", "blocks"), [(None, True), ("utf-8", True), ("latin-1", False)])
def test_a_command_in_a_pipe_writes_what_was_asked_for(encoding: str | None, blocks: bool, tmp_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONIOENCODING"}
    environment |= {"PYTHONIOENCODING": encoding} if encoding else {}
    script = "from robimp.synthesis.cli import main\nmain()"
    command = [sys.executable, "-c", script, "synth", str(EXAMPLES / "haninger2016-paper.yaml"), "-o", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, env=environment, timeout=120)
    assert (done.returncode, done.stderr) == (0, b"")
    text = done.stdout.decode(encoding or "utf-8")
    assert ESCAPE not in text and bool(set(BLOCKS) & set(text)) == blocks
    assert max(map(cell_len, text.splitlines()[:-1])) <= 160, "but for the paths of the files"
