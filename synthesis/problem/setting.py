"""The physical side of a specification: its models, exact."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any

from flint import fmpq

from ...models.actuator import IDEAL, SeriesElastic, TwoPort, torque_loop
from ...models.closed_loop import ImpedanceLoop
from ...models.controller import Compensator, Filters, disturbance_observer, dynamic_error_feedback, low_pass
from ...models.impedance import DynamicStiffness, LoadBox
from ...models.rational import ONE, RationalFunction, descending, exact, polynomial
from ...models.sampling import Hold
from ...models.uncertainty import Table, Uncertainty
from ..spec.free_corner import resolved
from ..spec.model import FREE, Interval, Polynomials, SeriesElasticActuator, Spec, TwoPortActuator
from ..spec.model import Filters as FilterSpec
from .variable import Variable

LOAD = ("inertia", "damping", "stiffness")
ACTUATOR = {"motor_inertia": "J", "motor_damping": "b_m", "spring_stiffness": "K_sp"}  # key → symbol
Uncertain = tuple[fmpq, fmpq, fmpq]  # low, high, and the nominal value between them


@dataclass(frozen=True)
class Setting:
    """A specification with the models it describes: nominal actuator, middle of the range of impedances."""

    spec: Spec
    loop: ImpedanceLoop
    uncertainty: Uncertainty
    elastic: SeriesElastic | None = None

    @classmethod
    def of(cls, spec: Spec) -> Setting:
        """Build the models a specification describes."""
        nominal = DynamicStiffness.of(spec.plant.inertia, spec.plant.damping, spec.plant.stiffness)
        desired = DynamicStiffness.of(*(_middle(getattr(spec.impedance, name)) for name in LOAD))
        elastic, filters = _elastic(spec), _filters(spec.controller.filters)
        loop = ImpedanceLoop(_port(spec, elastic), nominal, desired, filters)
        return cls(spec, loop, _uncertainty(spec, nominal), elastic)

    @cached_property
    def impedances(self) -> dict[str, Uncertain]:
        """Parameters of the desired impedance that are a range."""
        wish = self.spec.impedance
        ranges = {name: value for name in LOAD if isinstance(value := getattr(wish, name), tuple)}
        return {name: (exact(low), exact(high), _middle((low, high))) for name, (low, high) in ranges.items()}

    @cached_property
    def actuators(self) -> dict[str, Uncertain]:
        """Parameters of the actuator that are uncertain."""
        box, found = self.spec.uncertainty.actuator, {}
        for name, symbol in ACTUATOR.items():
            interval = getattr(box, name, None)
            if interval is not None and interval[0] < interval[1]:
                found[name] = (exact(interval[0]), exact(interval[1]), getattr(self.elastic, symbol))
        return found

    @property
    def boxed(self) -> bool:
        """Whether there is more than one joint: a box of loads, a range of impedances or uncertain actuators."""
        box = self.uncertainty.box
        return bool(self.impedances or self.actuators) or (
            box is not None and any(low < high for low, high in (box.inertia, box.damping, box.stiffness))
        )

    @property
    def polynomial(self) -> bool:
        """Whether every question is one about polynomials: no hold, no table, no range of impedances or actuators."""
        return not (self.loop.actuator.hold or self.impedances or self.actuators or self.uncertainty.table)

    def vertices(self, *, actuators: bool = True) -> Iterator[Setting]:
        """This setting with every range of impedances (and actuators) at each end; itself where there is none."""
        ranges = {f"impedance.{k}": v for k, v in self.impedances.items()}
        ranges |= {f"actuator.{k}": v for k, v in self.actuators.items()} if actuators else {}
        for ends in product(*(v[:2] for v in ranges.values())):
            yield self.at(dict(zip(ranges, ends, strict=True)))

    def at(self, values: dict[str, fmpq]) -> Setting:
        """This setting with parameters at given values: `impedance.stiffness`, `actuator.motor_inertia`, …"""
        wish = {k.split(".")[1]: v for k, v in values.items() if k.startswith("impedance.")}
        drive: dict[str, Any] = {ACTUATOR[k.split(".")[1]]: v for k, v in values.items() if k.startswith("actuator.")}
        loop, elastic = replace(self.loop, desired=replace(self.loop.desired, **wish)), self.elastic
        if drive and elastic is not None:
            elastic = replace(elastic, **drive)
            loop = replace(loop, actuator=replace(elastic.two_port, hold=loop.actuator.hold))
        return replace(self, loop=loop, elastic=elastic)

    def resolved(self, corner: Fraction | None) -> Setting:
        """This setting with a corner [rad/s] in the place of a free one. Raises: InputError where one is missing."""
        spec = resolved(self.spec, corner)
        return self if spec is self.spec else Setting.of(spec)

    def held(self, hold: Hold | None) -> Setting:
        """This setting with another hold between command and actuator, or without."""
        return replace(self, loop=replace(self.loop, actuator=replace(self.loop.actuator, hold=hold)))

    def build(self, num: Any, den: Any) -> Compensator:
        """The compensator C that polynomials of Q or of C_imp stand for."""
        return (disturbance_observer if self.spec.controller.type == "dob" else dynamic_error_feedback)(num, den)

    def compensator(self, coefficients: Polynomials) -> Compensator:
        """The compensator C a controller's coefficients (of Q or of C_imp) stand for."""
        return self.build(polynomial(coefficients.numerator), polynomial(coefficients.denominator))

    def unfiltered(self, coefficients: Polynomials) -> Polynomials:
        """The Q or C_imp that does without F what the given one does behind it."""
        C, loop = self.compensator(coefficients), self.loop
        same = loop.Q_ideal(C) if self.spec.controller.type == "dob" else C.rational * loop.filters.force
        return Polynomials(numerator=descending(same.num), denominator=descending(same.den))

    def variable(self, which: Variable, C: Compensator) -> Any:
        """What a constraint is about, for one compensator."""
        loop = self.loop
        of = {
            Variable.Q: loop.Q_ideal,
            Variable.Q_TILDE: loop.Q_tilde,
            Variable.L: loop.L,
            Variable.COMMAND: loop.noise_gain,
        }
        return of[which](C)

    def variables(self, C: Compensator) -> dict[Variable, Any]:
        """What constraints are about, for one compensator."""
        return {which: self.variable(which, C) for which in Variable}


