"""Spec → Problem → Candidate → Certificate → Verdict, with the simulation beside it: the stations in order."""

from __future__ import annotations

import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from ..models.controller import Compensator
from .agreement import Agreement, compare
from .certificate.claim import Claim
from .certificate.claims import certify
from .certificate.document import document, encoded, robustly_stable, verdict
from .certificate.outcome import Outcome
from .certificate.stability import unstable_behind_ideal
from .check import Verdict
from .design import Design, Progress, Proofs, Shared
from .errors import ExitCode, InputError, RefutedError, RobimpError, UndecidedError
from .interruption import demand_none, demanding
from .problem.grid import frequency_scale
from .problem.setting import Setting
from .recheck import VERDICT_CODE, advised_limit, recheck
from .report.cards import result_card
from .report.terminal import decimal
from .simulation import SampledComparison, Trials, sampled_comparison, verify
from .spec.demands import FLOAT32
from .spec.model import Polynomials, Spec

if TYPE_CHECKING:
    from .solve.bound import Bound
    from .solve.corner import Corner


FLOAT_DECADES = 1e9  # ratio of frequencies beyond which poles in floating point mean little
SMALLEST, LARGEST = Fraction(1, 2**126), (2 - Fraction(1, 2**23)) * 2**127  # normal numbers of single precision
NOT_WELL_POSED = {  # at each end: what, and what to do
    "locked": ("1 + HCF is", "lower the numerator's degree, or give controller.filters a force corner"),
    "free": (
        "in free motion 1 + HA/(1/Ĝ + Z_a), A = CF G_imp − F_d (1/Ĝ − G_imp), is",
        "let H, or C and F_d, decay: a denominator of higher degree, corners in controller.filters",
    ),
}


@dataclass(frozen=True)
class Result:
    """A certified controller: what was found, what was proven, what the checker and the simulation said of it."""

    spec: Spec  # with the number that was found in the place of a free corner
    coefficients: Polynomials
    claims: tuple[Claim, ...]
    bound: Bound | None
    certificate: dict[str, Any]
    checked: Verdict
    check_seconds: float
    trials: Trials
    agreement: Agreement
    sampled: SampledComparison
    seconds: float
    corner: Corner | None = None  # that number
    late: bool = False  # the time limit ended the search

    @property
    def outcome(self) -> Outcome:
        """Whether everything the specification requires is proven."""
        return verdict(self.claims)

    @property
    def exit_code(self) -> ExitCode:
        """The process exit code of this outcome."""
        return VERDICT_CODE[self.outcome]

    @property
    def check_limit(self) -> int:
        """The time limit [s] to check this certificate with, also on a slower machine; `robimp check` allows 60."""
        return advised_limit(self.check_seconds)

    @property
    def robust(self) -> bool:
        """Whether the proven claims make every load of the stated uncertainty stable."""
        return robustly_stable(Setting.of(self.spec), self.claims)

    @property
    def unstable_behind_ideal(self) -> tuple[str, ...]:
        """Required equations that speak of an ideal actuator, behind which the nominal joint is not stable."""
        setting = Setting.of(self.spec)
        C, required = setting.compensator(self.coefficients), (claim for claim in self.claims if claim.required)
        return tuple(c.equation for c in required if unstable_behind_ideal(setting, C, (c.id, c.form)))

    @property
    def omega_B(self) -> Fraction:
        """Proven bandwidth [rad/s]."""
        return next(claim.margin for claim in self.claims if claim.id == "bandwidth") or Fraction(0)

    @property
    def Q(self) -> Polynomials | None:
        """The filter of a disturbance observer; None for dynamic-error feedback. `.to_control()` for `control`."""
        return self.coefficients if self.spec.controller.type == "dob" else None

    @property
    def C(self) -> Polynomials:
        """The compensator C in the loop, Q/(1−Q) or C_imp, as the certificate states it."""
        written = self.certificate["controller"]["C"]
        return Polynomials(**{side: tuple(map(Fraction, coefficients)) for side, coefficients in written.items()})

    def __repr__(self) -> str:
        found = f", ω_B ≥ {decimal(self.omega_B)} rad/s" if self.outcome is Outcome.PROVEN else ""
        return f"<Result {self.spec.name}: {self.outcome.name}{found}, {len(self.claims)} claims>"

    def _repr_html_(self) -> str:
        return result_card(self)

    def certificate_bytes(self) -> bytes:
        """The certificate file's content, as it was checked."""
        return encoded(self.certificate)


