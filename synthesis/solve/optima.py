"""What the search hands from step to step: starts, the optima of one structure, and what was proven in the end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from .nlp import Candidate
from .places import Grids
from .structure import Structure

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Counterexample(Protocol):
    """Where the proof failed: which claim, at which frequency [rad/s], whether on the objective's own band."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def omega(self) -> float: ...  # noqa: D102
    @property
    def on_band(self) -> bool: ...  # noqa: D102


Refute = Callable[[Candidate, float], Sequence[Counterexample]]  # candidate, ω_B → () when all required is proven
Again = Callable[[Candidate, Grids], tuple[Candidate, Grids] | None]  # an optimum on another grid, and the grid it took
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Start:
    """Parameters and ω_B [rad/s] to begin from; near: stay near them; votes: whether its agreement counts."""

    x: NDArray[np.float64]
    omega_B: float
    near: bool = False
    votes: bool = True


@dataclass(frozen=True)
class Found:
    """A controller every required claim was proven for, and what it took; late: the time limit ended the search."""

    candidate: Candidate
    rounds: int
    counterexamples: int
    late: bool = False


@dataclass(frozen=True)
class Optima:
    """Distinct candidates, best first, and the grid on which the best is tight. structures: of each candidate."""

    candidates: tuple[Candidate, ...]
    grids: Grids
    structures: tuple[Structure, ...] = ()

    @classmethod
    def all_of(cls, several: Sequence[Optima], grids: Grids) -> Optima:
        """Of several structures together, on the grid of the best; with none of any, on the grid given."""
        pairs = [pair for optima in several for pair in zip(optima.candidates, optima.structures, strict=True)]
        pairs.sort(key=lambda pair: -pair[0].omega_B)
        best = max((o for o in several if o.candidates), key=lambda o: o.candidates[0].omega_B, default=None)
        return cls(tuple(c for c, _ in pairs), grids if best is None else best.grids, tuple(s for _, s in pairs))
