"""The joint on cells: the same models and constraints, with enclosures where the exact prover has polynomials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from flint import fmpq, fmpq_poly

from ....models.controller import Compensator
from ....models.impedance import DynamicStiffness
from ....models.rational import exact, fraction
from ....models.uncertainty import Segment, Table
from ...problem.constraints.inequality import Inequality, Role, Source, Variable, needs_disc
from ...problem.setting import ACTUATOR, LOAD, Setting
from .cells import Cells, Part
from .form import Form
from .wave import Wave

Range = tuple[fmpq, fmpq]
EDGE = "edge"
HOPELESS = -1e12  # −1/v of a level so close to 0 that it stands for none


@dataclass(frozen=True)
class Family:
    """One controller on every joint of a setting: the uncertain parameters, in the order of the cells' own.

    spread: factor on every parameter interval about its nominal value (robust stability asks how large it may be).
    tolerance: relative perturbation of the controller's coefficients, each on its own. numerator, denominator:
    of Q or C_imp, ascending.
    """

    setting: Setting
    numerator: fmpq_poly
    denominator: fmpq_poly
    spread: Fraction = Fraction(1)
    tolerance: Fraction = Fraction(0)
    loads: bool = False  # whether loads are parameters (stability), or the corners of the box are taken in turn
    single: bool = False  # one joint: the setting's own impedance and actuator, and this load, or the nominal one
    load: DynamicStiffness | None = None

    @cached_property
    def parameters(self) -> dict[str, Range]:
        """Name and range of every parameter that is not a single number."""
        if self.single:
            return {}
        found = {f"impedance.{k}": self._scaled(v) for k, v in self.setting.impedances.items()}
        found |= {f"actuator.{k}": self._scaled(v) for k, v in self.setting.actuators.items()}
        box = self.setting.uncertainty.box
        if self.loads and box is not None:
            nominal = self.setting.loop.nominal
            found |= {f"load.{k}": self._scaled((*getattr(box, k), getattr(nominal, k))) for k in LOAD}
        elif box is not None and len(self.setting.uncertainty.segments()) > len(self.setting.uncertainty.corners()):
            found[EDGE] = (fmpq(0), fmpq(1))
        for part, p in (("numerator", self.numerator), ("denominator", self.denominator)):
            for k, c in enumerate(p.coeffs()):
                reach = abs(c) * exact(self.tolerance)
                found[f"{part}.{k}"] = (c - reach, c + reach)
        return {name: ends for name, ends in found.items() if ends[0] < ends[1]}

    @property
    def only_loads(self) -> bool:
        """Whether loads are all that varies, without a hold: actuator, impedance and controller are polynomials."""
        ranges = not self.single and (self.setting.impedances or self.setting.actuators)
        return not (ranges or self.tolerance or self.setting.loop.actuator.hold)

    @property
    def proper_within(self) -> Fraction:
        """The relative perturbation that can make C = Q/(1−Q), or C_imp, improper: its leading coefficient is 0."""
        last, observer = self.denominator.degree(), self.setting.spec.controller.type == "dob"
        below, above = self.denominator[last], self.numerator[last] if observer else fmpq(0)
        return fraction(abs(below - above) / (abs(below) + abs(above)))

    @cached_property
    def compensator(self) -> Compensator:
        """C with its own coefficients."""
        return self.setting.build(self.numerator, self.denominator)

    @cached_property
    def by_load(self) -> tuple[fmpq_poly, fmpq_poly]:
        """f and E of the characteristic polynomial in free motion, `f + E·(load − its middle)`."""
        loop, load = self.setting.loop, self.load or self.setting.loop.nominal
        f = loop.free(load)(self.compensator)
        return f, loop.free(replace(load, stiffness=load.stiffness + 1))(self.compensator) - f

    def _scaled(self, interval: tuple[fmpq, fmpq, fmpq]) -> Range:
        low, high, middle = interval
        v = exact(self.spread)
        return middle - v * (middle - low), middle + v * (high - middle)

    def middle(self, name: str) -> fmpq:
        """Nominal value of an uncertain parameter, about which its interval is stretched."""
        part, key = name.split(".")
        if part == "load":
            return getattr(self.setting.loop.nominal, key)  # type: ignore[no-any-return]
        return (self.setting.impedances if part == "impedance" else self.setting.actuators)[key][2]

    def point(self, cells: Cells, k: int) -> dict[str, fmpq]:
        """Exact values of the parameters at the k-th (degenerate) cell."""
        shares = (exact(float(share)) for share in cells.t[0, :, k])
        ranges = self.parameters.items()
        return {
            name: (low + high) / 2 + (high - low) / 2 * share
            for (name, (low, high)), share in zip(ranges, shares, strict=True)
        }


def family_of(setting: Setting, C: Compensator) -> Family:
    """The family of joints that share a compensator, by the coefficients of Q or C_imp."""
    den = C.den + C.num if setting.spec.controller.type == "dob" else C.den
    return Family(setting, C.num, den)


@dataclass(frozen=True, eq=False)
class JointOnCells:
    """Everything the constraints need, on one set of cells."""

    family: Family
    cells: Cells
    _variables: dict[Variable, Wave] = field(default_factory=dict, init=False, repr=False)
    _values: dict[int, tuple[Any, Any]] = field(default_factory=dict, init=False, repr=False)

    def _number(self, name: str, otherwise: Any) -> Any:
        parameters = self.family.parameters
        return self.cells.parameter([*parameters].index(name), *parameters[name]) if name in parameters else otherwise

    @cached_property
    def s(self) -> Wave:
        """`s = jω`."""
        return self.cells.s

    @cached_property
    def setting(self) -> Setting:
        """The setting with its actuator and desired impedance on the cells; loads and filters stay exact."""
        exact_loop, s = self.family.setting.loop, self.s
        wish = {k: self._number(f"impedance.{k}", getattr(exact_loop.desired, k)) for k in LOAD}
        desired = DynamicStiffness(**wish, s=s)
        elastic = self.family.setting.elastic
        if elastic is None:
            port = exact_loop.actuator
            values = [s.polynomial(p) for p in (port.h, port.z, port.d)]
            port = replace(port, h=values[0], z=values[1], d=values[2])
        else:
            uncertain = {k: self._number(f"actuator.{name}", getattr(elastic, k)) for name, k in ACTUATOR.items()}
            port = replace(elastic, **uncertain).over(s)
        hold = self.family.setting.loop.actuator.hold
        if hold is not None:
            port = replace(port, h=port.h * self.cells.hold(hold))
        port = replace(port, hold=None)
        return replace(self.family.setting, loop=replace(exact_loop, actuator=port, desired=desired, s=s))

    @cached_property
    def compensator(self) -> Compensator:
        """C, its coefficients as uncertain as the tolerance makes them."""
        family = self.family
        if family.tolerance == 0:
            C = family.compensator
            return Compensator(self.s.polynomial(C.num), self.s.polynomial(C.den))
        parts = []
        for part, p in (("numerator", family.numerator), ("denominator", family.denominator)):
            parts.append(self.s.polynomial([self._number(f"{part}.{k}", c) for k, c in enumerate(p.coeffs())]))
        return family.setting.build(*parts)

    def variable(self, which: Variable) -> Wave:
        """Q, Q̃, L or the noise gain on the cells."""
        if which not in self._variables:
            self._variables[which] = self.setting.variable(which, self.compensator)
        return self._variables[which]

    def at(self, value: Any) -> Any:
        """A number, a polynomial or a rational function as a wave; an exact one is evaluated once."""
        if isinstance(value, Wave):
            return value
        if id(value) not in self._values:
            self._values[id(value)] = (value, self.s.real_number(value))  # held, so that its id stays its own
        return self._values[id(value)][1]

    def free(self) -> Wave:
        """Characteristic function in free motion, the load a parameter."""
        load = self.family.load or self.family.setting.loop.nominal
        if self.family.only_loads:
            f, E = self.family.by_load
            moved = {k: self._number(f"load.{k}", getattr(load, k)) - getattr(load, k) for k in LOAD}
            change: Wave = DynamicStiffness(**moved, s=self.s).polynomial
            return self.s.polynomial(f) + self.s.polynomial(E) * change
        load = DynamicStiffness(**{k: self._number(f"load.{k}", getattr(load, k)) for k in LOAD}, s=self.s)
        return self.setting.loop.free(load)(self.compensator)  # type: ignore[no-any-return]

    def locked(self) -> Wave:
        """Characteristic function against a rigid wall."""
        return self.setting.loop.locked()(self.compensator)  # type: ignore[no-any-return]

    def sides(self, inequality: Inequality, v: Any) -> Iterator[tuple[Form, Form]]:
        """Left and right side of an inequality, for each member of the uncertainty that decides it."""
        X = self.variable(inequality.variable)
        for _, W in self.members(inequality):
            left, right = inequality.sides(v, W, X, self.at)
            zero = self.s.x.constant(0)
            yield left + zero, right + zero

    def levels(self, inequality: Inequality) -> Iterator[Form]:
        """For each member of the uncertainty, the level that just holds: v itself, or −1/v, or −v: larger is easier.

        FLOOR: v. CEILING: −v. RADIUS: −1/v, which an exact model (W = 0) leaves finite; HOPELESS where none holds.
        """
        X, at, zero = self.variable(inequality.variable), self.at, self.s.x.constant(0)
        for _, W in self.members(inequality):
            numerator, denominator = (side + zero for side in inequality.level(W, X, at))
            if inequality.role is Role.FLOOR:
                yield numerator
            elif inequality.role is Role.CEILING:
                yield -(numerator / denominator)
            else:
                share = -(denominator / numerator)
                share = share.shifted(min(share.order, 0))
                yield share.where(numerator.upper < 0, HOPELESS)

    def members(self, inequality: Inequality) -> Iterator[tuple[DynamicStiffness | None, Any]]:
        """Members of the uncertainty that decide an inequality: the load, None along a segment of loads, and W."""
        if inequality.source is Source.NONE:
            yield inequality.load, 0
            return
        V = self.disc
        if inequality.source is Source.DISC or self.family.setting.uncertainty.box is None:
            yield inequality.load, V
            return
        uncertainty = self.family.setting.uncertainty
        points: tuple[Segment, ...] = tuple((load, load) for load in uncertainty.corners())
        for segment in points if needs_disc(inequality) else uncertainty.segments():
            start, end = segment
            W = self._load_radius(start, end)
            yield start if start == end else None, W + V + W * V

    @cached_property
    def disc(self) -> Any:
        """Radius V of the disc on top of every load: `1 + V = (1+W_w)(1+W_t)`."""
        uncertainty = self.family.setting.uncertainty
        weight: Any = 0 if uncertainty.weight is None else self.s.real_number(uncertainty.weight)
        weight = abs(weight)
        table = 0 if uncertainty.table is None else self._table(uncertainty.table)
        return weight + table + weight * table

    def _load_radius(self, start: DynamicStiffness, end: DynamicStiffness) -> Form:
        """`|Ĝ⁻¹ − g|/|g|` for a load, or along a segment of loads."""
        gap = self.s.polynomial(self.family.setting.loop.nominal.polynomial - start.polynomial)
        load = self.s.polynomial(start.polynomial)
        if start != end:
            step = self.s.polynomial(end.polynomial - start.polynomial) * self._number(EDGE, None)
            load, gap = load + step, gap - step
        return abs(gap) / abs(load)

    def _table(self, table: Table) -> Form:
        """Least and greatest bound over each cell; linear in ω where a cell lies between two points."""
        low, high = self.cells.z
        if self.cells.part is Part.HIGH:
            with np.errstate(divide="ignore"):
                low, high = 1 / high, 1 / low
        least, most = table.extremes(low, high)
        if self.cells.part is Part.HIGH:
            return self.cells.ball(least, most)
        ends = np.array([table(low), table(high)])
        straight = table.straight(low, high)
        linear = self.cells.moving(0, *ends)
        ball = self.cells.ball(least, most)
        c = np.where(straight, linear.c, ball.c)
        return Form(c, np.where(straight, linear.rho, ball.rho) + 1e-12 * most, 0, self.s.x.z)
