"""What a plot is: plain data for plotly.js, colours by name so that the page can be light, dark or printed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.floating[Any]] | Sequence[float | None]

DIGITS = 5  # of plotted numbers: finer than a screen
PALETTE = ("--blue", "--orange", "--green", "--purple", "--cyan", "--pink")  # variables of the style sheet

EVERYWHERE: dict[str, Any] = {
    "type": "rect", "xref": "paper", "yref": "paper", "x0": 0, "x1": 1, "y0": 0, "y1": 1, "line": {"width": 0},
    "fillcolor": "--proven", "layer": "below",
}  # fmt: skip

Trace = dict[str, Any]


@dataclass(frozen=True)
class Figure:
    """One plot: its title, what to see in it, traces and layout for plotly.js."""

    title: str
    caption: str
    traces: list[Trace]
    x: dict[str, Any]
    y: dict[str, Any]
    shapes: list[dict[str, Any]] = field(default_factory=list)
    annotations: list[dict[str, Any]] = field(default_factory=list)
    wide: bool = False
    square: bool = False
    tall: bool = False

    @property
    def data(self) -> dict[str, Any]:
        """What the page's script draws."""
        return {
            "traces": self.traces,
            "layout": {"xaxis": self.x, "yaxis": self.y, "shapes": self.shapes, "annotations": self.annotations},
        }


def line(name: str, x: Values, y: Values, colour: str, **more: Any) -> Trace:
    """A curve. x, y: (n,), values that are no number are gaps. more: `width`, `dash`, and plotly's own of a trace."""
    style = {"color": colour, "width": more.pop("width", 2), "dash": more.pop("dash", "solid"), "simplify": False}
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": rounded(x), "y": rounded(y), "line": style,
        "hovertemplate": "%{y:.4g}", **more,
    }  # fmt: skip


def level(y: float, name: str, x: Sequence[float], colour: str) -> Trace:
    """A horizontal line over the interval x = (low, high)."""
    return line(name, x, [y, y], colour, width=1.5, dash="dash", hoverinfo="skip", hovertemplate=None)


def cross(name: str, x: float, y: float) -> Trace:
    """The point where the next level fails."""
    marker = {"symbol": "x", "size": 10, "color": "--red"}
    return {
        "type": "scatter", "mode": "markers", "name": name, "x": rounded([x]), "y": rounded([y]), "marker": marker,
        "hovertemplate": "%{x:.5g} rad/s: %{y:.5g}",
    }  # fmt: skip


def ticks_of_grid(omega: Values) -> Trace:
    """The frequencies of the plot's grid as ticks along its lower edge, on an axis of their own."""
    x = [None if k == 2 else w for w in rounded(omega) for k in range(3)]
    y = [(0, 0.025, None)[k % 3] for k in range(len(x))]
    return {
        "type": "scatter", "mode": "lines", "name": "grid", "x": x, "y": y, "yaxis": "y2",
        "hoverinfo": "skip", "showlegend": False, "line": {"color": "--muted", "width": 0.6},
    }  # fmt: skip


def edge_note(text: str, *, left: bool) -> dict[str, Any]:
    """A note inside the upper corner of a plot that points beyond its edge."""
    side, x = ("left", 0) if left else ("right", 1)
    return {
        "text": f"← {text}" if left else f"{text} →", "xref": "paper", "yref": "paper", "x": x, "y": 0.99,
        "xanchor": side, "yanchor": "top", "showarrow": False, "font": {"color": "--red", "size": 11},
    }  # fmt: skip


def band(low: float, high: float) -> dict[str, Any]:
    """The tint of what is proven, from low to high [rad/s]."""
    return EVERYWHERE | {"xref": "x", "x0": low, "x1": high}


def frequency(view: tuple[float, float]) -> dict[str, Any]:
    """The axis of frequencies, opened at `view` [rad/s]."""
    return {"type": "log", "title": {"text": "ω [rad/s]"}, "range": [float(np.log10(w)) for w in view]}


def rounded(values: Iterable[Any]) -> list[float | None]:
    """Plot data with few digits; None for what is not finite."""
    return [None if v is None or not np.isfinite(v) else float(f"{float(v):.{DIGITS}g}") for v in values]


def opened(
    values: Sequence[NDArray[np.float64]], *, log: bool, include: Sequence[float] = (), outliers: float = 2.0
) -> list[float]:
    """Limits of an axis for values, without extreme ones of the outermost per cent, with some air; logs where `log`."""
    every = np.concatenate([v[np.isfinite(v)] for v in values])
    if log:
        every = np.log10(every[every > 0])
        include = [float(np.log10(v)) for v in include if v > 0]
    if not every.size:
        return [-1.0, 1.0]
    low, high = np.percentile(every, [outliers, 100 - outliers])
    most = max(high - low, 1e-9)  # what sticks out by less than this is shown, too
    low, high = max(low - most, every.min()), min(high + most, every.max())
    low, high = min([low, *include]), max([high, *include])
    air = 0.08 * (high - low) or 0.5
    return [float(low - air), float(high + air)]