def rational(coefficients: Polynomials) -> RationalFunction:
    """Coefficients of a specification as a rational function."""
    return RationalFunction.of(coefficients.numerator, coefficients.denominator)


def _uncertainty(spec: Spec, nominal: DynamicStiffness) -> Uncertainty:
    box, weight, table = spec.uncertainty.box, spec.uncertainty.weight, spec.uncertainty.table
    return Uncertainty(
        nominal,
        None if box is None else LoadBox(_pair(box.inertia), _pair(box.damping), _pair(box.stiffness)),
        None if weight is None else rational(weight),
        None if table is None else Table(*(tuple(exact(p[k]) for p in table.points) for k in (0, 1))),
    )


def _pair(interval: Interval) -> tuple[fmpq, fmpq]:
    return exact(interval[0]), exact(interval[1])


def _middle(value: Any) -> fmpq:
    """A number, or the middle of an interval."""
    return (exact(value[0]) + exact(value[1])) / 2 if isinstance(value, tuple) else exact(value)


def _elastic(spec: Spec) -> SeriesElastic | None:
    a = spec.actuator
    if not isinstance(a, SeriesElasticActuator):
        return None
    C_t = torque_loop(a.torque_loop.kp, a.torque_loop.kd, a.torque_loop.derivative_corner)
    J, b_m, K_sp = exact(a.motor_inertia), exact(a.motor_damping), exact(a.spring_stiffness)
    return SeriesElastic(J, b_m, K_sp, C_t, exact(a.torque_loop.feedforward))


def _port(spec: Spec, elastic: SeriesElastic | None) -> TwoPort:
    port = IDEAL if elastic is None else elastic.two_port
    if isinstance(spec.actuator, TwoPortActuator):
        port = TwoPort.given(*((polynomial(p.numerator), polynomial(p.denominator)) for p in _transfers(spec.actuator)))
    if spec.sampling is None:
        return port
    return replace(port, hold=Hold(1 / exact(spec.sampling.rate), exact(spec.sampling.delay)))


def _transfers(actuator: TwoPortActuator) -> tuple[Polynomials, Polynomials]:
    return actuator.transfer, actuator.impedance


def _filters(spec: FilterSpec) -> Filters:
    """Models of the filters; of a free one, which the search multiplies to C, nothing is known yet: 1."""

    def first_order(corner: object) -> RationalFunction:
        return ONE if corner in (None, "none", FREE) else low_pass(corner)  # type: ignore[arg-type]

    position = None if spec.position is None else first_order(spec.position)
    return Filters(first_order(spec.force), position, first_order(spec.derivative))
