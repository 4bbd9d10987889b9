"""Bandwidth against the order of the controller, under the bound: a table and bars in the terminal, a figure as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

WIDTH = 50  # characters of the longest bar


@dataclass(frozen=True)
class OfOrder:
    """What came of one order: proven ω_B [rad/s], or why there is none; the time limit to check it with [s].

    force_filter: the corner [rad/s] that was found, where it was free.
    """

    order: int
    omega_B: float | None
    seconds: float
    reason: str = ""
    check_limit: int | None = None
    force_filter: float | None = None


def listed(rows: Sequence[OfOrder], bound: float | None) -> dict[str, Any]:
    """For scripts. bound [rad/s]."""
    return {"bound": bound, "orders": [asdict(row) for row in rows]}


def show_orders(rows: Sequence[OfOrder], bound: float | None, to: Console) -> None:
    """One bar for each order, as long as its ω_B, and the bound below."""
    top = max([row.omega_B or 0.0 for row in rows] + [bound or 0.0]) or 1.0
    to.print("[bold]order   proven ω_B   of the bound[/]")
    for row in rows:
        if row.omega_B is None:
            to.print(f"{row.order:>5}            –   {row.reason}")
            continue
        share = "" if bound is None else f"{100 * row.omega_B / bound:.1f} %"
        bar = "█" * round(WIDTH * row.omega_B / top)
        behind = "" if row.force_filter is None else f", force filter {row.force_filter:.6g} rad/s"
        to.print(f"{row.order:>5}   {row.omega_B:>10.4f}   {share:>12}  {bar}  {row.seconds:.1f} s{behind}")
    if bound is not None:
        to.print(f"bound   {bound:>10.4f}                 {'░' * round(WIDTH * bound / top)}")


def figure(rows: Sequence[OfOrder], bound: float | None, name: str) -> bytes:
    """The same as an SVG image."""
    from matplotlib.figure import Figure

    found = [(row.order, row.omega_B) for row in rows if row.omega_B is not None]
    drawing = Figure(figsize=(6, 3.6), layout="constrained")
    axes = drawing.subplots()
    axes.plot([order for order, _ in found], [omega_B for _, omega_B in found], "o-", label="proven")
    if bound is not None:
        axes.axhline(bound, color="0.4", linestyle="--", label="bound, any order")
    axes.set(xlabel="order of the controller", ylabel="ω_B [rad/s]", title=name, ylim=(0, None))
    axes.set_xticks([row.order for row in rows])
    axes.legend(loc="lower right")
    image = BytesIO()
    drawing.savefig(image, format="svg", metadata={"Date": None})
    return image.getvalue()
