"""A certificate as the report sees it: re-checked first, then its models rebuilt from specification and controller."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...certificate.claim import Claim
from ...certificate.document import document
from ...check import Verdict, check_bytes
from ...errors import ExitCode, InputError, Location
from ...problem.constraints import constraints
from ...problem.grid import frequency_scale, grid
from ...problem.setting import Setting
from ...spec import from_canonical
from ...spec.model import Polynomials
from ...written import claims_of, polynomials
from .words import real

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ....models.controller import Compensator
    from ...spec.model import Spec

SPREAD, DENSE = 220, 260  # frequencies over everything the joint does, and more of them about ω_B
VIEW = 50.0  # plots open at ω_B/50 to 50 ω_B


@dataclass(frozen=True)
class CheckedClaim:
    """A claim as written, and what the independent checker says of it."""

    claim: Claim
    confirmed: bool
    message: str

    @property
    def word(self) -> str:
        """The status a reader may rely on."""
        return self.claim.status.value if self.confirmed else "not verified"


@dataclass(frozen=True)
class Study:
    """One certificate, its verdict, and the joint and controller it is about. file: the name to show."""

    file: str
    verdict: Verdict
    content: dict[str, Any]
    setting: Setting
    coefficients: Polynomials
    compensator: Compensator

    @classmethod
    def of(cls, file: str, data: bytes, *, time_limit: float = 60.0, verdict: Verdict | None = None) -> Study:
        """Check a certificate's bytes, unless their verdict is given, and rebuild what they are about.

        time_limit [s] for the check.

        Raises: InputError for bytes that are no certificate, or one whose loop cannot be built.
        """
        verdict = check_bytes(data, time_limit=time_limit) if verdict is None else verdict
        if verdict.exit_code == ExitCode.INPUT:
            raise InputError(verdict.message, Location(file))
        content = json.loads(data)
        spec = from_canonical(content["spec"], file)
        written = content["controller"]["Q" if spec.controller.type == "dob" else "C"]
        coefficients = polynomials(written)
        try:
            setting = Setting.of(spec)
            compensator = setting.compensator(coefficients)
            setting.loop.Q_tilde(compensator)
        except (ValueError, ZeroDivisionError) as error:
            raise InputError(f"the loop cannot be built: {error}", Location(file)) from error
        return cls(file, verdict, content, setting, coefficients, compensator)

    @property
    def spec(self) -> Spec:
        """The specification inside the certificate."""
        return self.setting.spec

    @property
    def proven(self) -> bool:
        """Whether the checker confirms everything the specification requires."""
        return self.verdict.exit_code == ExitCode.PROVEN

    @property
    def verdict_word(self) -> str:
        """PROVEN, REFUTED, UNDECIDED or MISMATCH."""
        return ExitCode(self.verdict.exit_code).name

    @property
    def omega_B(self) -> float:
        """The bandwidth the certificate states [rad/s]; proven only if `proven`."""
        return real(Fraction(self.content["bandwidth"]["proven"]))

    @cached_property
    def claims(self) -> tuple[CheckedClaim, ...]:
        """Every claim, in words of this version's definitions wherever it has them: those of a file are not checked."""
        said = {(id, form): (status, message) for id, form, status, message in self.verdict.claims}
        defined = {(c.id, c.form): c for c in constraints(self.setting)}
        found = []
        for claim in claims_of(self.content):
            kind = claim.id, claim.form
            if kind in defined:
                own = defined[kind]
                claim = replace(claim, equation=own.equation, statement=own.statement, uncertainty=own.uncertainty)
            status, message = said.get(kind, ("not verified", self.verdict.message))
            found.append(CheckedClaim(claim, status == claim.status.value, message))
        return tuple(found)

    @cached_property
    def limits(self) -> tuple[list[str], list[str]]:
        """Assumptions and what is not claimed, as this version words them for these claims."""
        claims = tuple(checked.claim for checked in self.claims)
        if not any(claim.id == "bandwidth" for claim in claims):
            return [], ["anything: the claim of the bandwidth itself is missing"]
        stated = document(self.setting, self.coefficients, claims, bound=None, producer={})
        return stated["assumptions"], stated["not_claimed"]

    @cached_property
    def view(self) -> tuple[float, float]:
        """Frequencies [rad/s] that plots open at."""
        low, high = frequency_scale(self.setting)
        middle = self.omega_B or (low * high) ** 0.5
        return middle / VIEW, middle * VIEW

    @cached_property
    def omega(self) -> NDArray[np.float64]:
        """The grid of every plot [rad/s]: what the joint does, more about ω_B, ends of bands and witnesses. (n,)."""
        around = self.omega_B or None
        special = [w for checked in self.claims for w in _frequencies(checked.claim)]
        regular = grid(self.setting, around=around, spread=SPREAD, dense=DENSE if around else 0)
        low, high = min([*special, *self.view, regular[0]]), max([*special, *self.view, regular[-1]])
        return np.unique(np.concatenate([regular, special, np.geomspace(low, high, 60)]))

    @property
    def ends(self) -> tuple[float, float]:
        """First and last frequency of the grid [rad/s]."""
        return float(self.omega[0]), float(self.omega[-1])

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Which frequencies of the grid lie in the view. (n,)."""
        low, high = self.view
        return np.asarray((self.omega >= low) & (self.omega <= high))

    @property
    def C(self) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
        """The compensator's numerator and denominator, as the simulation takes it."""
        written = polynomials(self.content["controller"]["C"])
        return written.numerator, written.denominator


def _frequencies(claim: Claim) -> list[float]:
    """Finite, positive frequencies a claim names: the ends of its interval, its witness."""
    witness = None if claim.refuted_at is None else claim.refuted_at.witness
    named = [*claim.interval, None if witness is None else witness.omega]
    return [omega for w in named if w is not None and 0 < (omega := real(w)) < np.inf]
