"""Judgements as JUnit XML, which continuous integration shows: one suite per certificate, one case per claim."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from ..errors import ExitCode

if TYPE_CHECKING:
    from ..judgement import Comparison, Judgement

COUNTED = {"tests": "testcase", "failures": "failure", "errors": "error", "skipped": "skipped"}
FALSE = (ExitCode.REFUTED, ExitCode.MISMATCH)  # a failure; anything else that is no proof is an error


def junit(judgements: Sequence[Judgement]) -> bytes:
    """The XML document. A suite is red exactly when its certificate's exit code is not 0."""
    root = ET.Element("testsuites", name="robimp check")
    for judgement in judgements:
        _suite(root, judgement)
    _count(root)
    root.set("time", _seconds(sum(judgement.seconds for judgement in judgements)))
    ET.indent(root, " ")
    data: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return data + b"\n"


def _suite(root: ET.Element, judgement: Judgement) -> None:
    """The certificate as a whole, its comparisons, its claims. The checker times the whole, not each claim."""
    file = _legal(judgement.file)
    suite = ET.SubElement(root, "testsuite", name=file)
    verdict, compared = judgement.verdict, sum(c.seconds for c in judgement.comparisons)
    whole = _case(suite, file, "certificate", judgement.seconds - compared)
    code = ExitCode(verdict.exit_code)
    if code is not ExitCode.PROVEN:
        _red(whole, code, verdict.message)
    for comparison in judgement.comparisons:
        _comparison(suite, file, comparison)
    for id, form, status, message in verdict.claims:
        case = _case(suite, file, f"{id} {form}", 0.0)
        if status == "not verified":
            _red(case, code, message)
        elif status != "proven":  # it is as the certificate says, but nobody should see it green
            ET.SubElement(case, "skipped", message=_legal(f"{message}; reported, not required"))
    _count(suite)
    suite.set("time", _seconds(judgement.seconds))


def _comparison(suite: ET.Element, file: str, comparison: Comparison) -> None:
    case = _case(suite, file, comparison.other, comparison.seconds)
    if comparison.differences:
        _red(case, ExitCode.MISMATCH, str(comparison), "\n".join(comparison.differences))


def _case(suite: ET.Element, file: str, name: str, seconds: float) -> ET.Element:
    return ET.SubElement(suite, "testcase", classname=file, name=_legal(name), time=_seconds(seconds))


def _red(case: ET.Element, code: ExitCode, message: str, text: str = "") -> None:
    kind = "failure" if code in FALSE else "error"
    element = ET.SubElement(case, kind, type=code.name.lower(), message=_legal(message))
    element.text = _legal(text or message)


def _count(element: ET.Element) -> None:
    for attribute, kind in (
        ("tests", "testcase"),
        ("failures", "failure"),
        ("errors", "error"),
        ("skipped", "skipped"),
    ):
        element.set(attribute, str(sum(1 for _ in element.iter(kind))))


def _seconds(seconds: float) -> str:
    return f"{max(seconds, 0.0):.3f}"


def _legal(text: str) -> str:
    """Text without the characters XML cannot carry: a file's name may hold any."""
    return "".join(c if _carried(ord(c)) else ascii(c)[1:-1] for c in text)


def _carried(code: int) -> bool:
    return code in (0x9, 0xA, 0xD) or 0x20 <= code <= 0xD7FF or 0xE000 <= code <= 0xFFFD or code >= 0x10000
