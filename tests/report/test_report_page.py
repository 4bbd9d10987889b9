"""The page as a document: complete, self-contained, escaped, honest about certificates that do not check."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from command_line import refused, robimp
from report_pages import EQ23, GARBAGE, LINEAR, LOWERED, PAPER, STIFF, UNSTABLE, WITHOUT, Page, changed, html, study

from robimp.synthesis.errors import ExitCode, InputError
from robimp.synthesis.report.html import write_report
from robimp.synthesis.report.html.study import Study
from robimp.synthesis.report.html.write import render

LARGEST = 6_000_000  # bytes
SECTIONS = ("Controller", "Specification", "Margins at every frequency", "Apparent impedance", "Stability", "Claims")
HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(1)>\u2028</style>"


def test_the_first_screen_says_what_is_proven() -> None:
    page = Page(html(PAPER))
    assert page.misnested == []
    first = page.said[: page.said.index("Disturbances")]
    for said in (
        "PROVEN",
        "ω_B ≥ 8.87571 rad/s",
        "haninger2016-paper",
        "inertia 0.03 kg·m² ± 20 %",
        "attenuate",
        "2500",
    ):
        assert said in first
    assert page.of_class("proven") and not page.of_class("failed")


def test_a_refuted_claim_is_not_counted_as_proven() -> None:
    assert {c.word for c in study(EQ23).claims} == {"proven", "refuted"}
    first = Page(html(EQ23)).said.split("Controller")[0]
    assert "claims, all confirmed by the checker 10 proven, 1 refuted" in first
    first = Page(html(LOWERED)).said.split("Controller")[0]
    assert "claims, not all confirmed by the checker" in first and "1 not verified" in first


def test_every_part_is_there() -> None:
    page = Page(html(PAPER))
    positions = [page.said.index(f" {section}") for section in SECTIONS]
    assert positions == sorted(positions)
    for said in ("Assumed", "Not claimed", "Provenance", study(PAPER).content["end"]["body_sha256"]):
        assert said in page.said
    assert len(page.of_class("plot")) == len(page.figures) >= 15
    for checked in study(PAPER).claims:
        assert checked.claim.statement in page.said
    assert len(page.text.encode()) < LARGEST


def test_the_controller_is_typeset_without_scripts() -> None:
    formulas = re.findall("<math.*?</math>", html(PAPER), re.DOTALL)
    assert len(formulas) == 2
    Q = ET.fromstring(formulas[0])
    assert "".join(Q.itertext()) == "Q(s)=2000s2+70.75s+2500"


def test_nothing_is_fetched() -> None:
    page = Page(html(PAPER))
    assert page.fetched == []
    policy = next(a["content"] for tag, a in page.elements if tag == "meta" and "http-equiv" in a)
    assert policy and policy.startswith("default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'")


@pytest.mark.parametrize(
    "element",
    [
        '<img src="https://example.org/a.png">',
        '<script src="a.js"></script>',
        '<link rel="stylesheet" href="//example.org/a.css">',
        "<style>@import 'a.css';</style>",
        "<style>p { background: url(https://example.org/a.png) }</style>",
    ],
)
def test_what_would_be_fetched_is_seen(element: str) -> None:
    assert Page(f"<body>{element}</body>").fetched


def test_the_same_certificate_gives_the_same_page() -> None:
    again = Study.of(PAPER.name, PAPER.read_bytes())
    assert render([again]) == html(PAPER).encode()


def hostile(content: dict[str, Any]) -> None:
    content["producer"] = {HOSTILE: HOSTILE}
    content["assumptions"] = content["not_claimed"] = [HOSTILE]
    for claim in content["claims"]:
        claim["statement"] = claim["equation"] = claim["uncertainty"] = HOSTILE


def test_texts_are_texts() -> None:
    checked = Study.of(HOSTILE, changed(PAPER, hostile))
    named = checked.spec.model_copy(update={"name": HOSTILE})
    page = Page(render([replace(checked, setting=replace(checked.setting, spec=named))]).decode())
    ordinary = Page(html(PAPER))
    assert [tag for tag, _ in page.elements] == [tag for tag, _ in ordinary.elements]
    assert HOSTILE.replace("\u2028", "") in page.said.replace("\u2028", "")
    assert page.figures == [{**figure} for figure in page.figures]  # the data is still one JSON document
    assert not any("onerror" in (attributes or {}) for _, attributes in page.elements)


def test_words_a_certificate_brings_along_are_not_believed() -> None:
    page = Page(render([Study.of("a", changed(PAPER, hostile))]).decode())
    ordinary = Page(html(PAPER))
    for section in ("Assumed", "Margins at every frequency"):
        start = ordinary.said.index(section)
        assert ordinary.said[start : start + 200] in page.said
    own = {c.claim.statement for c in study(PAPER).claims if c.claim.id in ("eq9", "eq12", "eq18", "peak")}
    assert all(statement in page.said for statement in own)


@pytest.mark.parametrize(
    ("path", "code", "said"),
    [
        (LOWERED, ExitCode.REFUTED, "peak sensitivity: does not hold"),
        (STIFF, ExitCode.REFUTED, "eq12 structured: required, and refuted"),
        (UNSTABLE, ExitCode.REFUTED, "stability-free hurwitz: required, and refuted"),
        (WITHOUT, ExitCode.MISMATCH, "bandwidth"),
    ],
    ids=lambda value: value.stem if isinstance(value, Path) else "",
)
def test_a_certificate_that_does_not_check_says_so_first(path: Path, code: ExitCode, said: str, tmp_path: Path) -> None:
    output = tmp_path / "page.html"
    run = robimp("report", path, "-o", output)
    assert run.code == code and said in run.line
    page = Page(output.read_text(encoding="utf-8"))
    assert page.said.index(code.name) < page.said.index(said) < page.said.index("Controller")
    assert page.of_class("failed") and not page.of_class("verdict proven")
    assert "ω_B ≥" not in page.said[: page.said.index("Disturbances")]
    assert "not verified" in page.said


def test_what_an_unstable_joint_does_is_shown() -> None:
    page = Page(html(UNSTABLE))
    assert "Unstable: nominal" in page.said
    step = next(f for f in page.figures if f["layout"]["yaxis"]["title"]["text"] == "θ [rad]")
    motion = [abs(v) for v in step["traces"][0]["y"] if v is not None]
    assert motion[-1] > 10 * motion[len(motion) // 2]


def test_bytes_that_are_no_certificate_leave_an_earlier_page_alone(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text("earlier")
    assert GARBAGE.name in refused(ExitCode.INPUT, "report", GARBAGE, "-o", page)
    assert page.read_text() == "earlier" and list(tmp_path.iterdir()) == [page]
    with pytest.raises(InputError):
        write_report({"a": b"{}"}, page)


def test_several_certificates_are_compared(tmp_path: Path) -> None:
    page = Page(html(PAPER, EQ23, STIFF))
    assert page.misnested == []
    table = page.said[page.said.index("Comparison") : page.said.index("What is left of a disturbance")]
    for said in ("haninger2016-paper", "8.8757", "haninger2016-eq23", "13.28", "haninger2016-stiff", "REFUTED"):
        assert said in table
    assert "≥ 40" not in table and "ω_B ≥ 8.87571 rad/s" in table and "decay ≥" in table, (
        "as in its own part, with units"
    )
    overlaid = page.figures[0]["traces"]
    assert [t["name"] for t in overlaid if t.get("mode") == "lines"] == [
        "haninger2016-paper",
        "haninger2016-eq23",
        "haninger2016-stiff",
    ]
    assert sum(tag == "details" for tag, _ in page.elements) == 3
    assert len(page.of_class("plot")) == len(page.figures)


def test_joints_that_turn_and_joints_that_slide_have_no_common_unit() -> None:
    turning, sliding = study(PAPER), study(LINEAR)
    assert (turning.spec.motion, sliding.spec.motion) == ("rotary", "linear")
    mixed = Page(html(PAPER, LINEAR)).figures[1]
    assert mixed["layout"]["yaxis"]["title"]["text"] == "share of its largest value"
    lines = [trace for trace in mixed["traces"] if trace["mode"] == "lines"]
    for joint, trace in zip((turning, sliding), lines, strict=True):
        low, high = joint.view
        within = [abs(y) for x, y in zip(trace["x"], trace["y"], strict=True) if low <= x <= high]
        assert max(within) == pytest.approx(1, abs=1e-3)
    assert Page(html(PAPER, EQ23)).figures[1]["layout"]["yaxis"]["title"]["text"] == "N·m·s/rad"


def test_certificates_of_one_name_are_told_apart_by_their_files() -> None:
    one, other = study(PAPER), replace(study(PAPER), file="other.json")
    page = Page(render([one, other]).decode())
    assert {t["name"] for t in page.figures[0]["traces"]} == {"haninger2016-paper.json", "other.json"}


def test_the_command_writes_beside_the_certificate(tmp_path: Path) -> None:
    certificate = tmp_path / "certificate.json"
    certificate.write_bytes(PAPER.read_bytes())
    run = robimp("report", certificate, "--json")
    assert run.code == ExitCode.PROVEN
    said = json.loads(run.out)
    assert said["report"] == str(tmp_path / "report.html")
    assert said["certificates"][0]["exit_code"] == 0
    assert Page((tmp_path / "report.html").read_text(encoding="utf-8")).of_class("proven")


def test_the_gravest_of_several_decides(tmp_path: Path) -> None:
    run = robimp("report", PAPER, LOWERED, "-o", tmp_path / "page.html")
    assert run.code == ExitCode.REFUTED and "PROVEN" in run.out and "peak" in run.err


def test_a_certificate_named_twice_is_shown_once(tmp_path: Path) -> None:
    run = robimp("report", WITHOUT, WITHOUT, "-o", tmp_path / "page.html")
    assert run.code == ExitCode.MISMATCH and run.line
    assert not Page((tmp_path / "page.html").read_text(encoding="utf-8")).of_class("compared")


def test_a_check_out_of_time_proves_nothing(tmp_path: Path) -> None:
    run = robimp("report", PAPER, "-o", tmp_path / "page.html", "--time-limit", "0.01")
    assert run.code == ExitCode.UNDECIDED and "time limit" in run.line
    page = Page((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert page.of_class("failed") and "UNDECIDED" in page.said and "11 of 11" not in page.said
    assert "not verified" in page.said and "ω_B ≥" not in page.said[: page.said.index("Disturbances")]
    assert not page.figures[0]["layout"]["shapes"], "the bandwidth is tinted as if it were proven"


def test_a_page_replaces_only_files(tmp_path: Path) -> None:
    assert "no ordinary file" in refused(ExitCode.INPUT, "report", WITHOUT, "-o", tmp_path)


def test_a_certificate_is_not_overwritten(tmp_path: Path) -> None:
    certificate = tmp_path / "certificate.json"
    certificate.write_bytes(PAPER.read_bytes())
    assert "would overwrite" in refused(ExitCode.INPUT, "report", certificate, "-o", certificate)
    assert certificate.read_bytes() == PAPER.read_bytes()
    assert "absent.json" in refused(ExitCode.INPUT, "report", tmp_path / "absent.json")


def variables(style: str) -> list[set[str]]:
    """Colours that each theme of a style sheet defines."""
    return [set(re.findall(r"(--[a-z-]+):", theme)) for theme in re.findall(r":root[.a-z]* {(.*?)}", style, re.DOTALL)]


def test_every_colour_of_a_plot_is_there_in_light_and_dark() -> None:
    page = Page(html(PAPER))
    light, dark = variables(page.styles[0])
    assert light == dark
    named = set(re.findall(r'"(--[a-z-]+)"', page.scripts[0])) | set(
        re.findall(r'colour\("(--[a-z-]+)"\)', page.scripts[2])
    )
    assert len(named) > 8 and named <= light
