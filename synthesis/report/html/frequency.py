"""Plots over frequency of one certificate: margins, filters, apparent impedance, Nyquist."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ...problem.constraints.inequality import Role
from .curves import Level, Nyquist, Port, filters, levels, nyquist, ports
from .figure import PALETTE, Figure, Trace, band, cross, frequency, level, line, opened, rounded, ticks_of_grid
from .words import number, real, span, units

if TYPE_CHECKING:
    from .study import Study

    Curve = np.ndarray[Any, np.dtype[np.float64]]

AXIS = {Role.RADIUS: "factor W may grow by", Role.CEILING: "value reached"}
DISCS, NEAR, AROUND, FAR = 30, 5.0, 60, 50.0  # discs drawn, how near −1 their centres, corners of each; end of a curve
WINDOW = ([-2.7, 1.1], [-2.2, 1.0])  # of a Nyquist plot
CRITICAL: Trace = {
    "type": "scatter", "mode": "markers", "name": "−1", "x": [-1], "y": [0], "hoverinfo": "name",
    "marker": {"symbol": "cross", "size": 11, "color": "--red"},
}  # fmt: skip


def sensitivity(study: Study) -> Figure:
    """|1−Q̃|, |Q̃|, |Q|, the attenuation asked for and the band it is proven on."""
    colours, traces = ("--blue", "--orange", "--green"), []
    for (name, value), colour in zip(filters(study), colours, strict=True):
        dash = "dash" if name == "|Q|" else "solid"
        traces.append(line(name, study.omega, np.abs(value), colour, dash=dash))
    asked = real(study.spec.objective.attenuation)
    traces.append(level(asked, "attenuation asked for", _edges(study), "--muted"))
    inside = _inside(study)
    limits = opened([np.abs(v)[inside] for _, v in filters(study)], log=True, include=[asked], outliers=0)
    tinted = f" At most {number(asked)} of it is left on the tinted band." if study.proven else ""
    caption = f"A load disturbance acts as 1−Q̃ of itself.{tinted}"
    axis = {"type": "log", "range": limits, "title": {"text": "magnitude"}}
    shapes = [band(float(study.omega[0]), study.omega_B)] if study.proven else []
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
    traces[-1]["showlegend"] = False
    shown = [real(v) for v in (constraint.level,) if v is not None]
    traces += [level(v, f"asked: {number(v)}", _edges(study), "--muted") for v in shown]
    sandwich = claim.id != "bandwidth" and claim.margin is not None and found.checked.word == "proven"
    if sandwich and claim.margin is not None:
        shown.append(real(claim.margin))
        traces.append(level(shown[-1], f"proven: {number(claim.margin)}", _edges(study), "--good"))
    annotations = _witness(study, found, traces)
    axis: dict[str, Any] = {"title": {"text": AXIS.get(constraint.role, units(study.spec)["damping"])}}
    limits = opened([found.values[_inside(study)]], log=log, include=shown, outliers=2)
    axis |= {"type": "log", "range": limits} if log else {"range": limits}
    caption = f"{claim.statement}. {found.checked.word.capitalize()} on ω ∈ {span(*claim.interval)}."
    title = f"{claim.id} {claim.equation} · {claim.form}"
    return Figure(title, caption, traces, frequency(study.view), axis, _proven_on(study, found), annotations)


def _witness(study: Study, found: Level, traces: list[Trace]) -> list[dict[str, Any]]:
    """Mark where the next level fails: in the plot, or at the edge it lies beyond."""
    claim = found.checked.claim
    failing = claim.refuted_at
    if failing is None or failing.witness is None:
        return []
    omega = np.inf if failing.witness.omega is None else real(failing.witness.omega)
    value = real(failing.value)
    if claim.id == "bandwidth":
        value = float(np.interp(omega, study.omega, found.values))
    low, high = study.view
    if 0 < omega < np.inf:
        traces.append(cross(f"fails at {number(omega)} rad/s", omega, value))
    if low <= omega <= high:
        return []
    left, where = omega < low, "∞" if omega == np.inf else number(omega)
    text = f"← fails at ω = {where}" if left else f"fails at ω = {where} →"
    side = "left" if left else "right"
    return [{"text": text, "xref": "paper", "yref": "paper", "x": 0 if left else 1, "y": 0.99, "xanchor": side,
             "yanchor": "top", "showarrow": False, "font": {"color": "--red", "size": 11}}]  # fmt: skip


def _proven_on(study: Study, found: Level) -> list[dict[str, Any]]:
    if found.checked.word != "proven":
        return []
    low, high = found.checked.claim.interval
    if not low and high is None:
        return [band(None, None)]
    ends = float(study.omega[0]), float(study.omega[-1])
    return [band(real(low) or ends[0], ends[1] if high is None else real(high))]


def impedance(study: Study) -> Iterator[Figure]:
    """Apparent against desired impedance over the loads: gain, phase, stiffness, damping."""
    omega, unit = study.omega, units(study.spec)
    view = study.view[0], study.view[1] / 8
    about = (omega >= view[0]) & (omega <= view[1])
    within = about & (omega <= study.omega_B) if study.omega_B else about
    own = real(study.setting.loop.desired.inertia) * omega**2
    views: tuple[tuple[str, str, bool, Any, Callable[[Any], Curve]], ...] = (
        ("Gain |Z|", unit["stiffness"], True, about, np.abs),
        ("Phase of Z", "degrees", False, about, lambda Z: np.degrees(np.unwrap(np.angle(Z)))),
        ("Stiffness, Re Z + Iω² with the desired I", unit["stiffness"], False, within, lambda Z: np.real(Z) + own),
        ("Damping, Im Z/ω", unit["damping"], False, about, lambda Z: np.imag(Z) / omega),
    )
    all_ports = ports(study)
    for title, axis_title, log, shown, of in views:
        traces = list(_port_traces(study, all_ports, of))
        values = [v for port in all_ports for v in (of(port.Z)[shown], of(port.wish)[shown])]
        axis: dict[str, Any] = {"title": {"text": axis_title}, "range": opened(values, log=log, outliers=1)}
        axis |= {"type": "log"} if log else {}
        shapes = [band(float(omega[0]), study.omega_B)] if study.proven else []
        caption = "Solid: the nominal load; thin: corners of the box; dashed: what is desired. Tinted: up to ω_B."
        yield Figure(title, caption, traces, frequency(view), axis, shapes)


def _port_traces(study: Study, all_ports: list[Port], of: Callable[[Any], Curve]) -> Iterator[Trace]:
    wishes: list[Any] = []
    named = False
    for port in all_ports:
        if not any(np.array_equal(port.wish, wish) for wish in wishes):
            wishes.append(port.wish)
        colour = PALETTE[(len(wishes) - 1) % len(PALETTE)]
        if port.nominal:
            name = port.name if len(wishes) > 1 or study.setting.impedances else "nominal load"
            yield line(name, study.omega, of(port.Z), colour)
            yield line("desired", study.omega, of(port.wish), "--text", dash="dash", showlegend=len(wishes) == 1)
        else:
            yield line(
                "corners of the box", study.omega, of(port.Z), colour, width=0.9, opacity=0.65, legendgroup="corners",
                showlegend=not named, text=port.name, hovertemplate="%{y:.4g} %{text}",
            )  # fmt: skip
            named = True


def nyquist_plots(study: Study) -> Iterator[Figure]:
    """What Δ sees, with the discs the uncertainty makes of its points, and what a wall sees. None may reach −1."""
    found = nyquist(study)
    captions = (
        "Poles in free motion are the zeros of 1 + (1+Δ)ℓ. With a stable nominal loop, every load is stable while no "
        "disc, of radius W|ℓ| at any frequency, holds −1.",
        "Poles against a rigid wall are the zeros of 1 + HCF, which do not depend on the load.",
    )
    free = [_discs(study, found), _locus(study, "ℓ(jω)", found.ell, "--blue")]
    wall = [_locus(study, "HCF", found.wall, "--orange")]
    for title, caption, traces in zip(("Free: ℓ with the discs of the uncertainty", "Against a wall: HCF"), captions,
                                      (free, wall), strict=True):  # fmt: skip
        x = {"range": WINDOW[0], "title": {"text": "real part"}, "zeroline": True, "constrain": "domain"}
        y = {"range": WINDOW[1], "title": {"text": "imaginary part"}, "zeroline": True, "constrain": "domain"}
        yield Figure(f"Nyquist. {title}", caption, [*traces, CRITICAL], x, y | {"scaleanchor": "x"}, square=True)


def _locus(study: Study, name: str, values: Any, colour: str) -> Trace:
    shown = np.where(np.abs(values) < FAR, values, np.nan)
    return line(name, shown.real, shown.imag, colour, text=rounded(study.omega), hovertemplate="ω = %{text} rad/s")


def _discs(study: Study, found: Nyquist) -> Trace:
    inside = _inside(study) & np.isfinite(found.radius)
    near = np.flatnonzero(inside & (np.abs(found.ell + 1) < NEAR))
    chosen = near[np.unique(np.linspace(0, len(near) - 1, DISCS).astype(int))] if near.size else near
    circle = np.append(np.exp(2j * np.pi * np.arange(AROUND) / (AROUND - 1)), np.nan)
    discs = (found.ell[chosen, None] + found.radius[chosen, None] * circle).ravel()
    return line(
        "W|ℓ| about ℓ", discs.real, discs.imag, "--blue", width=0.8, opacity=0.6, hoverinfo="skip", hovertemplate=None
    )


def _edges(study: Study) -> list[float]:
    return [float(study.omega[0]), float(study.omega[-1])]


def _inside(study: Study) -> np.ndarray[Any, np.dtype[np.bool_]]:
    low, high = study.view
    return np.asarray((study.omega >= low) & (study.omega <= high))
