"""Several certificates beside each other: a table, and their curves in one plot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from .curves import filters, least_resistance
from .figure import PALETTE, Figure, frequency, line, opened
from .words import margin, number, units

if TYPE_CHECKING:
    from .curves import Real
    from .study import Study


def names(studies: Sequence[Study]) -> list[str]:
    """What tells the certificates apart: the specification's name, or the file where two share one."""
    said = [study.spec.name for study in studies]
    return [study.file if said.count(name) > 1 else name for study, name in zip(studies, said, strict=True)]


def comparison(studies: Sequence[Study]) -> list[Figure]:
    """What is left of a disturbance, and the resistance of the port, of every certificate."""
    view = min(s.view[0] for s in studies), max(s.view[1] for s in studies)
    said = {units(study.spec)["damping"] for study in studies}
    relative = len(said) > 1  # rotary joints beside linear ones have no common scale
    return [
        _overlaid(studies, view, "What is left of a disturbance, |1−Q̃|", "Lower is better, up to ω_B (dot).",
                  lambda s: np.abs(next(filters(s))[1]), {"type": "log", "title": {"text": "magnitude"}}),
        _overlaid(studies, view, "Least resistance of the port, Re(Z/jω)", "Passive where it is nowhere negative.",
                  _relative_resistance if relative else least_resistance,
                  {"title": {"text": "share of its largest value" if relative else said.pop()}}),
    ]  # fmt: skip


def _relative_resistance(study: Study) -> Real:
    values = least_resistance(study)
    return np.asarray(values / np.max(np.abs(values[study.inside])))


def _overlaid(
    studies: Sequence[Study], view: tuple[float, float], title: str, caption: str,
    of: Callable[[Any], Any], axis: dict[str, Any],
) -> Figure:  # fmt: skip
    traces, shown = [], []
    for k, (study, name) in enumerate(zip(studies, names(studies), strict=True)):
        values, colour = of(study), PALETTE[k % len(PALETTE)]
        dash = ("solid", "dash", "dot")[k // len(PALETTE) % 3]
        traces.append(line(name, study.omega, values, colour, dash=dash, legendgroup=name))
        if study.omega_B:
            at = float(np.interp(study.omega_B, study.omega, values))
            dot = line(name, [study.omega_B], [at], colour, legendgroup=name, showlegend=False)
            traces.append({**dot, "mode": "markers", "marker": {"color": colour, "size": 9}})
        shown.append(values[(study.omega >= view[0]) & (study.omega <= view[1])])
    limits = opened(shown, log=axis.get("type") == "log", outliers=1, include=() if axis.get("type") else (0,))
    return Figure(title, caption, traces, frequency(view), axis | {"range": limits}, wide=True)


def rows(studies: Sequence[Study]) -> tuple[list[str], list[list[str]]]:
    """The table: headings, one column a certificate: verdict, ω_B, bound, every kind of margin."""
    kinds = list(dict.fromkeys((c.claim.id, c.claim.form) for s in studies for c in s.claims if c.claim.margin))
    bounds = [study.content["bandwidth"]["bound"] for study in studies]
    body = [
        ["verdict", *(study.verdict_word for study in studies)],
        ["ω_B", *(f"≥ {study.verdict.omega_b} rad/s" if study.proven else "–" for study in studies)],
        ["bound, of a solver", *("–" if bound is None else f"{number(Fraction(bound))} rad/s" for bound in bounds)],
    ]
    for kind in kinds:
        if kind[0] != "bandwidth":
            body.append([" ".join(kind), *(_proven_margin(study, kind) for study in studies)])
    return ["certificate", *names(studies)], body


def _proven_margin(study: Study, kind: tuple[str, str]) -> str:
    found = next((c for c in study.claims if (c.claim.id, c.claim.form) == kind and c.word == "proven"), None)
    return "–" if found is None else margin(found.claim, study.spec.motion) or "–"
