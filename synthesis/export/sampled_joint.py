"""The joint on cells with the shipped law in place of the continuous controller, for ω up to half the sampling rate.

The same models and constraints as in the certificate, at s = jω: joint, hold and delay as they are; the controller at
z = e^{jωT}. Everything discrete is a polynomial of the difference `D = (1 − z⁻¹)/T = s·hold`, which is entire in ω and
tends to s where ω → 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import pi
from typing import Any

import numpy as np
from flint import fmpq, fmpq_poly

from ...models.closed_loop import ImpedanceLoop, Pencil
from ...models.controller import Compensator, Filters
from ...models.impedance import DynamicStiffness
from ...models.sampling import Hold
from ..certificate.enclosure.cells import Cells, Part
from ..certificate.enclosure.form import Form
from ..certificate.enclosure.joint import JointOnCells
from ..certificate.enclosure.prover import CellProver
from ..certificate.enclosure.wave import Wave
from ..certificate.witness import short
from ..problem.constraints.eq12 import least_at_end
from ..problem.constraints.inequality import WHOLE, Band, Constraint, Variable
from ..problem.setting import LOAD, Setting
from .law import Law
from .motion import Motion

WITHIN = 0.99  # part of π/T up to which frequency responses are proven: at π/T itself means of samples vanish


def last_frequency(law: Law) -> Fraction:
    """Up to where claims about frequency responses reach [rad/s]."""
    return short(WITHIN * pi * float(law.rate))


@dataclass(frozen=True)
class SampledLoop(ImpedanceLoop):
    """(★) of a law whose θ' and θ'' are differences. F stands in the compensator; `wish`: `G_imp(D)·F_θ/F`."""

    wish: Any = None
    compensated: Any = None  # `F_d (Ĝ⁻¹ − G_imp)(D)`

    @property
    def G_imp(self) -> Any:
        """Desired dynamic stiffness as the θ channel forms it."""
        return self.wish

    @property
    def compensation(self) -> Any:
        """`F_d (Ĝ⁻¹ − G_imp)` as the θ channel forms it."""
        return self.compensated

    def locked(self) -> Pencil:
        """`1 + HCF` over what is common."""
        return Pencil(self.actuator.d, self.actuator.h)

    def free(self, load: DynamicStiffness) -> Pencil:
        """`(1 + HCF)·Z` over what is common."""
        port = self.actuator
        uncontrolled = port.d * load.polynomial + port.z - port.h * self.compensated
        return Pencil(uncontrolled, port.h * self.wish)


