"""The map as a figure: coloured by proven bandwidth, what is not proven hatched by its cause, the line K_imp = K_sp."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from .cell import Status
from .result import STIFFNESS, Map

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .axis import Axis

HATCHES = ("///", "\\\\\\", "xxx", "...", "ooo", "---", "+++")
SHADE = {Status.INFEASIBLE: "0.80", Status.REFUTED: "0.80", Status.UNDECIDED: "0.92", Status.ERROR: "#f4b6b0"}
UNITS = {
    "rotary": {"inertia": "kg·m²", "damping": "N·m·s/rad", "stiffness": "N·m/rad"},
    "linear": {"inertia": "kg", "damping": "N·s/m", "stiffness": "N/m"},
}
NAMES = {STIFFNESS: "stiffness $K_{imp}$", "impedance.damping": "damping $B_{imp}$"}


def figure(plane_map: Map, form: str) -> bytes:
    """The figure's file; form: svg or png."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(7.2, 5.2), layout="constrained")
    FigureCanvasAgg(drawn)
    ax = drawn.add_subplot()
    rows, columns = (_edges(axis) for axis in plane_map.plane.axes)
    colours = ax.pcolormesh(
        columns, rows, np.ma.masked_invalid(plane_map.bandwidth()), vmin=0, cmap="viridis", rasterized=True
    )
    drawn.colorbar(colours, label=r"proven bandwidth $\omega_B$ [rad/s]")
    legend = [*_hatch(ax, plane_map, rows, columns), *_spring(ax, plane_map)]
    vertical, horizontal = plane_map.plane.axes
    motion = plane_map.plane.spec.motion
    ax.set(yscale=_scale(vertical), ylabel=_label(vertical, motion))
    ax.set(xscale=_scale(horizontal), xlabel=_label(horizontal, motion))
    ax.set_title(plane_map.plane.spec.name)
    if legend:
        drawn.legend(handles=legend, loc="outside lower center", fontsize="small", ncols=2)
    file = io.BytesIO()
    drawn.savefig(file, format=form, dpi=150, metadata={"Date": None} if form == "svg" else {})
    return file.getvalue()


def _edges(axis: Axis) -> NDArray[np.float64]:
    """Borders of the cells, half-way between the values. (n+1,)."""
    values = np.log(axis.floats) if axis.logarithmic else np.array(axis.floats)
    middle = (values[1:] + values[:-1]) / 2
    edges = np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])
    return np.asarray(np.exp(edges) if axis.logarithmic else edges)


def _hatch(ax: Any, plane_map: Map, rows: NDArray[np.float64], columns: NDArray[np.float64]) -> list[Any]:
    """Returns the legend's entries."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Patch, Rectangle

    legend: list[Any] = []
    for k, (cause, example) in enumerate(plane_map.causes.items()):
        cells = [c.index for c in plane_map.cells.values() if c.cause == cause and c.status is not Status.PROVEN]
        corners = [
            Rectangle((columns[j], rows[i]), columns[j + 1] - columns[j], rows[i + 1] - rows[i]) for i, j in cells
        ]
        look: dict[str, Any] = {
            "hatch": HATCHES[k % len(HATCHES)],
            "facecolor": SHADE[example.status],
            "edgecolor": "0.45",
        }
        ax.add_collection(PatchCollection(corners, linewidth=0, **look))
        said = example.status.value if cause == example.status.value else f"{example.status.value}: {cause}"
        legend.append(Patch(label=said, linewidth=0, **look))
    return legend


def _spring(ax: Any, plane_map: Map) -> list[Any]:
    """The line K_imp = K_sp, where it crosses the map. Returns the legend's entries."""
    spring, upright = plane_map.spring, plane_map.plane.axes[1].key == STIFFNESS
    low, high = ax.get_xlim() if upright else ax.get_ylim()
    if spring is None or not low <= float(spring) <= high:
        return []
    line = ax.axvline if upright else ax.axhline
    return [line(float(spring), color="crimson", linestyle="--", label="$K_{imp} = K_{sp}$")]


def _scale(axis: Axis) -> str:
    return "log" if axis.logarithmic else "linear"


def _label(axis: Axis, motion: str) -> str:
    unit = UNITS[motion].get(axis.key.rsplit(".", 1)[-1].removeprefix("spring_").removeprefix("motor_"))
    return NAMES.get(axis.key, axis.key) + (f" [{unit}]" if unit else "")
