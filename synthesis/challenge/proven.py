"""What was proven, as the attacks need it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...models.rational import fraction
from ..agreement import NOMINAL
from ..certificate.claim import Claim
from ..certificate.document import robustly_stable
from ..certificate.outcome import Outcome
from ..certificate.witness import Witness
from ..problem.setting import Setting
from ..simulation import Drive, Load, Member, default_frequencies, members
from ..simulation.adversary.loop import Array
from ..simulation.equations import Compensator
from ..simulation.members import DRIVE, WISH, with_parameters
from ..spec.model import Spec

Claims = dict[tuple[str, str], Claim]
SYMBOLS = dict(zip(DRIVE, ("J", "b_m", "K_sp"), strict=True))


@dataclass(frozen=True)
class Subject:
    """A specification, its compensator, and every claim about them."""

    spec: Spec
    C: Compensator
    claims: Claims

    def proven(self, id: str, form: str) -> Claim | None:
        """The claim, if it is proven."""
        claim = self.claims.get((id, form))
        return claim if claim is not None and claim.status is Outcome.PROVEN else None

    @property
    def stable(self) -> bool:
        """Whether the nominal joint is proven to be stable, free and locked."""
        return all(any(self.proven(f"stability-{end}", form) for form in NOMINAL) for end in ("free", "locked"))

    @property
    def robust(self) -> bool:
        """Whether every load of the uncertainty, in every joint of the ranges, is proven to be stable."""
        return robustly_stable(Setting.of(self.spec), tuple(self.claims.values()))

    @property
    def passive(self) -> bool:
        """Passivity proven on the whole axis for every joint, of one that is stable free and locked."""
        claim = self.proven("eq12", "structured")
        return self.stable and claim is not None and claim.interval[1] is None

    @property
    def band(self) -> tuple[float, float]:
        """Where to look for the worst [rad/s]: a decade and more beyond the joint's own frequencies."""
        frequencies = default_frequencies(self.spec)
        return float(frequencies.min()) / 30, float(frequencies.max()) * 10

    def joints(self, claim: Claim | None = None) -> list[Member]:
        """Every member of the ranges, the witness's first."""
        found, witness = list(members(self.spec)), witness_of(claim)
        if witness is not None and (witness.impedance or witness.actuator):
            found.insert(0, member_of(self.spec, witness))
        return found


def witness_of(claim: Claim | None) -> Witness | None:
    """Where the next level of a claim fails."""
    return claim.refuted_at.witness if claim is not None and claim.refuted_at else None


def member_of(spec: Spec, witness: Witness) -> Member:
    """The joint of the ranges that a witness names."""
    wish, drive = witness.impedance, witness.actuator
    return with_parameters(
        spec,
        None if wish is None else Load(*(fraction(getattr(wish, name)) for name in WISH)),
        None if drive is None else Drive(*(fraction(getattr(drive, SYMBOLS[name])) for name in DRIVE)),
    )


def load_of(witness: Witness) -> Array | None:
    """Inertia, damping, stiffness of a witness's load, (3,)."""
    return None if witness.load is None else np.array([float(getattr(witness.load, name)) for name in WISH])


def hints_of(claim: Claim | None) -> tuple[float, ...]:
    """The witness's frequency [rad/s], if there is one."""
    witness = witness_of(claim)
    return (float(witness.omega),) if witness is not None and witness.omega else ()


def nominal_load(spec: Spec) -> Array:
    """Inertia, damping, stiffness, (3,)."""
    return np.array([float(v) for v in (spec.plant.inertia, spec.plant.damping, spec.plant.stiffness)])
