"""The controller a specification asks for: what is impossible, the bound, and the search with its proofs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any

from .certificate.claim import Claim
from .certificate.claims import Counterexample, certify, counterexamples
from .certificate.outcome import Outcome
from .errors import UndecidedError
from .problem.grid import frequency_scale
from .problem.setting import Setting
from .spec.model import Polynomials, Spec

if TYPE_CHECKING:
    from .solve.attempt import Attempts
    from .solve.bound import Bound
    from .solve.nlp import Candidate

Progress = Callable[[str], None]
Proofs = dict[tuple[Spec, Polynomials], tuple[Claim, ...]]  # claims about controllers that the search has had certified
Starts = tuple[tuple[Polynomials, float], ...]  # controllers of similar joints with their ω_B [rad/s]


@dataclass
class Shared:
    """What searches for controllers of several orders on one joint have in common: the bound, and lower orders."""

    bound: Bound | None = None
    known: dict[Any, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Design:
    """One search for a controller. deadline: of time.monotonic(); advise: try what is advised where there is none."""

    setting: Setting
    progress: Progress
    proofs: Proofs
    shared: Shared
    seed: int
    deadline: float | None
    advise: bool

    def run(self, starts: Starts) -> tuple[Candidate, Bound | None, bool]:
        """What was found and proven, under which bound, and whether the time limit ended the search.

        Raises: InfeasibleError with the constraint and frequency; UndecidedError when nothing is proven.
        """
        from .solve.attempt import Attempts
        from .solve.infeasible import impossible
        from .solve.search import Search

        attempts = Attempts(lambda s, c, omega_B: refuting(s, c, omega_B, {}), self.seed, self.deadline)
        if (reason := impossible(self.setting, attempts.reached if self.advise else None)) is not None:
            raise reason.error()
        limit, (low, high) = self._bound(attempts), frequency_scale(self.setting)
        expected = limit.omega_B if limit is not None else max((w for _, w in starts), default=(low * high) ** 0.5)
        search = Search(
            self.setting,
            lambda c, omega_B: refuting(self.setting, c, omega_B, self.proofs),
            expected,
            self.progress,
            ideal=None if limit is None else limit.response,
            seed=self.seed,
            deadline=self.deadline,
            starts=starts,
            known=self.shared.known,
        )
        found = search.run() or (attempts.find(self.setting, bounded=True) if limit is not None else None)
        if found is None:
            hint = "even the convex bound finds none" if limit is None else f"{limit.text}{limit.binds}"
            raise UndecidedError(
                f"no controller of this structure was found that can be proven ({hint}); try another order, a smaller "
                "uncertainty, more damping in the impedance, or a larger attenuation"
            )
        return found.candidate, self._above(limit, found.candidate.omega_B), found.late

    def _bound(self, attempts: Attempts) -> Bound | None:
        """The convex bound; None where there is none to be had, though a controller may exist."""
        from .solve.bound import bound
        from .solve.infeasible import unattainable

        if self.shared.bound is not None:
            return self.shared.bound
        unmet = None
        try:
            self.shared.bound = bound(self.setting, progress=self.progress)
            if self.shared.bound is None and attempts.find(self.setting, bounded=False) is None:
                unmet = unattainable(self.setting, attempts.reached if self.advise else None)
        except UndecidedError as error:  # the search does without
            self.progress(str(error))
        if unmet is not None:
            raise unmet.error()
        return self.shared.bound

    def _above(self, limit: Bound | None, omega_B: float) -> Bound | None:
        """The bound, with more terms where it had too few to be above what was found."""
        from .solve.bound import bound

        if limit is None or not limit.limited or limit.omega_B >= omega_B:
            return limit
        limit = bound(self.setting, 2 * limit.terms, self.progress)
        self.shared.bound = limit if limit is not None and limit.omega_B >= omega_B else None
        return self.shared.bound


def refuting(setting: Setting, c: Candidate, omega_B: float, proofs: Proofs) -> tuple[Counterexample, ...]:
    """Where the required claims fail; on cells a margin is harder to prove than the level, so all claims are asked."""
    setting = setting.resolved(None if c.corner is None else c.corner.omega)
    C = setting.compensator(c.coefficients)
    found = counterexamples(setting, C, omega_B)
    if found or setting.polynomial:
        return found
    claims = proofs[setting.spec, c.coefficients] = certify(setting, C)
    short = (claim.id for claim in claims if claim.required and claim.status is not Outcome.PROVEN)
    return tuple(Counterexample(id, inf, False) for id in short)
