"""Claims on cells: the constraints of a family of joints, each proven at its hardest level with a twin beside it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from ....models.impedance import DynamicStiffness
from ....models.rational import to_float
from ...problem.constraints import constraints
from ...problem.constraints.eq12 import least_at_end
from ...problem.constraints.inequality import WHOLE, Band, Constraint, Inequality, Role, Variable
from ...problem.grid import frequency_scale
from ...problem.setting import Setting
from ..claim import Claim, Refutation, claim_of
from ..outcome import Outcome
from ..witness import Witness, short
from .cells import Cells, Part, axis
from .form import Form
from .joint import Family, JointOnCells
from .search import Halving, Minimum, Point, minimum

MIDDLE = 300  # cells the axis starts with
BEYOND = 30.0  # how far beyond the joint's own frequencies the ends of the axis begin
END_ROUNDS, MOST_END_CELLS = 20, 4_000  # halvings of the parameters at 0 and at ∞
NEAR = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1)


@dataclass(frozen=True)
class CellProver:
    """Proofs about one family of joints. Points and levels are floats with error bounds; what is claimed is exact."""

    family: Family
    _joints: dict[int, tuple[Cells, JointOnCells]] = field(default_factory=dict, repr=False, compare=False)
    _axes: dict[Any, tuple[Cells, ...]] = field(default_factory=dict, repr=False, compare=False)

    def axis(self, band: Band) -> tuple[Cells, ...]:
        """Cells to begin with."""
        if band not in self._axes:
            low, high = frequency_scale(self.family.setting)
            hold = self.family.setting.loop.actuator.hold
            if hold is not None:  # beyond, only its size is known: it has to be small there
                high = max(high, 2 / to_float(hold.period))
            self._axes[band] = axis(low / BEYOND, high * BEYOND, len(self.family.parameters), MIDDLE, band)
        return self._axes[band]

    def joint(self, cells: Cells) -> JointOnCells:
        """The joint on cells; remembered for those every proof begins with."""
        known = self._joints.get(id(cells))
        if known is None or known[0] is not cells:
            known = (cells, self.on(cells))
            if any(cells is one for axis in self._axes.values() for one in axis):
                self._joints[id(cells)] = known
        return known[1]

    def on(self, cells: Cells) -> JointOnCells:
        """The joint on any cells."""
        return JointOnCells(self.family, cells)

    @property
    def exact(self) -> bool:
        """Whether nothing but the frequency varies: the constraints' own inequalities serve on every cell."""
        return self.family.setting.polynomial and self.family.tolerance == 0

    def inequalities(self, constraint: Constraint, joint: JointOnCells) -> tuple[Inequality, ...]:
        """A constraint's inequalities, on cells."""
        if self.exact:
            return constraint.inequalities
        same = (
            c for c in constraints(joint.setting, constraint.id) if (c.id, c.form) == (constraint.id, constraint.form)
        )
        return next(same).inequalities

    def levels(self, constraint: Constraint, cells: Cells) -> list[Form]:
        """The levels that just hold on each cell: one form for each inequality and member of the uncertainty."""
        joint = self.joint(cells)
        return [form for inequality in self.inequalities(constraint, joint) for form in joint.levels(inequality)]

    def slacks(self, constraint: Constraint, v: Fraction, cells: Cells) -> list[Form]:
        """Right minus left at a level, positive where the constraint holds: one form for each, as for `levels`."""
        joint = self.joint(cells)
        each = (side for inequality in self.inequalities(constraint, joint) for side in joint.sides(inequality, v))
        return [right - left for left, right in each]

    @np.errstate(all="ignore")
    def hardest(self, constraint: Constraint) -> Claim:
        """Prove at the hardest level, with its twin; if the required level fails, refute it with a witness."""
        found = minimum(
            lambda cells: self.levels(constraint, cells),
            self.axis(constraint.band),
            hopeless=_hopeless(constraint),
            scale=1e-4 if constraint.role is Role.FLOOR else 0.0,
            halving=self.halving,
        )
        role, required, harder = constraint.role, constraint.level, constraint.role.harder
        proven, beyond = _level(found.low, role, up=False), _level(found.high, role, up=True)
        twin = None
        if found.at is not None and beyond is not None:
            twin = Refutation(beyond, self.witness(constraint, found.at))
        level = required if required is not None else Fraction(0) if role is Role.FLOOR else Fraction(1)
        if required is not None and (proven is None or harder * (proven - required) < 0):
            if twin is not None and harder * (level - twin.value) >= 0:
                return claim_of(constraint, Outcome.REFUTED, None, replace(twin, value=level))
            proven = required if self.decide([(constraint, required)]).low > 0 else None
        if proven is not None and (proven > 0 or (role is Role.FLOOR and constraint.id != "friction")):
            if constraint.positive_real and not self.ends(constraint):
                return claim_of(constraint, Outcome.UNDECIDED, None, None)
            useful = twin is not None and harder * (twin.value - proven) > 0
            return claim_of(constraint, Outcome.PROVEN, proven, twin if useful else None)
        if twin is not None and harder * (level - twin.value) >= 0:
            return claim_of(constraint, Outcome.REFUTED, None, replace(twin, value=level))
        return claim_of(constraint, Outcome.UNDECIDED, None, None)

    @np.errstate(all="ignore")
    def decide(self, wanted: Sequence[tuple[Constraint, Fraction]]) -> Minimum:
        """Whether constraints hold at given levels on their bands: the least slack, of the first that is not proven."""
        worst = Minimum(np.inf, np.inf, None)
        for constraint, v in wanted:
            found = minimum(
                lambda cells, c=constraint, v=v: self.slacks(c, v, cells),  # type: ignore[misc]
                self.axis(constraint.band),
                floor=0.0,
                halving=self.halving,
            )
            if constraint.positive_real and not self.ends(constraint):
                found = Minimum(-np.inf, found.high, found.at)
            worst = worst if worst.low <= found.low else found
            if worst.high < 0 or worst.low <= 0:
                return worst
        return worst

    @cached_property
    def halving(self) -> Halving:
        """Which parameters may be halved: not the controller's coefficients, whose effect is small and linear."""
        ranges = self.family.parameters
        which = [not name.startswith(("numerator", "denominator")) for name in ranges]
        offset = [to_float((high + low) / (high - low)) for low, high in ranges.values()]
        return Halving(np.array(which, dtype=bool), np.array(offset))

    def ends(self, constraint: Constraint) -> bool:
        """Whether `Z(0)` and `lim Z/s²` are > 0 (friction: Z over its nominal value) for every load and parameter."""
        points = (Cells(cells.part, np.zeros((2, 1)), cells.t[:, :, :1]) for cells in self.axis(WHOLE))
        return all(self._positive(constraint, at) for at in points if at.part is not Part.MIDDLE)

    def _positive(self, constraint: Constraint, waiting: Cells) -> bool:
        for _ in range(END_ROUNDS):
            forms = list(self._ends(constraint, waiting))
            if any(form.order != 0 for form in forms):
                return False
            doubtful = np.any([~(form.lower > 0) for form in forms], axis=0)
            if not doubtful.any():
                return True
            if not self.halving.which.any() or waiting.size > MOST_END_CELLS:
                return False
            waiting = self.halving.apply(waiting[doubtful])
        return False

    def _ends(self, constraint: Constraint, at: Cells) -> Iterator[Form]:
        joint = self.on(at)
        loop, C, s, uncertainty = joint.setting.loop, joint.compensator, joint.s, self.family.setting.uncertainty
        unit = s.real_number(1) if at.part is Part.LOW else s * s
        reference = loop.free(loop.nominal)(C) if constraint.id == "friction" else loop.locked()(C) * unit
        own = (1 - joint.variable(Variable.Q_TILDE)) * loop.locked()(C) / reference
        for load in uncertainty.corners():
            A = (loop.free(load)(C) / reference).real
            yield A
            if uncertainty.disc:
                yield least_at_end(A, (own * load.rational).real, joint.disc * joint.disc)

    def witness(self, constraint: Constraint, point: Point) -> Witness:
        """The exact point of a refutation: frequency, load (if one decides), impedance and actuator."""
        omega = None if np.isinf(point.omega) else short(point.omega, digits=12)
        joint = self.joint(point.cells)
        loads = [load for q in self.inequalities(constraint, joint) for load, _ in joint.members(q)]
        return witness_at(self.family, point, omega, loads[point.form])


