"""A certificate judged: re-proven by the checker, and compared with the specification and controller in use."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from .check import Verdict, check_bytes
from .controller_file import Controller, stale
from .errors import ExitCode
from .report.difference import differences, without_consequences


@dataclass(frozen=True)
class Comparison:
    """A certificate beside what it has to belong to: "specification" or "controller"; it does if nothing differs."""

    other: str
    differences: tuple[str, ...]
    seconds: float

    def __str__(self) -> str:
        return f"of another {self.other} (certificate → {self.other}): {'; '.join(self.differences)}"


@dataclass(frozen=True)
class Judgement:
    """One certificate's outcome. An unreadable one is compared with nothing."""

    file: str
    verdict: Verdict
    comparisons: tuple[Comparison, ...] = ()
    seconds: float = 0.0

    @property
    def mismatches(self) -> tuple[Comparison, ...]:
        """The comparisons that found a difference."""
        return tuple(c for c in self.comparisons if c.differences)

    @property
    def exit_code(self) -> ExitCode:
        """The checker's code; a readable certificate of something else is a mismatch, whatever it proves."""
        return ExitCode.MISMATCH if self.mismatches else ExitCode(self.verdict.exit_code)

    @property
    def message(self) -> str:
        """One line: what does not belong, then what the checker says."""
        said = self.verdict.message
        if self.verdict.exit_code != ExitCode.PROVEN:
            return "; and ".join([*map(str, self.mismatches), said])
        if self.mismatches:
            return "; and ".join(map(str, self.mismatches))
        agreeing = " and ".join(c.other for c in self.comparisons)
        return f"{said}, of this {agreeing}" if agreeing else said

    def __repr__(self) -> str:
        return f"<Judgement {self.file}: {self.exit_code.name}, {self.message}>"

    def _repr_html_(self) -> str:
        from .report.cards import judgement_card

        return judgement_card(self)

    def to_json(self) -> dict[str, Any]:
        """For scripts: outcome, claims, and every difference."""
        return {
            "file": self.file,
            "exit_code": int(self.exit_code),
            "message": self.message,
            "omega_b": self.verdict.omega_b if self.exit_code is ExitCode.PROVEN else None,
            "claims": [dict(zip(("id", "form", "status", "message"), c, strict=True)) for c in self.verdict.claims],
            "differences": {c.other: list(c.differences) for c in self.comparisons},
        }


def judge(
    file: str, data: bytes, spec: dict[str, Any] | None, controller: Controller | None, time_limit: float
) -> Judgement:
    """Re-prove a certificate's bytes [s, time_limit]; compare with a canonical specification and a controller."""
    began = time.perf_counter()
    verdict = check_bytes(data, time_limit=time_limit)
    comparisons = []
    asked = spec is not None or controller is not None
    if asked and verdict.exit_code != ExitCode.INPUT:
        content = json.loads(data)
        if spec is not None:
            from .spec.free_corner import as_certified

            plain = without_consequences(content["spec"], as_certified(spec, content["spec"]))
            comparisons.append(_compared("specification", differences(content["spec"], plain, "specification")))
        if controller is not None:
            comparisons.append(_compared("controller", stale(content["controller"], controller)))
    return Judgement(file, verdict, tuple(comparisons), time.perf_counter() - began)


def _compared(other: str, found: Iterable[str]) -> Comparison:
    began = time.perf_counter()
    return Comparison(other, tuple(found), time.perf_counter() - began)


def unreadable(file: str, reason: str, code: ExitCode = ExitCode.INPUT) -> Judgement:
    """The judgement of a certificate that was not checked."""
    return Judgement(file, Verdict(int(code), reason))
