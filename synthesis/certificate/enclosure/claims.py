"""The claims that cells prove: everything beyond polynomials; robust stability of boxes; the tolerance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial

from ....models.controller import Compensator
from ...problem.constraints import constraints
from ...problem.constraints.inequality import WHOLE, Constraint
from ...problem.setting import Setting
from ..claim import Claim, Refutation, claim_of
from ..outcome import Outcome
from ..stability import MODES
from ..witness import short
from .band import prove_bandwidth
from .box import largest_spread
from .joint import family_of
from .prover import NEAR, CellProver
from .tolerance import itself, largest
from .winding import turns

EVERY = {"free": "every load, impedance and actuator of the stated boxes", "locked": "every actuator of the stated box"}


def prove_constraints(setting: Setting, C: Compensator) -> Iterator[Claim]:
    """Every constraint on cells, the objective's on the bandwidth proven first."""
    prover = CellProver(family_of(setting, C))
    band = tolerant(setting, C, prove_bandwidth(prover))
    for constraint in constraints(setting):
        if constraint.id == "bandwidth":
            yield band
        elif constraint.on_band and band.margin is None and not constraint.required:
            yield claim_of(replace(constraint, band=band.interval), Outcome.UNDECIDED, None, None)
        elif not constraint.largest_band:
            yield prover.hardest(replace(constraint, band=band.interval) if constraint.on_band else constraint)


def prove_winding(setting: Setting, C: Compensator) -> Iterator[Claim]:
    """Nominal stability with the hold of a sampled controller, free and locked."""
    family = replace(family_of(setting, C), single=True)
    for end, (equation, what) in MODES.items():
        turned = turns(CellProver(family), end)
        stable = turned == 0
        yield Claim(
            id=f"stability-{end}",
            equation=equation,
            form="winding",
            statement=f"{what} decays, hold and delay included, nominal load",
            uncertainty="none: nominal load",
            interval=WHOLE,
            required=True,
            status=Outcome.PROVEN if stable else Outcome.UNDECIDED if turned is None else Outcome.REFUTED,
            margin=Fraction(0) if stable else None,
            refuted_at=None if stable or turned is None else Refutation(Fraction(0), None),
        )


def prove_boxes(setting: Setting, C: Compensator) -> Iterator[Claim]:
    """Robust stability of the boxes, with the factor on them that is still stable."""
    family = family_of(setting, C)
    for end, asked in (("free", setting.boxed), ("locked", bool(setting.actuators))):
        if not asked:
            continue
        found = largest_spread(family, end)
        beyond = None if found.refuted is None else Refutation(found.refuted, found.witness)
        yield Claim(
            id=f"stability-{end}",
            equation=MODES[end][0],
            form="box",
            statement=f"{MODES[end][1]} decays for every joint of the boxes, stretched by v about the nominal joint",
            uncertainty=EVERY[end],
            interval=WHOLE,
            required=True,
            status=found.outcome,
            margin=found.proven,
            refuted_at=beyond if found.outcome is not Outcome.UNDECIDED else None,
        )


def required_of(setting: Setting, omega_B: Fraction) -> list[tuple[Constraint, Fraction]]:
    """Every constraint a specification requires, at its level, the objective's on [0, ω_B]."""
    asked = [(c, c.level) for c in constraints(setting) if c.level is not None]
    return [(replace(c, band=(Fraction(0), omega_B)) if c.on_band else c, level) for c, level in asked]


def tolerant(setting: Setting, C: Compensator, band: Claim) -> Claim:
    """The bandwidth claim, shortened until it survives the tolerance that the specification asks for."""
    asked = setting.spec.constraints.tolerance
    if asked is None or band.margin is None:
        return band
    prover = CellProver(replace(family_of(setting, C), tolerance=asked))
    for shorter in (0.0, *NEAR):
        end = short(float(band.margin) * (1 - shorter), digits=8, up=False)
        if prover.decide([(c, v) for c, v in required_of(setting, end) if c.on_band]).low > 0:
            return replace(band, margin=end, interval=(Fraction(0), end))
    return band


def prove_tolerance(setting: Setting, C: Compensator, claims: Sequence[Claim]) -> Iterator[Claim]:
    """The tolerance of the coefficients, where the specification asks for one; claims: all others."""
    asked = setting.spec.constraints.tolerance
    if asked is None:
        return
    family = family_of(setting, C)
    broken = [claim for claim in claims if claim.required and claim.status is not Outcome.PROVEN]
    if broken:  # by the controller itself; roots have no frequency to name
        proven, beyond = None, next(filter(None, map(partial(itself, family), broken)), None)
    else:
        omega_B = next(claim.margin for claim in claims if claim.id == "bandwidth")
        proven, beyond = largest(family, required_of(setting, omega_B or Fraction(0)), asked)
    status, refuted = Outcome.PROVEN, None if beyond is None else Refutation(*beyond)
    if proven is None:
        refuted = replace(refuted, value=asked) if refuted is not None and refuted.value <= asked else None
        status = Outcome.UNDECIDED if refuted is None else Outcome.REFUTED
    yield Claim(
        id="tolerance",
        equation="beyond the paper",
        form="coefficients",
        statement="every controller whose coefficients differ by at most v, relatively, has everything required here",
        uncertainty="coefficients of the controller, each on its own",
        interval=WHOLE,
        required=True,
        status=status,
        margin=proven,
        refuted_at=refuted,
    )
