"""What a specification says, with exact SI numbers: the frozen type every later station reads."""

from __future__ import annotations

from fractions import Fraction
from typing import Literal

from pydantic import BaseModel, ConfigDict


class Section(BaseModel):
    """Base of every section: frozen, strict, no unknown keys."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", arbitrary_types_allowed=True)


Interval = tuple[Fraction, Fraction]


class Plant(Section):
    """Nominal load of (1): `I θ'' + B θ' + K θ = τ_int + τ_act`."""

    inertia: Fraction
    damping: Fraction
    stiffness: Fraction


class Box(Section):
    """Intervals that hold the true load parameters; each contains the nominal value."""

    inertia: Interval
    damping: Interval
    stiffness: Interval


class Polynomials(Section):
    """A rational function by its coefficients in descending powers of s (rad/s)."""

    numerator: tuple[Fraction, ...]
    denominator: tuple[Fraction, ...]


class Uncertainty(Section):
    """Sources of `G = Ĝ(1+Δ)`: a box of loads, a rational weight `|Δ(jω)| ≤ |W(jω)|`, or weight on top of box."""

    box: Box | None = None
    weight: Polynomials | None = None


class IdealActuator(Section):
    """`τ_act = τ_d`: H = 1, Z_a = 0."""

    type: Literal["ideal"]


class TorqueLoop(Section):
    """`τ_m = λ τ_d + C_t (τ_d − τ_sea)`, `C_t = kp + kd·s/(1 + s/derivative_corner)`."""

    kp: Fraction
    kd: Fraction
    derivative_corner: Fraction
    feedforward: Fraction


class SeriesElasticActuator(Section):
    """Motor J, b_m behind a spring K_sp, closed by the torque loop, (13)-(15)."""

    type: Literal["series-elastic"]
    motor_inertia: Fraction
    motor_damping: Fraction
    spring_stiffness: Fraction
    torque_loop: TorqueLoop


class Impedance(Section):
    """`G_imp = I s² + B s + K`, what the port should feel like."""

    inertia: Fraction
    damping: Fraction
    stiffness: Fraction


class Filters(Section):
    """First-order sensor filters `1/(1 + s/corner)`; None: unfiltered. `position` None: the same filter as `force`.

    `force` filters τ_int, `position` θ in the dynamic error, `derivative` is F_d of the inner compensation (20).
    """

    force: Fraction | None = None
    position: Fraction | Literal["none"] | None = None
    derivative: Fraction | None = None


class Controller(Section):
    """Which controller to find (`order` or `form`) or to certify (`coefficients`)."""

    type: Literal["dob", "dynamic-feedback"]
    order: int | None = None
    form: Literal["eq23"] | None = None
    coefficients: Polynomials | None = None
    filters: Filters = Filters()


class Objective(Section):
    """Largest ω_B with `|1 − Q̃| ≤ attenuation` on [0, ω_B], optionally with the rendering error bounded there too."""

    maximize: Literal["bandwidth"]
    attenuation: Fraction
    rendering_error: Fraction | None = None


class Eq9(Section):
    """Robust stability (9)."""


class Eq12(Section):
    """Passivity (12): as printed and corrected, exact over the disc, or at the vertices of the box."""

    form: Literal["paper", "disc", "structured"]
    band: Interval | None = None
    margin: Fraction = Fraction(0)


class Eq18(Section):
    """Robust stability with actuator dynamics (18)."""

    form: Literal["paper", "lumped", "half-plane"]
    coupling: Literal["frozen", "physical"]


class Constraints(Section):
    """What must be proven besides nominal stability and the bandwidth."""

    eq9: Eq9 | None = None
    eq12: Eq12 | None = None
    eq18: Eq18 | None = None
    peak: Fraction | None = None
    friction: Literal["report", "require"] = "report"


class Spec(Section):
    """One joint, its uncertainty, the impedance it should render, and what to prove."""

    robimp: Literal[1]
    name: str
    motion: Literal["rotary", "linear"]
    plant: Plant
    uncertainty: Uncertainty
    actuator: IdealActuator | SeriesElasticActuator
    impedance: Impedance
    controller: Controller
    objective: Objective
    constraints: Constraints
