"""What is left of a disturbance, and every constraint's margin, against frequency."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ...problem.constraints.inequality import Role
from .curves import Level, filters, levels
from .figure import EVERYWHERE, Figure, Trace, band, cross, edge_note, frequency, level, line, opened, ticks_of_grid
from .words import number, real, span, units

if TYPE_CHECKING:
    from .study import Study

AXIS = {Role.RADIUS: "factor W may grow by", Role.CEILING: "value reached"}


def sensitivity(study: Study) -> Figure:
    """|1−Q̃|, |Q̃|, |Q|, the attenuation asked for and the band it is proven on."""
    colours, traces = ("--blue", "--orange", "--green"), []
    for (name, value), colour in zip(filters(study), colours, strict=True):
        dash = "dash" if name == "|Q|" else "solid"
        traces.append(line(name, study.omega, np.abs(value), colour, dash=dash))
    asked = real(study.spec.objective.attenuation)
    traces.append(level(asked, "attenuation asked for", study.ends, "--muted"))
    inside = study.inside
    limits = opened([np.abs(v)[inside] for _, v in filters(study)], log=True, include=[asked], outliers=0)
    tinted = f" At most {number(asked)} of it is left on the tinted band." if study.proven else ""
    caption = f"A load disturbance acts as 1−Q̃ of itself.{tinted}"
    axis = {"type": "log", "range": limits, "title": {"text": "magnitude"}}
    shapes = [band(study.ends[0], study.omega_B)] if study.proven else []
    title = "What is left of a disturbance: |1−Q̃|, Q̃ and Q"
    return Figure(title, caption, traces, frequency(study.view), axis, shapes, wide=True)


def margins(study: Study) -> Iterator[Figure]:
    """Every constraint's level against frequency, with what is asked, proven and refuted."""
    for found in levels(study):
        yield _margin(study, found)


def _margin(study: Study, found: Level) -> Figure:
    claim, constraint = found.checked.claim, found.constraint
    log = constraint.role is not Role.FLOOR
    traces = [line("level", study.omega, found.values, "--blue", showlegend=False), ticks_of_grid(study.omega)]
    shown = [real(v) for v in (constraint.level,) if v is not None]
    traces += [level(v, f"asked: {number(v)}", study.ends, "--muted") for v in shown]
    if claim.id != "bandwidth" and claim.margin is not None and found.checked.word == "proven":
        shown.append(real(claim.margin))
        traces.append(level(shown[-1], f"proven: {number(claim.margin)}", study.ends, "--good"))
    crosses, notes = _failure(study, found)
    axis: dict[str, Any] = {"title": {"text": AXIS.get(constraint.role, units(study.spec)["damping"])}}
    limits = opened([found.values[study.inside]], log=log, include=shown, outliers=2)
    axis |= {"type": "log", "range": limits} if log else {"range": limits}
    caption = f"{claim.statement}. {found.checked.word.capitalize()} on ω ∈ {span(*claim.interval)}."
    title = f"{claim.id} {claim.equation} · {claim.form}"
    return Figure(title, caption, [*traces, *crosses], frequency(study.view), axis, _proven_on(study, found), notes)


def _failure(study: Study, found: Level) -> tuple[list[Trace], list[dict[str, Any]]]:
    """Where the next level fails: a cross, and beyond the edges of the plot a note that says so."""
    claim = found.checked.claim
    failing = claim.refuted_at
    if failing is None or failing.witness is None:
        return [], []
    omega = np.inf if failing.witness.omega is None else real(failing.witness.omega)
    on_curve = claim.id == "bandwidth"  # whose level is the frequency itself
    value = float(np.interp(omega, study.omega, found.values)) if on_curve else real(failing.value)
    text = f"fails at {number(omega) if omega < np.inf else '∞'} rad/s"
    low, high = study.view
    crosses = [cross(text, omega, value)] if 0 < omega < np.inf else []
    return crosses, [] if low <= omega <= high else [edge_note(text, left=omega < low)]


def _proven_on(study: Study, found: Level) -> list[dict[str, Any]]:
    if found.checked.word != "proven":
        return []
    low, high = found.checked.claim.interval
    if not low and high is None:
        return [EVERYWHERE]
    first, last = study.ends
    return [band(real(low) or first, last if high is None else real(high))]
