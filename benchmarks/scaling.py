"""How the time of bound and search grows with the grid and with the corners, and against cvxpy used plainly."""

from __future__ import annotations

import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from robimp.synthesis import synthesize
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.grid import frequency_scale, grid
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.band import BandProgram
from robimp.synthesis.solve.basis import Basis
from robimp.synthesis.solve.cone import Failure
from robimp.synthesis.solve.nlp import Program
from robimp.synthesis.solve.places import Grids
from robimp.synthesis.solve.structure import QFilter
from robimp.synthesis.spec import parse_spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

SPEC = (Path(__file__).parents[1] / "examples" / "haninger2016.yaml").read_text(encoding="utf-8")
AROUND, TERMS = 50.0, 60
STATIONS = {
    "bound": "bound",
    "searching": "search",
    "proving": "proof",
    "re-checking": "checker",
    "simulating": "simulation",
}  # by the first word of what is said on the way
POINTS = (100, 200, 400, 800, 1600, 3200)
PLAIN_POINTS = 1600
BOX = {  # corners: what is exact, what is a range
    2: {"inertia: ±20 %": "inertia: ±0 %"},
    4: {},
    8: {"stiffness: 1.25": "stiffness: [1, 1.5]"},
    16: {"stiffness: 1.25": "stiffness: [1, 1.5]", "damping: 0.35": "damping: [0.35, 0.4]"},
    32: {
        "stiffness: 1.25": "stiffness: [1, 1.5]",
        "damping: 0.35": "damping: [0.35, 0.4]",
        "inertia: nominal": "inertia: [0.03, 0.031]",
    },
    64: {
        "stiffness: 1.25": "stiffness: [1, 1.5]",
        "damping: 0.35": "damping: [0.35, 0.4]",
        "inertia: nominal": "inertia: [0.03, 0.031]",
        "\nactuator:": "\n  actuator: {motor_inertia: ±10 %}\nactuator:",
    },
}


def setting(changes: dict[str, str] | None = None) -> Setting:
    """The reference joint with parts of its specification changed."""
    text = SPEC
    for old, new in (changes or {}).items():
        assert old in text, old
        text = text.replace(old, new, 1)
    return Setting.of(parse_spec(text))


def frequencies(joint: Setting, points: int) -> NDArray[np.float64]:
    """A third over everything, the rest around ω_B."""
    return grid(joint, around=AROUND, spread=points // 3, dense=points - points // 3)


def basis_of(joint: Setting) -> Basis:
    """The basis both ways to the bound use."""
    return Basis(AROUND, TERMS, 2, frequency_scale(joint)[1])


def bound_seconds(points: int) -> tuple[float, float]:
    """Seconds for the bound on so many points, and its ω_B [rad/s]."""
    joint = setting()
    began = time.perf_counter()
    found = BandProgram(joint, frequencies(joint, points), basis_of(joint)).largest_band(AROUND)
    return time.perf_counter() - began, np.nan if isinstance(found, Failure) else found


def plain_seconds(points: int) -> tuple[float, float]:
    """The same by cvxpy as one would write it first: bisection over the grid, the problem built at every step."""
    import cvxpy as cp

    joint = setting()
    omega = frequencies(joint, points)
    basis = joint.loop.actuator.H.at(omega)[:, None] * basis_of(joint).at(omega)
    _, triangle = np.linalg.qr(np.vstack([basis.real, basis.imag]) / np.sqrt(omega.size))
    basis = basis @ np.linalg.inv(triangle)
    passive = next(c for c in constraints(joint) if c.id == "eq12").inequalities

    def feasible(k: int) -> bool:
        x = cp.Variable(TERMS)
        X = basis @ x
        asked: list[Any] = [cp.abs(1 - X[: k + 1]) <= 0.3, cp.abs(1 - X) <= 2]
        for q in passive:
            constant, slope = q.right.constant.at(omega), q.right.slope.at(omega)
            asked.append(constant.real + cp.real(cp.multiply(slope, X)) >= 0)
        problem = cp.Problem(cp.Minimize(0), asked)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            problem.solve(solver=cp.CLARABEL)
        return problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)

    began, low, high = time.perf_counter(), 0, omega.size
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if feasible(middle) else (low, middle)
    return time.perf_counter() - began, float(omega[low])


def search_seconds(corners: int) -> float:
    """Seconds for one iteration of the search (order 4, the average of one solution from one start)."""
    joint, structure = setting(BOX[corners]), QFilter(4)
    grids = Grids.of(joint, AROUND)
    program, x = Program(joint, structure, grids, AROUND), structure.start(np.random.default_rng(0))
    program.solver(False)
    began = time.perf_counter()
    program.solve(x, 5.0, grids)
    return (time.perf_counter() - began) / max(1, program.solver(False).stats()["iter_count"])


def synth_seconds(corners: int, order: int = 2) -> dict[str, float]:
    """Processor seconds of a whole synthesis, by station; a range of impedances or motors is proven on cells."""
    text = SPEC.replace("order: 4", f"order: {order}")
    for old, new in BOX[corners].items():
        text = text.replace(old, new, 1)
    spent, began, station = dict.fromkeys(STATIONS.values(), 0.0), time.process_time(), "search"

    def progress(said: str) -> None:
        nonlocal began, station
        now = time.process_time()
        spent[station] += now - began
        began, station = now, STATIONS.get(said.split()[0].rstrip(":"), station)

    synthesize(parse_spec(text), progress)
    progress("simulating")
    return spent


def growing(of: dict[int, dict[str, float]]) -> str:
    """By how much more than in proportion the whole grows between the joints that are proven in the same way."""
    first, last = 8, max(of)
    return f"{sum(of[last].values()) / sum(of[first].values()) / (last / first):.2f}"


def report() -> str:
    """Everything as lines to print."""
    lines = [f"bound, {TERMS} terms, against points of the grid:"]
    seconds = [bound_seconds(points) for points in POINTS]
    lines += [f"{n:>7} points {s:>7.2f} s  ω_B {w:.2f} rad/s" for n, (s, w) in zip(POINTS, seconds, strict=True)]
    growth = seconds[-1][0] / seconds[0][0] / (POINTS[-1] / POINTS[0])
    lines.append(f"growth over proportional: {growth:.2f} (1 is linear)")
    own, w = bound_seconds(PLAIN_POINTS)
    plain, w_plain = plain_seconds(PLAIN_POINTS)
    lines.append(
        f"bound on {PLAIN_POINTS} points: {own:.2f} s ({w:.2f} rad/s); by cvxpy, rebuilt at every bisection step, "
        f"{plain:.2f} s ({w_plain:.2f} rad/s): ratio {plain / own:.1f}"
    )
    lines.append("search, order 4, one iteration, against corners of the box:")
    steps = {corners: search_seconds(corners) for corners in BOX}
    lines += [f"{corners:>7} corners {1e3 * s:>7.2f} ms" for corners, s in steps.items()]
    lines.append(f"growth over proportional: {steps[64] / steps[2] / 32:.2f} (1 is linear)")
    lines.append("whole synthesis, order 2, processor seconds, against corners of the box (from 8 on proven on cells):")
    whole = {corners: synth_seconds(corners) for corners in BOX}
    for corners, spent in whole.items():
        parts = ", ".join(f"{station} {s:.1f}" for station, s in spent.items())
        lines.append(f"{corners:>7} corners {sum(spent.values()):>7.1f} s: {parts}")
    lines.append(f"growth over proportional, 8 to 64: {growing(whole)} (1 is linear)")
    return "\n".join(lines)


if __name__ == "__main__":
    print(report())
