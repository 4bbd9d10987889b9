"""How results look: one line as text, a small self-contained card in a notebook, whatever is in their names."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from robimp.synthesis import InputError, Map, Result, Verdict, check, identify, init, judge, load, parse, simulate
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.notebook import TONES, card
from robimp.synthesis.sweep.axis import Axis
from robimp.synthesis.sweep.cell import Cell, Status
from robimp.synthesis.sweep.plane import Plane

MOST = 60_000  # characters of a card
LIKE_HTML = "<script>alert(1)</script>&\"'"


class Card(HTMLParser):
    """Tags and text of a card, and whether every element is closed."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.open: list[str] = []
        self.said: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.open.append(tag)
        self.attributes += attributes

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.said.append(data)


def a_map() -> Map:
    axes = Axis.parse("impedance.stiffness", "1:2:2"), Axis.parse("impedance.damping", "0.2:0.4:2")
    answers = (Status.PROVEN, Status.REFUTED, Status.PROVEN, Status.PROVEN)
    indices = ((0, 0), (0, 1), (1, 0), (1, 1))
    cells = {
        index: Cell(index, status, Fraction(88757169, 10**7) if status is Status.PROVEN else None)
        for index, status in zip(indices, answers, strict=True)
    }
    return Map(Plane.of(parse(init("arm")), axes), cells)


@pytest.fixture
def shown(folder: Path, result: Result) -> dict[str, Any]:
    joints = [control.tf([1], [inertia, 0.2, 1]) for inertia in (0.028, 0.03)]
    responses = [control.frd(joint, np.geomspace(1, 50, 20)) for joint in joints]
    return {
        "result": result,
        "specification": result.spec,
        "verdict": check("certificate.json"),
        "judgement": judge("certificate.json", spec=result.spec),
        "simulation": simulate(result, loads=0),
        "map": a_map(),
        "identified": identify(responses, kind="load", beyond="hold"),
    }


def test_every_result_is_one_line_and_a_small_card(shown: dict[str, Any]) -> None:
    for name, each in shown.items():
        assert 10 < len(repr(each)) < 200 and "\n" not in repr(each), name
        html = each._repr_html_()
        found = Card(html)
        assert found.open == [] and len(html) < MOST, name
        assert set(found.tags) <= {"div", "b", "table", "thead", "tbody", "tr", "th", "td"}, "nothing is fetched or run"
        assert {key for key, _ in found.attributes} <= {"style"}
        assert "background" not in html, "a card is legible on the page's own colour, light or dark"


def test_a_card_says_what_was_proven_and_no_more(shown: dict[str, Any], result: Result) -> None:
    said = Card(shown["result"]._repr_html_()).said
    assert "PROVEN" in said and "ω_B ≥ 8.87571 rad/s" in said and "eq12" in said
    assert TONES["good"] in shown["result"]._repr_html_()
    assert "8.87571" in Card(shown["map"]._repr_html_()).said and "refuted" in Card(shown["map"]._repr_html_()).said
    first, *rest = (claim for claim in result.claims if claim.required)
    refuted = replace(result, claims=(replace(first, status=Outcome.REFUTED), *rest))
    bad = refuted._repr_html_()
    assert "REFUTED" in bad and TONES["bad"] in bad and TONES["good"] not in bad
    assert "ω_B ≥ 8.87571 rad/s" not in Card(bad).said[:6], "no bandwidth in the head of what is not proven"


def test_a_mismatch_is_red(folder: Path) -> None:
    other = judge("certificate.json", spec=parse(init("arm")))
    assert "MISMATCH" in repr(other) and TONES["bad"] in other._repr_html_()
    absent = judge("absent.json")
    assert "INPUT" in repr(absent) and "No such file" in absent._repr_html_()


def test_a_verdict_says_in_one_line_what_the_command_says(folder: Path) -> None:
    proven, absent = check("certificate.json"), check("nope.json")
    assert repr(proven) == f"<Verdict PROVEN, ω_B ≥ {proven.omega_b} rad/s, 10 claims>"
    assert "PROVEN" in proven._repr_html_() and "eq12" in proven._repr_html_()
    assert repr(absent) == "<Verdict INPUT, file: cannot be read: No such file or directory>"
    assert "PROVEN" not in absent._repr_html_() and "<table>" not in absent._repr_html_()
    with pytest.raises(InputError):
        load("nope.yaml")
    hostile = Verdict(4, LIKE_HTML, None, ((LIKE_HTML,) * 4,))
    assert repr(hostile).startswith("<Verdict REFUTED, ") and "<script" not in hostile._repr_html_()


def test_text_is_text() -> None:
    html = card(LIKE_HTML, LIKE_HTML, rows=[(LIKE_HTML, LIKE_HTML)], table=([LIKE_HTML], [[LIKE_HTML]]))
    assert "<script" not in html
    assert Card(html).said.count(LIKE_HTML) == 6


def test_a_specification_shows_what_it_says(folder: Path) -> None:
    said = " ".join(Card(load("examples/haninger2016-sampled.yaml")._repr_html_()).said)
    for words in ("inertia 0.03", "stiffness [0.2, 10]", "rate 1000", "coefficients", "torque_loop (kp 10"):
        assert words in said
    assert "None" not in said and "filters" not in said, "there are none"
    assert "eq9" in " ".join(Card(parse(init("arm"))._repr_html_()).said), "asked for, though it has no keys"