def synthesize(
    spec: Spec,
    progress: Progress = lambda _: None,
    *,
    time_limit: float | None = None,
    starts: Sequence[tuple[Polynomials, float]] = (),
    shared: Shared | None = None,
    seed: int = 0,
    advise: bool = True,
) -> Result:
    """Find (or take) a controller, prove every claim about it, have the proof re-checked, and simulate it.

    time_limit [s] bounds the search. starts: controllers of similar joints with their ω_B [rad/s],
    for the search to begin from as well. shared: what an earlier search on the same joint, of another order, has found.
    seed: of the search's random starts; with the same one it finds the same digits. advise: try what is advised.
    Raises: InfeasibleError with the constraint and frequency; UndecidedError when the
    search ends without a proven controller; InputError for a controller that cannot be realized; RobimpError when
    prover, checker and simulation disagree.
    """
    began = time.monotonic()
    progress = demanding(progress)
    setting = setting_of(spec)
    proofs: Proofs = {}
    if spec.controller.coefficients is None:
        deadline = None if time_limit is None else began + time_limit
        search = Design(setting, progress, proofs, Shared() if shared is None else shared, seed, deadline, advise)
        candidate, limit, late = search.run(tuple(starts))
        coefficients, corner = candidate.coefficients, candidate.corner
    else:
        coefficients, corner, limit, late = spec.controller.coefficients, None, None, False
    setting = setting.resolved(None if corner is None else corner.omega)
    spec, C = setting.spec, realizable(setting, coefficients)
    progress("proving every claim on the whole axis")
    claims = proofs.get((spec, coefficients)) or certify(setting, C)
    bound = None if limit is None or not limit.limited else Fraction(f"{limit.omega_B:.6g}")
    progress("re-checking the certificate independently")
    claims, certificate, checked, checking = recheck(
        setting, claims, lambda c: document(setting, coefficients, c, bound=bound, producer=_producer())
    )
    progress("simulating the physics")
    compensator = (certificate["controller"]["C"]["numerator"], certificate["controller"]["C"]["denominator"])
    numbers = tuple(tuple(Fraction(c) for c in part) for part in compensator)
    trials = verify(spec, (numbers[0], numbers[1]), quick=True)
    agreement = compare(setting, C, claims, trials)
    low, high = frequency_scale(setting)
    if agreement.contradictions and high > FLOAT_DECADES * low:
        raise UndecidedError(
            f"the joint's own frequencies span {low:.1g} to {high:.1g} rad/s, too far apart for a simulation in "
            f"floating point to confirm the proof ({agreement.contradictions[0]}); check the units"
        )
    if agreement.contradictions:
        raise RobimpError(f"simulation and proof disagree, so nothing is certified: {agreement.contradictions[0]}")
    if agreement.unstable and verdict(claims) is Outcome.PROVEN:
        trial = agreement.unstable[0]
        load, rest = trial.load, (("impedance", trial.impedance), ("actuator", trial.actuator))
        of_ranges = "".join(f", {name} {value}" for name, value in rest if value is not None)
        raise RefutedError(
            f"unstable with inertia {float(load.inertia):.4g}, damping {float(load.damping):.4g}, stiffness "
            f"{float(load.stiffness):.4g}{of_ranges}, inside the stated uncertainty, which no required claim covers; "
            "add eq18: {form: half-plane, coupling: physical} or eq12: {form: structured}"
        )
    sampled = sampled_comparison(spec, (numbers[0], numbers[1]))
    demand_none()
    seconds = time.monotonic() - began
    return Result(
        spec,
        coefficients,
        claims,
        limit,
        certificate,
        checked,
        checking,
        trials,
        agreement,
        sampled,
        seconds,
        corner,
        late,
    )


def setting_of(spec: Spec) -> Setting:
    """The models of a specification. Raises: InputError when they contradict each other."""
    from .certificate.hurwitz import is_hurwitz

    try:
        setting = Setting.of(spec)
    except (ValueError, ZeroDivisionError) as error:
        raise InputError(str(error)) from error
    weight = setting.uncertainty.weight
    if weight is not None and not is_hurwitz(weight.den):
        message = "uncertainty.weight must be stable: its denominator has a root with Re s ≥ 0"
        raise InputError(f"{message}; change the root's sign, which leaves |W(jω)| as it is")
    return setting


def realizable(setting: Setting, coefficients: Polynomials) -> Compensator:
    """The compensator of given coefficients.

    Raises: InputError for Q = 1, 1 + CF = 0 throughout, a loop that is not well-posed free or locked, or coefficients
    that single precision cannot hold where the tolerance asked for is its rounding.
    """
    _demand_range(setting, coefficients)
    try:
        C = setting.compensator(coefficients)
        setting.loop.Q_tilde(C)
        setting.loop.Q_ideal(C)
    except ValueError as error:
        raise InputError(f"controller.coefficients: {error}") from error
    except ZeroDivisionError as error:
        raise InputError("controller.coefficients: 1 + HCF, or 1 + CF, is 0 at every frequency") from error
    for end, (fault, remedy) in NOT_WELL_POSED.items():
        if not setting.loop.well_posed(C, end):
            message = f"controller.coefficients: algebraic loop, {fault} not positive at infinite frequency"
            raise InputError(f"{message}: any lag of the actuator makes it unstable; {remedy}")
    return C


def _demand_range(setting: Setting, coefficients: Polynomials) -> None:
    """Rounding to float32 is a relative error of 2⁻²⁴ only between its smallest normal and its largest number."""
    if setting.spec.constraints.tolerance != FLOAT32:
        return
    for c in (*coefficients.numerator, *coefficients.denominator):
        if c and not SMALLEST <= abs(c) <= LARGEST:
            raise InputError(
                f"controller.coefficients: {float(c):.4g} is outside the range of single precision, 1.2e-38 to 3.4e38, "
                "which constraints.tolerance asks for; multiply numerator and denominator by a common factor"
            )


def _producer() -> dict[str, str]:
    packages = {name: version(name) for name in ("python-flint", "casadi", "clarabel", "numpy")}
    return {"robimp": version("robimp"), "python": platform.python_version(), **packages}
