"""A short search: whether a controller exists at all, where a bound says none does, or where advice is to be tried.

At one scale, from few starts, and of order 4 at most: every larger order contains what is found.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ..errors import UndecidedError
from ..problem.grid import frequency_scale
from ..problem.setting import Setting
from ..spec.model import Spec
from .bound import ROUGH_TERMS, bound
from .nlp import Candidate
from .optima import Counterexample, Found
from .search import Search

HIGHEST_ORDER = 4


@dataclass(frozen=True)
class Attempts:
    """Short searches. refute: the prover, for a setting; deadline: of time.monotonic()."""

    refute: Callable[[Setting, Candidate, float], Sequence[Counterexample]]
    seed: int
    deadline: float | None

    def find(self, setting: Setting, *, bounded: bool) -> Found | None:
        """What a short search finds; bounded: around the bound, of a small basis. None: nothing, or out of time."""
        controller = setting.spec.controller
        if controller.order is not None and controller.order > HIGHEST_ORDER:
            small = controller.model_copy(update={"order": HIGHEST_ORDER})
            setting = replace(setting, spec=setting.spec.model_copy(update={"controller": small}))
        low, high = frequency_scale(setting)
        try:
            limit = bound(setting, ROUGH_TERMS) if bounded else None
            search = Search(
                setting,
                lambda c, omega_B: self.refute(setting, c, omega_B),
                (low * high) ** 0.5 if limit is None else limit.omega_B,
                lambda _: None,
                ideal=None if limit is None else limit.response,
                seed=self.seed,
                deadline=self.deadline,
                short=True,
            )
            return search.run()
        except UndecidedError:
            return None

    def reached(self, spec: Spec) -> float | None:
        """ω_B [rad/s] of what is found for a specification. Raises: UndecidedError where there was no time to look."""
        found = self.find(Setting.of(spec), bounded=True)
        if found is None and self.deadline is not None and time.monotonic() > self.deadline:
            raise UndecidedError("out of time")
        return None if found is None else found.candidate.omega_B
