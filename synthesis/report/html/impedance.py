"""Apparent against desired impedance over the loads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .curves import Port, ports
from .figure import PALETTE, Figure, Trace, band, frequency, line, opened
from .words import real, units

if TYPE_CHECKING:
    from .study import Study

    Curve = np.ndarray[Any, np.dtype[np.float64]]

HIGHEST = 1 / 8  # of the frequencies of other plots: far above the bandwidth only the inertia is left


def impedance(study: Study) -> Iterator[Figure]:
    """Apparent against desired impedance over the loads: gain, phase, stiffness, damping."""
    omega, unit = study.omega, units(study.spec)
    view = study.view[0], study.view[1] * HIGHEST
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
        shapes = [band(study.ends[0], study.omega_B)] if study.proven else []
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
