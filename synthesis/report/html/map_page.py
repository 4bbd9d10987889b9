"""The page about a map: the picture of its plane, cuts through it, why cells are not proven."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ExitCode
from ...storage import write_atomic
from .figure import PALETTE, Figure, Trace, line, rounded
from .page import rendered
from .recorded import Axis, RecordedMap
from .words import described, floor, real, symbols

DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")  # one for each cut: some coincide
MOST_APART = 40  # cells on a side between which there are gaps: more of them are too small
MOST_LISTED, MOST_CUTS, MOST_TICKS, LONGEST = 400, 6, 12, 160  # cells in a table; lines; ticks; letters on hover
OMEGA_B = symbols("ω_B [rad/s]")  # the plotting library knows these marks of HTML
SIGNS = ("x-thin", "circle-open", "diamond-open", "square-open", "triangle-up-open", "cross-thin", "star-open")
FILL = {"refuted": 0, "infeasible": 0, "undecided": 1, "error": 2}
FILLS = ("--bad-soft", "--undecided-soft", "--red")


def write_map_report(data: bytes, name: str, path: Path, progress: Callable[[str], None] = lambda _: None) -> ExitCode:
    """Write one HTML file about the bytes of a `map.json`; name: to show. Returns the map's own outcome.

    Raises: InputError for bytes that are no map, or a path that cannot be written.
    """
    progress(f"drawing {name}")
    found = RecordedMap.of(name, data)
    write_atomic(path, map_page(found).encode())
    return found.exit_code


def map_page(found: RecordedMap) -> str:
    """The HTML."""
    counted = ", ".join(f"{n} {status}" for status, n in found.counts.items())
    figures, best = [picture(found), *cuts(found)], found.best
    facts = [("cells proven", f"{found.counts.get('proven', 0)} of {len(found.cells)}")]
    if best is not None:
        where = f"largest bandwidth, proven at {found.at(best)}"
        facts.insert(0, (where, f"ω_B ≥ {floor(found.cells[best].omega_B or Fraction(0))} rad/s"))
    return rendered(
        "map.html", figures, title=f"map of {found.spec.name}", heading=f"Map of {found.spec.name}",
        subtitle="Proven bandwidth over a plane of two keys: one synthesis, or one certification, for each cell.",
        map=found, errors="error" in found.counts, counted=counted, facts=facts, figures=figures,
        causes=[_cause(found, *row) for row in found.causes], described=described(found.spec),
        listed=list(_listed(found)) if len(found.cells) <= MOST_LISTED else [],
        provenance=[("map", found.file), ("SHA-256 over its specifications", found.digest)],
    )  # fmt: skip


def picture(found: RecordedMap) -> Figure:
    """The plane coloured by proven bandwidth; what is not proven is marked by its cause."""
    vertical, horizontal = found.axes
    shape = len(vertical.values), len(horizontal.values)
    omega_B, fill = (np.full(shape, np.nan) for _ in range(2))
    for index, cell in found.cells.items():
        omega_B[index] = np.nan if cell.omega_B is None else real(cell.omega_B)
        fill[index] = FILL.get(cell.status, np.nan)
    top = 1.0 if found.best is None else real(found.cells[found.best].omega_B)
    place = {"x": rounded(_edges(horizontal)), "y": rounded(_edges(vertical))}
    said = [[_said(found, (i, j)) for j in range(shape[1])] for i in range(shape[0])]
    heat: Trace = {"type": "heatmap", **place, "hovertext": said, "hovertemplate": "%{hovertext}<extra></extra>"}
    heat |= {"xgap": 1, "ygap": 1} if max(shape) <= MOST_APART else {}
    steps = [[end, colour] for k, colour in enumerate(FILLS) for end in (k / len(FILLS), (k + 1) / len(FILLS))]
    bar = {"title": {"text": OMEGA_B, "side": "right"}, "thickness": 14, "outlinewidth": 0}
    proven = {
        **heat,
        "z": _rows(omega_B),
        "zmin": 0,
        "zmax": top,
        "colorscale": "Viridis",
        "colorbar": bar,
        "name": "proven",
    }
    failed = {**heat, "z": _rows(fill), "zmin": -0.5, "zmax": 2.5, "colorscale": steps, "showscale": False}
    shapes, notes = _spring(found)
    return Figure(
        "Proven bandwidth ω_B", "Point at a cell for its values, and for why it is not proven. " + _advice(found),
        [proven, failed, *_signs(found)], _layout(horizontal), _layout(vertical), shapes, notes, wide=True, tall=True,
    )  # fmt: skip


def cuts(found: RecordedMap) -> Iterator[Figure]:
    """ω_B along the second axis at a few values of the first."""
    vertical, horizontal = found.axes
    rows = np.unique(np.linspace(0, len(vertical.values) - 1, MOST_CUTS).astype(int)).tolist()
    traces = []
    for colour, dash, i in zip(PALETTE, DASHES, rows, strict=False):
        cells = [found.cells[i, j].omega_B for j in range(len(horizontal.values))]
        values = [None if value is None else real(value) for value in cells]
        if any(cells):
            trace = line(f"{vertical.values[i]:.4g}", list(horizontal.values), values, colour, dash=dash)
            traces.append(trace | {"mode": "lines+markers", "marker": {"size": 5, "color": colour}})
    if traces:
        caption = f"Each line: one value of {vertical.label}. A gap is a cell in which nothing is proven."
        y = {"title": {"text": OMEGA_B}, "rangemode": "tozero"}
        yield Figure("Cuts through the plane", caption, traces, _layout(horizontal), y, wide=True)


def _edges(axis: Axis) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Borders of the cells, half-way between the values. (n+1,)."""
    values = np.log(axis.values) if axis.log else np.array(axis.values)
    middle = (values[1:] + values[:-1]) / 2
    edges = np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])
    return np.asarray(np.exp(edges) if axis.log else edges)


