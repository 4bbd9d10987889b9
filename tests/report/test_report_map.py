"""The page about a map: every cell at its place, in its colour, with its reason; and what is refused as no map."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from command_line import refused, robimp
from report_pages import PAPER, Page
from test_report_browser import BROWSER, DARK, DARK_PAGE, seen

from robimp.synthesis.errors import ExitCode, InputError
from robimp.synthesis.report.html.map_page import map_page
from robimp.synthesis.report.html.recorded import RecordedMap
from robimp.synthesis.report.html.words import floor
from robimp.synthesis.sweep.axis import Axis
from robimp.synthesis.sweep.cell import Cell, Status
from robimp.synthesis.sweep.plane import Plane
from robimp.synthesis.sweep.result import Map

EXAMPLE = Path(__file__).parents[2] / "examples" / "haninger2016-paper.yaml"
AXES = Axis.parse("impedance.stiffness", "1:9:2"), Axis.parse("impedance.damping", "0.2:0.8:4:log")
LARGEST = Fraction(88757169, 10**7)  # 8.8757169: six digits would round it up
CELLS = {
    (0, 0): Cell((0, 0), Status.INFEASIBLE, None, "(12) structured", "asked: <b>more</b> & than any controller can"),
    (0, 1): Cell((0, 1), Status.PROVEN, Fraction(5)),
    (0, 2): Cell((0, 2), Status.PROVEN, Fraction(6)),
    (0, 3): Cell((0, 3), Status.PROVEN, LARGEST),
    (1, 0): Cell((1, 0), Status.REFUTED, None, "eq12", "not proven: eq12 structured"),
    (1, 1): Cell((1, 1), Status.REFUTED, None, "eq12", "not proven: eq12 structured"),
    (1, 2): Cell((1, 2), Status.UNDECIDED, None, "undecided", "no controller of this structure was found"),
    (1, 3): Cell((1, 3), Status.PROVEN, Fraction(7)),
}


@cache
def document() -> bytes:
    """What `robimp map` writes."""
    return json.dumps(Map(Plane.of(EXAMPLE, AXES), CELLS).to_json()).encode()


def changed(change: Callable[[dict[str, Any]], object]) -> bytes:
    content = json.loads(document())
    change(content)
    return json.dumps(content).encode()


def html(data: bytes) -> str:
    return map_page(RecordedMap.of("map.json", data))


def test_every_cell_stands_at_its_place() -> None:
    page = Page(html(document()))
    proven, failed, *signs = page.figures[0]["traces"]
    assert proven["z"] == [[None, 5.0, 6.0, 8.8757], [None, None, None, 7.0]]
    assert failed["z"] == [[0.0, None, None, None], [0.0, 0.0, 1.0, None]]
    assert (len(proven["x"]), len(proven["y"])) == (5, 3), "borders of the cells, one more than cells"
    for axis, edges in zip(AXES, (proven["y"], proven["x"]), strict=True):
        assert all(low < value < high for low, value, high in zip(edges, axis.floats, edges[1:], strict=False))
    assert {(sign["name"], *zip(sign["y"], sign["x"], strict=True)) for sign in signs} == {
        ("refuted: eq12 (2)", (9.0, 0.2), (9.0, float(AXES[1].floats[1]))),
        ("infeasible: (12) structured (1)", (1.0, 0.2)),
        ("undecided (1)", (9.0, float(AXES[1].floats[2]))),
    }


def test_cells_of_one_bandwidth_are_told_apart_and_so_are_cuts_that_coincide() -> None:
    picture, cuts = Page(html(document())).figures
    assert all(trace["xgap"] == trace["ygap"] == 1 for trace in picture["traces"][:2])
    assert [trace["line"]["dash"] for trace in cuts["traces"]] == ["solid", "dash"]


def test_a_cell_says_its_values_and_its_reason_on_hover() -> None:
    said = Page(html(document())).figures[0]["traces"][0]["hovertext"]
    assert said[0][3] == "impedance.stiffness 1, impedance.damping 0.8<br>ω_B ≥ 8.87571 rad/s"
    assert "refuted: not proven: eq12 structured" in said[1][1]
    assert "‹b›more‹/b›" in said[0][0], "what looks like a mark of the plotting library is none"


def test_a_bandwidth_is_never_rounded_up() -> None:
    page = Page(html(document()))
    assert "ω_B ≥ 8.87571 rad/s" in page.said and "8.87572" not in page.text
    for value in (LARGEST, Fraction(1, 3), Fraction(2, 3), Fraction(10**9 - 1, 7)):
        assert 0 <= value - Fraction(floor(value)) < value / 10**5


def test_the_page_is_sound_and_fetches_nothing() -> None:
    page = Page(html(document()))
    assert (page.misnested, page.fetched) == ([], [])
    assert "4 of 8" in page.said and "4 proven, 2 refuted, 1 infeasible, 1 undecided" in page.said
    assert "asked: <b>more</b> & than any controller can" in page.said, "escaped in the source, whole for the reader"
    assert "<b>more" not in page.text.replace("\\u003cb", "")
    assert len(page.text.encode()) < 6_000_000


def test_the_spring_is_drawn_where_it_crosses_the_map() -> None:
    (shape,) = Page(html(document())).figures[0]["layout"]["shapes"]
    assert (shape["y0"], shape["y1"]) == (4.8, 4.8)
    ideal = changed(lambda c: c["spec"].update(actuator={"type": "ideal"}))
    assert Page(html(ideal)).figures[0]["layout"]["shapes"] == []


@pytest.mark.parametrize(
    ("status", "code"),
    [("proven", ExitCode.UNDECIDED), ("error", ExitCode.INTERNAL)],
)
def test_the_report_ends_as_the_map_did(status: str, code: ExitCode, tmp_path: Path) -> None:
    def change(content: dict[str, Any]) -> None:
        if status == "error":
            content["cells"][0].update(status="error")

    (tmp_path / "map.json").write_bytes(changed(change))
    run = robimp("report", tmp_path / "map.json")
    assert (run.code, run.err) == (code, "")
    assert run.out.splitlines() == [f"MAP  {tmp_path / 'map.json'}", f"report: {tmp_path / 'report.html'}"]
    failed = 'class="verdict failed"' in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert failed == (status == "error")


def test_a_map_in_which_every_cell_has_an_answer_is_a_success(tmp_path: Path) -> None:
    answered = changed(lambda c: c["cells"][6].update(status="infeasible"))
    (tmp_path / "map.json").write_bytes(answered)
    run = robimp("report", tmp_path / "map.json", "-o", tmp_path / "page.html", "--json")
    assert run.code == 0
    (told,) = json.loads(run.out)["certificates"]
    assert told == {"file": str(tmp_path / "map.json"), "exit_code": 0, "message": ""}


BROKEN: dict[str, Callable[[dict[str, Any]], object]] = {
    "a cell is missing": lambda c: c["cells"].pop(),
    "a cell is there twice": lambda c: c["cells"].__setitem__(1, c["cells"][0]),
    "a cell is proven without bandwidth": lambda c: c["cells"][1].update(omega_B=None),
    "a cell has a bandwidth that is not proven": lambda c: c["cells"][0].update(omega_B="5"),
    "an unknown outcome": lambda c: c["cells"][0].update(status="fine"),
    "a bandwidth that is no number": lambda c: c["cells"][1].update(omega_B="five"),
    "a zero denominator": lambda c: c["cells"][1].update(omega_B="5/0"),
    "values that fall": lambda c: c["axes"][0]["values"].reverse(),
    "one axis": lambda c: c["axes"].pop(),
    "no specification": lambda c: c.pop("spec"),
    "another specification": lambda c: c["spec"].update(robimp=2),
    "no list": lambda c: c.update(cells=3),
}


@pytest.mark.parametrize("change", BROKEN.values(), ids=BROKEN)
def test_what_is_no_whole_map_is_refused(change: Callable[[dict[str, Any]], object], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"map\.json: "):
        html(changed(change))
    (tmp_path / "map.json").write_bytes(changed(change))
    assert "map.json: " in refused(ExitCode.INPUT, "report", tmp_path / "map.json")
    assert not (tmp_path / "report.html").exists()


def test_a_truncated_map_and_a_map_among_others_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "map.json"
    file.write_bytes(document()[:-100])
    assert "not a map" in refused(ExitCode.INPUT, "report", file)
    file.write_bytes(document())
    assert "report it alone" in refused(ExitCode.INPUT, "report", PAPER, file)
    assert "would overwrite" in refused(ExitCode.INPUT, "report", file, "-o", file)
    assert file.read_bytes() == document()


@pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")
@pytest.mark.parametrize(
    "flags", [("--window-size=1280,900",), ("--window-size=500,900", DARK)], ids=["wide", "narrow"]
)
def test_a_map_opens_without_a_complaint(flags: tuple[str, ...], tmp_path: Path) -> None:
    look = seen(html(document()).replace("<details>", "<details open>"), tmp_path, *flags)
    assert look.complaints == []
    assert look.report["plots"] == 2
    assert (look.report["page"] == DARK_PAGE) == (DARK in flags)