@dataclass(frozen=True, eq=False)
class SampledJoint(JointOnCells):
    """Everything the constraints need, on one set of cells."""

    law: Law

    @cached_property
    def D(self) -> Wave:
        """`(1 − e^{−sT})/T`."""
        return self.s * self.cells.hold(Hold(self.law.period, fmpq(0)))

    def discrete(self, p: fmpq_poly) -> Wave:
        """A polynomial of z⁻¹ = 1 − T D, by Horner's rule in D."""
        value = self.s.real_number(0)
        for c in reversed(p(fmpq_poly([1, -self.law.period])).coeffs()):
            value = value * self.D + c
        assert value is not None
        return value

    @cached_property
    def stiffnesses(self) -> tuple[Wave, Wave]:
        """`M (I θ'' + B θ' + K θ)` per θ, of G_imp before C and of Ĝ⁻¹ − G_imp before F_d."""
        law = self.law
        desired = {k: self._number(f"impedance.{k}", getattr(law.desired, k)) for k in LOAD}
        own = {k: getattr(law.nominal, k) for k in LOAD}
        compensated = self._stiffness(law.compensated, own) - self._stiffness(law.compensated, desired)
        return self._stiffness(law.error, desired), compensated

    def characteristic(self, end: str) -> tuple[Wave, Wave, Wave, Wave]:
        """Of the loop without its hold: joint numerator and denominator, feedback numerator and denominator."""
        port, nominal = self.unshipped.loop.actuator, self.family.setting.loop.nominal
        feedback, behind = self.law.feedback(end, self.discrete, *self.stiffnesses)
        if end == "locked":
            return port.h, port.d, feedback, behind
        load = DynamicStiffness(**{k: self._number(f"load.{k}", getattr(nominal, k)) for k in LOAD}, s=self.s)
        return port.h, port.d * load.polynomial + port.z, feedback, behind

    @cached_property
    def unshipped(self) -> Setting:
        """The setting on the cells with the continuous controller."""
        return JointOnCells(self.family, self.cells).setting

    @cached_property
    def setting(self) -> Setting:
        """The setting on the cells, its controller the shipped one."""
        setting, law = self.unshipped, self.law
        wish, compensated = self.stiffnesses
        F, F_theta, F_d = law.force, law.position, law.derivative
        ratio = self.discrete(F_theta.num * F.den) / self.discrete(F_theta.den * F.num * law.error.M)
        derivative = self.discrete(F_d.num) / self.discrete(F_d.den)
        known = {k: getattr(setting.loop, k) for k in ("actuator", "nominal", "desired", "s")}
        loop = SampledLoop(**known, filters=Filters(), wish=wish * ratio, compensated=derivative * compensated)
        return replace(setting, loop=loop)

    def _stiffness(self, motion: Motion, g: dict[str, Any]) -> Wave:
        """`M (I θ'' + B θ' + K θ)` per θ, of numbers or of forms."""
        parts = zip((motion.A, motion.V, motion.M), LOAD, strict=True)
        found: Wave = sum((self.discrete(p) * g[name] for p, name in parts), start=self.s * 0)
        return found

    @cached_property
    def compensator(self) -> Compensator:
        """`C F`."""
        C, F = self.law.compensator, self.law.force
        return Compensator(self.discrete(C.num * self.law.error.M * F.num), self.discrete(C.den * F.den))


@dataclass(frozen=True)
class SampledProver(CellProver):
    """Proofs about the shipped law up to almost π/T."""

    law: Law = field(kw_only=True)

    def clipped(self, band: Band) -> Band:
        """A band without what lies beyond half the sampling rate."""
        end = last_frequency(self.law)
        return band[0], end if band[1] is None else min(band[1], end)

    def axis(self, band: Band) -> tuple[Cells, ...]:
        """Cells to begin with."""
        cells = super().axis(self.clipped(band))
        for one in cells:
            self._joints.setdefault(id(one), (one, SampledJoint(self.family, one, self.law)))
        return cells

    def joint(self, cells: Cells) -> JointOnCells:
        """The joint on cells; remembered for those every proof begins with."""
        known = self._joints.get(id(cells))
        return SampledJoint(self.family, cells, self.law) if known is None else known[1]

    def ends(self, constraint: Constraint) -> bool:
        """Whether `Z(0)` > 0 (friction: over its nominal value) for every load; no claim reaches ω = ∞."""
        return all(float(form.lower[0]) > 0 and form.order == 0 for form in self._at_rest(constraint))

    def _at_rest(self, constraint: Constraint) -> Iterator[Form]:
        low = next(cells for cells in self.axis(WHOLE) if cells.part is Part.LOW)
        at = Cells(low.part, np.zeros((2, 1)), low.t[:, :, :1])
        joint = SampledJoint(self.family, at, self.law)
        loop, C, uncertainty = joint.setting.loop, joint.compensator, self.family.setting.uncertainty
        reference = loop.free(loop.nominal)(C) if constraint.id == "friction" else loop.locked()(C)
        own = (1 - joint.variables[Variable.Q_TILDE]) * loop.locked()(C) / reference
        for load in uncertainty.corners():
            A = (loop.free(load)(C) / reference).real
            yield A
            if uncertainty.disc:
                yield least_at_end(A, (own * load.rational).real, joint.disc * joint.disc)
