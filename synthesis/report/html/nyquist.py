"""Nyquist plots with the discs of the uncertainty."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .curves import Nyquist, nyquist
from .figure import Figure, Trace, line, rounded

if TYPE_CHECKING:
    from .study import Study

DISCS, NEAR, AROUND, FAR = 30, 5.0, 60, 50.0  # discs drawn, how near −1 their centres, corners of each; end of a curve
WINDOW = ([-2.7, 1.1], [-2.2, 1.0])  # of a Nyquist plot
CRITICAL: Trace = {
    "type": "scatter", "mode": "markers", "name": "−1", "x": [-1], "y": [0], "hoverinfo": "name",
    "marker": {"symbol": "cross", "size": 11, "color": "--red"},
}  # fmt: skip


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
    inside = study.inside & np.isfinite(found.radius)
    near = np.flatnonzero(inside & (np.abs(found.ell + 1) < NEAR))
    chosen = near[np.unique(np.linspace(0, len(near) - 1, DISCS).astype(int))] if near.size else near
    circle = np.append(np.exp(2j * np.pi * np.arange(AROUND) / (AROUND - 1)), np.nan)
    discs = (found.ell[chosen, None] + found.radius[chosen, None] * circle).ravel()
    return line(
        "W|ℓ| about ℓ", discs.real, discs.imag, "--blue", width=0.8, opacity=0.6, hoverinfo="skip", hovertemplate=None
    )