def _layout(axis: Axis) -> dict[str, Any]:
    low, high = _edges(axis)[[0, -1]]
    ends = [float(np.log10(low)), float(np.log10(high))] if axis.log else [float(low), float(high)]
    layout: dict[str, Any] = {
        "type": "log" if axis.log else "linear",
        "title": {"text": symbols(axis.label)},
        "range": ends,
        "showgrid": False,
    }
    if axis.log and len(axis.values) <= MOST_TICKS:
        text = [f"{value:.3g}" for value in axis.values]
        layout |= {"tickmode": "array", "tickvals": list(axis.values), "ticktext": text}
    return layout


def _rows(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[list[float | None]]:
    return [rounded(row) for row in values]


def _signs(found: RecordedMap) -> Iterator[Trace]:
    """A sign in the middle of every cell that is not proven, one kind for each cause, named in the legend."""
    vertical, horizontal = found.axes
    for k, (status, cause, cells) in enumerate(found.causes):
        name = status if cause in ("", status) else f"{status}: {cause}"
        marker = {
            "symbol": SIGNS[k % len(SIGNS)],
            "size": 8,
            "color": "--text",
            "line": {"width": 1.4, "color": "--text"},
        }
        yield {
            "type": "scatter", "mode": "markers", "name": f"{name} ({len(cells)})", "marker": marker,
            "x": [horizontal.values[j] for _, j in cells], "y": [vertical.values[i] for i, _ in cells],
            "hovertext": [_said(found, index) for index in cells], "hovertemplate": "%{hovertext}<extra></extra>",
        }  # fmt: skip


def _said(found: RecordedMap, index: tuple[int, int]) -> str:
    """What a cell says on hover. Angle brackets would be taken for the plotting library's own marks."""
    cell = found.cells[index]
    why = cell.reason if len(cell.reason) <= LONGEST else cell.reason[: LONGEST - 1] + "…"
    end = f"ω_B ≥ {floor(cell.omega_B)} rad/s" if cell.omega_B is not None else f"{cell.status}: {why or cell.cause}"
    lines = [found.at(index), *(end[k : k + 80] for k in range(0, len(end), 80))]
    return "<br>".join(text.replace("<", "‹").replace(">", "›") for text in lines)


def _spring(found: RecordedMap) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The line K_imp = K_sp and its name, where it crosses the map."""
    if found.spring is None:
        return [], []
    upright = found.axes[1].key == "impedance.stiffness"
    edges = _edges(found.axes[1 if upright else 0])
    if not edges[0] <= found.spring <= edges[-1]:
        return [], []
    along, across = ("y", "x") if upright else ("x", "y")
    shape = {
        "type": "line", f"{across}0": found.spring, f"{across}1": found.spring, f"{along}0": 0, f"{along}1": 1,
        f"{along}ref": "paper", f"{across}ref": across, "line": {"color": "--red", "width": 2, "dash": "dash"},
    }  # fmt: skip
    log = found.axes[1 if upright else 0].log
    place = float(np.log10(found.spring)) if log else found.spring
    note = {
        "text": symbols("K_imp = K_sp"), across: place, along: 0.01, f"{along}ref": "paper", f"{across}ref": across,
        "showarrow": False, "xanchor": "left", "yanchor": "bottom", "font": {"color": "--red", "size": 12},
        "bgcolor": "--page",
    }  # fmt: skip
    return [shape], [note]


def _advice(found: RecordedMap) -> str:
    return "Signs: nothing is proven there." if found.causes else "Every cell is proven."


def _cause(found: RecordedMap, status: str, cause: str, cells: list[tuple[int, int]]) -> dict[str, Any]:
    example = found.cells[cells[0]]
    return {
        "status": status, "cause": cause, "count": len(cells), "at": found.at(cells[0]), "reason": example.reason
    }  # fmt: skip


def _listed(found: RecordedMap) -> Iterator[dict[str, Any]]:
    for index, cell in sorted(found.cells.items()):
        values = [f"{axis.values[k]:.6g}" for axis, k in zip(found.axes, index, strict=True)]
        omega_B = "" if cell.omega_B is None else floor(cell.omega_B)
        yield {"sets": values, "status": cell.status, "omega_B": omega_B, "cause": cell.cause}
