"""Plots over time of one certificate."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .figure import PALETTE, Figure, line
from .traces import Traces, simulated
from .words import number

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .study import Study

KEPT = 500  # samples of a curve


def motion(study: Study) -> Iterator[Figure]:
    """Step responses, their torque commands, and the energy that enters the port under a tone."""
    found = simulated(study)
    if found is None:
        return
    linear = study.spec.motion == "linear"
    force, way = ("1 N", "x [m]") if linear else ("1 N·m", "θ [rad]")
    unstable = [trace.name for trace in found.traces if not trace.stable]
    warning = f" Unstable: {'; '.join(unstable)}." if unstable else ""
    time = {"title": {"text": "t [s]"}}
    moved = [(t.name, t.step.times, t.step.theta) for t in found.traces]
    traces = list(_lines(moved))
    if found.wish is not None:
        times, theta = map(_thinned, found.wish)
        traces.append(line("desired", times, theta, "--text", dash="dash"))
    caption = f"{force}, held, on every corner of the box of loads; dashed, the desired impedance.{warning}"
    yield Figure("Step at the port", caption, traces, time, {"title": {"text": way}})
    commands = list(_lines([(t.name, t.step.times, t.step.tau_d) for t in found.traces]))
    axis = {"title": {"text": f"command [{'N' if linear else 'N·m'}]"}}
    yield Figure(
        "Its torque command", "What the controller asks of the actuator in the same trials.", commands, time, axis
    )
    yield from _energy(found, force)


def _energy(found: Traces, force: str) -> Iterator[Figure]:
    energies = [(t.name, t.tone.times, t.tone.energy) for t in found.traces if t.tone is not None]
    if not energies:
        return
    lowest = min(float(energy.min()) for _, _, energy in energies)
    caption = (
        f"{force} at {number(found.tone)} rad/s, where the port resists least. A passive port never gives back more "
        f"than it took: the lowest value is {number(lowest)} J."
    )
    axis = {"title": {"text": "energy [J]"}, "rangemode": "tozero"}
    yield Figure("Energy into the port", caption, list(_lines(energies)), {"title": {"text": "t [s]"}}, axis, wide=True)


def _lines(curves: list[tuple[str, Any, Any]]) -> Iterator[dict[str, Any]]:
    for k, (name, times, values) in enumerate(curves):
        yield line(name, _thinned(times), _thinned(values), PALETTE[k % len(PALETTE)], width=1 if k else 2)


def _thinned(values: NDArray[Any]) -> NDArray[Any]:
    return values[:: max(1, len(values) // KEPT)]
