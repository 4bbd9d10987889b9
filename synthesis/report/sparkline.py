"""A Bode plot in three lines of text: what is left of a disturbance, and the least resistance of the port."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from rich.text import Text

from ..problem.grid import frequency_scale
from ..problem.setting import Setting
from .html.curves import filters, least_resistance
from .html.words import number, units

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from rich.console import Console

    from ...models.controller import Compensator
    from ..spec.model import Polynomials, Spec

    Real = NDArray[np.float64]

BLOCKS, BELOW_ZERO, UNKNOWN = "▁▂▃▄▅▆▇█", "×", " "
NAMES, WIDEST, NARROWEST = 10, 64, 16  # columns of the names, most and least of the curve
FIGURES = 34  # columns left for the extremes behind a curve
SAMPLES, SPAN = 12, 50.0  # frequencies in one column; the plot reaches from ω_B/50 to 50 ω_B


@dataclass(frozen=True)
class Glance:
    """A joint, its compensator and the frequencies of the plot (n,) [rad/s]."""

    setting: Setting
    compensator: Compensator
    omega: Real


@np.errstate(all="ignore")
def bode_lines(spec: Spec, coefficients: Polynomials, omega_B: float, proven: bool, to: Console) -> Iterator[Text]:
    """|1−Q̃| and the least Re(Z/jω) over log ω, worst of each column; nothing where the output is not Unicode.

    Green where the attenuation is proven, red and × where the port gives energy back. omega_B [rad/s], 0 if unknown.
    """
    width = min(WIDEST, to.width - NAMES - FIGURES)
    if width < NARROWEST or not to.encoding.lower().startswith("utf"):
        return
    setting = Setting.of(spec)
    low, high = frequency_scale(setting)
    middle = omega_B or (low * high) ** 0.5
    omega = np.geomspace(middle / SPAN, middle * SPAN, width * SAMPLES)
    glance = Glance(setting, setting.compensator(coefficients), omega)
    left = np.abs(next(filters(glance))[1]).reshape(width, SAMPLES).max(axis=1)
    resistance = least_resistance(glance).reshape(width, SAMPLES).min(axis=1)
    last = omega.reshape(width, SAMPLES)[:, -1]
    good = [proven and bool(w <= omega_B) for w in last]
    yield _line("|1−Q̃|", left, ["green" if g else "" for g in good], _extremes(left, ""))
    unit = units(spec)["damping"]
    yield _line("Re(Z/jω)", resistance, ["red" if r < 0 else "" for r in resistance], _extremes(resistance, unit))
    yield _axis(omega, omega_B, width)


def _line(name: str, values: Real, styles: list[str], extremes: str) -> Text:
    """Blocks as high as the values, from 0 to the largest."""
    top = np.nanmax(values, initial=0.0) or 1.0
    text = Text(name.ljust(NAMES + name.count("\u0303")), no_wrap=True, overflow="crop")
    for value, style in zip(values, styles, strict=True):
        text.append(_block(float(value), float(top)), style)
    return text.append(f"  {extremes}")


def _block(value: float, top: float) -> str:
    if not np.isfinite(value):
        return UNKNOWN
    return BELOW_ZERO if value < 0 else BLOCKS[min(int(len(BLOCKS) * value / top), len(BLOCKS) - 1)]


def _extremes(values: Real, unit: str) -> str:
    low, high = (float(f"{value:.3g}") for value in (np.nanmin(values), np.nanmax(values)))
    return f"{number(low)} … {number(high)} {unit}".rstrip()


def _axis(omega: Real, omega_B: float, width: int) -> Text:
    """The ends of the axis and, in its middle, the bandwidth."""
    ends = [f"{w:.3g}" for w in (omega[0], omega[-1])]
    middle = f"↑ {omega_B:.4g}" if omega_B else ""
    line = list(" " * width)
    for start, word in ((0, ends[0]), (width // 2, middle), (width - len(ends[1]), ends[1])):
        line[start : start + len(word)] = word
    return Text("ω".ljust(NAMES) + "".join(line)[:width] + "  rad/s", style="dim", no_wrap=True, overflow="crop")
