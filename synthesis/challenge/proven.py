"""What was proven, as the attacks need it."""

from __future__ import annotations

import numpy as np

from ..certificate.claim import Claim
from ..certificate.outcome import Outcome
from ..simulation.adversary.tones import Array
from ..simulation.excitation import default_frequencies
from ..spec.model import Spec

Claims = dict[tuple[str, str], Claim]


def proven(claims: Claims, id: str, form: str) -> Claim | None:
    """The claim, if it is proven."""
    claim = claims.get((id, form))
    return claim if claim is not None and claim.status is Outcome.PROVEN else None


def passive_port(claims: Claims) -> bool:
    """Passivity proven on the whole axis, of a joint that is stable free and locked."""
    claim = proven(claims, "eq12", "structured")
    return claim is not None and claim.interval[1] is None and all(
        any(proven(claims, f"stability-{end}", form) for form in ("hurwitz", "winding")) for end in ("free", "locked")
    )  # fmt: skip


def band_of(spec: Spec) -> tuple[float, float]:
    """Where to look for the worst [rad/s]: a decade and more beyond the joint's own frequencies."""
    frequencies = default_frequencies(spec)
    return float(frequencies.min()) / 30, float(frequencies.max()) * 10


def hints_of(claim: Claim | None) -> tuple[float, ...]:
    """The witness's frequency [rad/s], if there is one."""
    witness = claim.refuted_at.witness if claim and claim.refuted_at else None
    return (float(witness.omega),) if witness is not None and witness.omega else ()


def nominal_load(spec: Spec) -> Array:
    """Inertia, damping, stiffness, (1, 3)."""
    return np.array([[float(v) for v in (spec.plant.inertia, spec.plant.damping, spec.plant.stiffness)]])