def witness_at(family: Family, point: Point, omega: Fraction | None, load: DynamicStiffness | None) -> Witness:
    """A witness with the parameters of a point; those that are single numbers are left out."""
    values = family.point(point.cells, point.k)
    setting = family.setting.at({k: v for k, v in values.items() if k.startswith(("impedance.", "actuator."))})
    return witness_of(setting, values, omega, load)


def witness_of(
    setting: Setting, names: Iterable[str], omega: Fraction | None, load: DynamicStiffness | None
) -> Witness:
    """A witness with a load, and with a setting's impedance and actuator if these names ask for them."""
    parts = {name.split(".")[0] for name in names}
    return Witness(
        omega,
        load,
        impedance=setting.loop.desired if "impedance" in parts else None,
        actuator=setting.elastic if "actuator" in parts else None,
    )


def _hopeless(constraint: Constraint) -> float:
    """What a minimum of `levels` must not be below, or nothing can be claimed."""
    required, role = constraint.level, constraint.role
    if required is None:
        return 0.0 if constraint.id == "friction" else -np.inf
    if role is Role.RADIUS:
        return -1 / float(required) if required else -np.inf
    return role.harder * float(required)


def _level(value: float, role: Role, *, up: bool) -> Fraction | None:
    """The level that a minimum of `levels` stands for, rounded to the easier side (`up`: to the harder)."""
    if not np.isfinite(value):
        return None
    if role is Role.FLOOR:
        return short(value, up=up)
    if role is Role.CEILING:
        return short(-value, up=not up) if value <= 0 else None  # a modulus is never below 0
    return short(min(-1 / value, 1e6) if value < 0 else 1e6, up=up)
