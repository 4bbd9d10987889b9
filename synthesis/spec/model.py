"""What a specification says, with exact SI numbers: the frozen type every later station reads."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict

from ..notebook import card
from .exact import polynomial_text
from .outline import outline


class Section(BaseModel):
    """Base of every section: frozen, strict, no unknown keys."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", arbitrary_types_allowed=True)
    absent_when_none: ClassVar[frozenset[str]] = (
        frozenset()
    )  # keys younger than format 1: older digests must not change


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

    def to_control(self) -> Any:
        """The nearest `control.TransferFunction`.

        >>> from robimp.synthesis import load
        >>> spec = load("examples/haninger2016-paper.yaml")
        >>> spec.controller.coefficients.to_control().dcgain().item()
        0.8
        """
        import control

        return control.tf([float(c) for c in self.numerator], [float(c) for c in self.denominator])

    def __str__(self) -> str:
        return f"({polynomial_text(self.numerator)}) / ({polynomial_text(self.denominator)})"

    __repr__ = __str__


class ActuatorBox(Section):
    """Intervals that hold the true parameters of a series-elastic actuator; None: exactly the nominal one."""

    absent_when_none = frozenset({"motor_inertia", "motor_damping", "spring_stiffness"})

    motor_inertia: Interval | None = None
    motor_damping: Interval | None = None
    spring_stiffness: Interval | None = None


class DataFile(Section):
    """A file of measured responses, and the SHA-256 of what it held."""

    name: str
    sha256: str


class Measured(Section):
    """Where a table came from: its files, the range of amplitudes, the number of records, the records left out."""

    absent_when_none = frozenset({"amplitude"})

    files: tuple[DataFile, ...]
    records: int
    excluded: tuple[str, ...]
    amplitude: Interval | None = None


class Table(Section):
    """`|Δ(jω)| ≤ W(ω)` by points (ω in rad/s, bound), linear in ω between them; outside, the end bounds hold."""

    absent_when_none = frozenset({"measured"})

    points: tuple[tuple[Fraction, Fraction], ...]
    beyond: Literal["hold"]
    measured: Measured | None = None


class Uncertainty(Section):
    """How far the true joint may be from the nominal one; a weight and a table come on top of a box, and multiply.

    Of the load, `G = Ĝ(1+Δ)`: a box, a rational weight `|Δ(jω)| ≤ |W(jω)|`, a table. Of the actuator: its own box.
    """

    absent_when_none = frozenset({"actuator", "table"})

    box: Box | None = None
    weight: Polynomials | None = None
    actuator: ActuatorBox | None = None
    table: Table | None = None


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


class TwoPortActuator(Section):
    """`τ_act = H τ_d − Z_a θ` with H (`transfer`) and Z_a (`impedance`) given."""

    type: Literal["two-port"]
    transfer: Polynomials
    impedance: Polynomials


Actuator = IdealActuator | SeriesElasticActuator | TwoPortActuator


class Sampling(Section):
    """Zero-order hold of 1/`rate` (Hz) and a computation delay (s) between torque command and torque."""

    rate: Fraction
    delay: Fraction


class Impedance(Section):
    """`G_imp = I s² + B s + K`, what the port should feel like; an interval: one controller for the whole range."""

    inertia: Fraction | Interval
    damping: Fraction | Interval
    stiffness: Fraction | Interval


FREE: Literal["free"] = "free"  # a corner that the search chooses


class Filters(Section):
    """First-order sensor filters `1/(1 + s/corner)`; None: unfiltered. `position` None: the same filter as `force`.

    `force` filters τ_int, `position` θ in the dynamic error, `derivative` is F_d of the inner compensation (20).
    `force` FREE: the search chooses the corner of one filter on the whole dynamic error (`position` is None).
    """

    force: Fraction | Literal["free"] | None = None
    position: Fraction | Literal["none"] | None = None
    derivative: Fraction | None = None

    @property
    def force_corner(self) -> Fraction | None:
        """Corner of F [rad/s], None without. Raises: ValueError while it is free, and there is no F yet."""
        if self.force == FREE:
            raise ValueError("controller.filters.force: is free; only a search gives it a corner")
        return self.force


FORMS = {"dob": ("eq23",), "dynamic-feedback": ("p", "pi", "lead-lag", "pi-lead")}
FILTERED = "-filtered"
FORMS["dynamic-feedback"] += tuple(f"{form}{FILTERED}" for form in FORMS["dynamic-feedback"])
"""Forms by type: (23); C_imp as gain, with integrator, lead or lag, each also with a low-pass whose corner is free."""


class Controller(Section):
    """Which controller to find (`order` or `form`) or to certify (`coefficients`)."""

    type: Literal["dob", "dynamic-feedback"]
    order: int | None = None
    form: str | None = None
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


class Noise(Section):
    """Torque command per torque-sensor noise, output locked: `|C F/(1 + H C F)| ≤ gain` at every ω ≥ above (rad/s)."""

    gain: Fraction
    above: Fraction = Fraction(0)


class Constraints(Section):
    """What must be proven besides nominal stability and the bandwidth.

    `tolerance`: all of it still holds when every controller coefficient is wrong by up to this part of itself.
    """

    absent_when_none = frozenset({"noise", "tolerance"})

    eq9: Eq9 | None = None
    eq12: Eq12 | None = None
    eq18: Eq18 | None = None
    peak: Fraction | None = None
    friction: Literal["report", "require"] = "report"
    noise: Noise | None = None
    tolerance: Fraction | None = None


class Spec(Section):
    """One joint, its uncertainty, the impedance it should render, and what to prove."""

    absent_when_none = frozenset({"sampling"})

    robimp: Literal[1]
    name: str
    motion: Literal["rotary", "linear"]
    plant: Plant
    uncertainty: Uncertainty
    actuator: Actuator
    impedance: Impedance
    controller: Controller
    objective: Objective
    constraints: Constraints
    sampling: Sampling | None = None

    @property
    def behind_ideal_actuator(self) -> Spec:
        """The same joint with an ideal actuator and nothing sampled, of which (9) and the printed (12) speak."""
        loads = self.uncertainty.model_copy(update={"actuator": None})
        ideal = {"actuator": IdealActuator(type="ideal"), "sampling": None, "uncertainty": loads}
        return self.model_copy(update=ideal)

    def __repr__(self) -> str:
        return f"<Spec {self.name}: {self.motion}, {self.actuator.type}, {self.controller.type}>"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        return card(self.name, "specification", rows=outline(self))
