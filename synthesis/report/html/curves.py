"""The numbers behind the plots over frequency, each from the one definition of what it shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ...problem.constraints import constraints
from ...problem.constraints.inequality import Affine, Constraint, Inequality, Role, Source
from ...problem.grid import Evaluator
from ...problem.variable import Variable
from ...spec.model import Eq18
from .words import load_names

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ....models.controller import Compensator
    from ...problem.setting import Setting
    from .study import CheckedClaim, Study

    Real = NDArray[np.float64]
    Complex = NDArray[np.complex128]


class Loop(Protocol):
    """A joint with its controller, at the frequencies (n,) [rad/s] of a curve."""

    @property
    def setting(self) -> Setting:
        """Its models."""

    @property
    def compensator(self) -> Compensator:
        """Its controller."""

    @property
    def omega(self) -> Real:
        """[rad/s]."""


NEVER = 1e-9  # a factor on W so small that an inequality which fails with it holds with none


@dataclass(frozen=True)
class Level:
    """How hard a constraint could be made at each frequency: worst over loads and ends of ranges. values: (n,)."""

    checked: CheckedClaim
    constraint: Constraint
    values: Real


def levels(study: Study) -> list[Level]:
    """One curve for each claim that is a constraint, in the order of the certificate."""
    claims = {(c.claim.id, c.claim.form): c for c in study.claims}
    worst: dict[tuple[str, str], Real] = {}
    defined: dict[tuple[str, str], Constraint] = {}
    for vertex in study.setting.vertices():
        evaluator, variables = Evaluator(vertex, study.omega), vertex.variables(study.compensator)
        for c in constraints(vertex):
            for inequality in c.inequalities:
                values = _hardest(evaluator, inequality, variables)
                known = worst.get((c.id, c.form), values)
                worst[c.id, c.form] = (np.fmax if c.role is Role.CEILING else np.fmin)(known, values)
            defined.setdefault((c.id, c.form), c)
    return [Level(claims[kind], defined[kind], worst[kind]) for kind in claims if kind in worst]


def _hardest(evaluator: Evaluator, inequality: Inequality, variables: dict[Variable, Any]) -> Real:
    """The hardest level at each frequency; of a factor on W, 0 where the inequality fails without uncertainty."""
    values = evaluator.levels(inequality, variables)
    if inequality.role is Role.RADIUS:
        values = np.where(evaluator.slack(inequality, NEVER, variables) < 0, 0.0, values)
    return np.where(np.isfinite(values), values, np.nan)


@dataclass(frozen=True)
class Port:
    """Apparent impedance of one joint, and the one it should have [N·m/rad]. Z, wish: (n,)."""

    name: str
    nominal: bool
    Z: Complex
    wish: Complex


def ports(study: Loop) -> list[Port]:
    """Every corner of the box of loads after the nominal load, at each end of every range of impedances."""
    loads = list(dict.fromkeys([study.setting.uncertainty.nominal, *study.setting.uncertainty.corners()]))
    vertices = list(study.setting.vertices(actuators=False))
    wishes = load_names([study.setting.loop.desired, *(v.loop.desired for v in vertices)])[1:]
    found = []
    for vertex, wish in zip(vertices, wishes, strict=True):
        for k, (load, name) in enumerate(zip(loads, load_names(loads), strict=True)):
            Z = vertex.loop.Z_at(study.compensator, load, study.omega)
            of = f", desired {wish}" if wish else ""
            found.append(Port(name + of, k == 0, Z, vertex.loop.desired.rational.at(study.omega)))
    return found


@dataclass(frozen=True)
class Nyquist:
    """What Δ sees: poles in free motion are the zeros of `1 + (1+Δ)ℓ`, so ℓ(1+Δ) must not reach −1. All (n,)."""

    ell: Complex
    radius: Real  # W|ℓ|
    wall: Complex  # HCF, whose return difference is that of a rigid wall


@np.errstate(all="ignore")
def nyquist(study: Study) -> Nyquist:
    """`ℓ = T/((1−Q)Ĝ⁻¹)` from (18) with the load and actuator coupled as they are, of ranges the middle."""
    setting = _with_physical_eq18(study.setting)
    (constraint,) = constraints(setting, only="eq18")
    (inequality,), evaluator = constraint.inequalities, Evaluator(setting, study.omega)
    X = setting.variables(study.compensator)[Variable.Q].at(study.omega)
    T, D0 = (_values(affine, X, study.omega) for affine in (inequality.moduli[0].affine, inequality.right))
    ell = T / (D0 - T)
    wall = np.asarray(setting.loop.L(study.compensator).at(study.omega))
    return Nyquist(ell, evaluator.radius(Source.LUMPED) * np.abs(ell), wall)


def _with_physical_eq18(setting: Setting) -> Setting:
    asked = setting.spec.constraints.model_copy(update={"eq18": Eq18(form="half-plane", coupling="physical")})
    return replace(setting, spec=setting.spec.model_copy(update={"constraints": asked}))


def _values(affine: Affine, X: Complex, omega: Real) -> Complex:
    return np.asarray(affine.constant.at(omega) + affine.slope.at(omega) * X)


def least_resistance(study: Loop) -> Real:
    """Smallest `Re(Z/jω)` over the joints of `ports` [N·m·s/rad]: what (12) keeps from falling below 0. (n,)."""
    return np.asarray(np.min([(port.Z / (1j * study.omega)).real for port in ports(study)], axis=0))


def filters(study: Loop) -> Iterator[tuple[str, Complex]]:
    """Q, Q̃ and what is left of a disturbance, 1−Q̃, by name; of uncertain actuators the nominal one. Values: (n,)."""
    variables = study.setting.variables(study.compensator)
    X = variables[Variable.Q_TILDE].at(study.omega)
    yield "|1−Q̃|", 1 - X
    yield "|Q̃|", X
    yield "|Q|", variables[Variable.Q].at(study.omega)
