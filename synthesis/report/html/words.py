"""Numbers and specifications in words."""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from ....models.rational import exact, to_float
from ...spec.units import MECHANICS
from ..phrases import margin_phrase

if TYPE_CHECKING:
    from ...certificate.claim import Claim
    from ...spec.model import Interval, Spec

SHORT, LONG, DECIMALS = 6, 9, 5  # digits of a number; below 10⁻⁵ and beyond its digits it gets a power of ten
SYMBOLS = {"I": "inertia", "B": "damping", "K": "stiffness"}
SYMBOL = re.compile(r"(?<![\w.])([^\W\d_])_([^\W_]+)(?!\w)")  # ω_B, K_sp: a letter and its index
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def real(value: Any) -> float:
    """The nearest double of an exact number, ±inf beyond their range."""
    return to_float(exact(value))


def number(value: Fraction | float) -> str:
    """Six digits, of an exact number up to nine; `≈` where it has more."""
    exactly = Fraction(value)
    for digits in (SHORT, LONG):
        decimal = rounded(exactly, digits)
        if isinstance(value, float) or Fraction(decimal) == exactly:
            return _written(decimal, digits)
    return f"≈ {_written(rounded(exactly, SHORT), SHORT)}"


def rounded(value: Fraction, digits: int, rounding: str = ROUND_HALF_EVEN) -> Decimal:
    """The nearest decimal with so many digits, or the next one, without trailing zeros; of any size."""
    context = Context(prec=digits, rounding=rounding)
    return context.divide(Decimal(value.numerator), Decimal(value.denominator)).normalize()


def floor(value: Fraction) -> str:
    """Six digits, rounded down: what is proven of the exact number holds of the printed one."""
    return f"{Context(prec=SHORT, rounding=ROUND_FLOOR).divide(Decimal(value.numerator), Decimal(value.denominator)):f}"


def margin(claim: Claim, motion: str) -> str:
    """What a claim's margin says, with its unit; six digits, rounded so that it stays proven; nothing without one."""
    if claim.margin is None:
        return ""
    phrase, rounding = margin_phrase(claim.form, motion)
    return phrase.format(_written(rounded(claim.margin, SHORT, rounding), SHORT))


def symbols(text: str) -> Markup:
    """Text as HTML, escaped, in which symbols with an index are typeset: ω_B, K_sp."""
    return Markup(SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", str(escape(text))))


def _written(decimal: Decimal, digits: int) -> str:
    power = decimal.adjusted()
    if not decimal or -DECIMALS <= power < digits:
        return f"{decimal:f}".replace("-", "−")
    return f"{decimal.scaleb(-power):f}·10{str(power).translate(SUPERSCRIPT)}".replace("-", "−")


def load_names(loads: Sequence[Any]) -> list[str]:
    """`nominal` for the first load, for the others the parameters that differ somewhere: `I=0.024 B=0.12`."""
    values = [{key: real(getattr(load, name)) for key, name in SYMBOLS.items()} for load in loads]
    varying = [key for key in SYMBOLS if len({one[key] for one in values}) > 1]
    return [" ".join(f"{key}={one[key]:.4g}" for key in varying) if k else "nominal" for k, one in enumerate(values)]


def span(low: Fraction, high: Fraction | None) -> str:
    """An interval of frequencies; six digits, rounded inwards."""
    first = _written(rounded(low, SHORT, ROUND_CEILING), SHORT)
    return f"[{first}, {'∞' if high is None else _written(rounded(high, SHORT, ROUND_FLOOR), SHORT)}]"


def quantity(value: Fraction | Interval, unit: str, nominal: Fraction | None = None) -> str:
    """`0.03 kg·m² ± 20 %`, `0.2 … 10 N·m/rad`, `2 N·m/rad`."""
    if not isinstance(value, tuple) or value[0] == value[1]:
        return f"{number(value[0] if isinstance(value, tuple) else value)} {unit}"
    low, high = value
    if nominal and nominal - low == high - nominal:
        return f"{number(nominal)} {unit} ± {number(100 * (high - nominal) / nominal)} %"
    tail = "" if nominal is None else f" (nominal {number(nominal)})"
    return f"{number(low)} … {number(high)} {unit}{tail}"


def described(spec: Spec) -> list[tuple[str, str]]:
    """A specification for a reader: what it is about, and what it says."""
    lines = [("Load", _load(spec)), ("Actuator", _actuator(spec)), ("Should feel like", _impedance(spec))]
    if spec.sampling is not None:
        held = f"hold of {number(1000 / spec.sampling.rate)} ms ({number(spec.sampling.rate)} Hz)"
        lines.append(("Sampled", f"{held}, computation delay {number(1000 * spec.sampling.delay)} ms"))
    lines += [("Controller", _controller(spec)), ("Objective", _objective(spec)), ("Must also hold", _demands(spec))]
    return lines


def units(spec: Spec) -> dict[str, str]:
    """The SI units of inertia, damping and stiffness in this motion."""
    mechanics = MECHANICS[spec.motion]
    return {name: next(iter(getattr(mechanics, name).units)) for name in ("inertia", "damping", "stiffness")}


def _load(spec: Spec) -> str:
    box, uncertainty, parts = spec.uncertainty.box, spec.uncertainty, []
    for name, unit in units(spec).items():
        nominal = getattr(spec.plant, name)
        if nominal or (box is not None and any(getattr(box, name))):
            value = nominal if box is None else getattr(box, name)
            parts.append(f"{name} {quantity(value, unit, nominal)}")
    if uncertainty.weight is not None:
        parts.append("on top |Δ(jω)| ≤ |W(jω)|, a rational weight")
    if uncertainty.table is not None:
        parts.append(f"on top |Δ(jω)| below a table of {len(uncertainty.table.points)} points")
    if box is None and uncertainty.weight is None and uncertainty.table is None:
        parts.append("known exactly")
    return "; ".join(parts)


def _actuator(spec: Spec) -> str:
    from ...spec.model import IdealActuator, SeriesElasticActuator

    actuator = spec.actuator
    if isinstance(actuator, IdealActuator):
        return "ideal: the torque is the command"
    if not isinstance(actuator, SeriesElasticActuator):
        return "two-port, H and Z_a given as transfer functions"
    unit, parts = units(spec), []
    for name, dimension, symbol in (
        ("spring_stiffness", "stiffness", "spring K_sp"),
        ("motor_inertia", "inertia", "motor J"),
        ("motor_damping", "damping", "b_m"),
    ):
        box, nominal = spec.uncertainty.actuator, getattr(actuator, name)
        interval = getattr(box, name, None)
        parts.append(f"{symbol} {quantity(nominal if interval is None else interval, unit[dimension], nominal)}")
    loop = actuator.torque_loop
    parts.append(f"torque loop kp {number(loop.kp)}, kd {number(loop.kd)}, feedforward {number(loop.feedforward)}")
    return "series-elastic: " + ", ".join(parts)


def _impedance(spec: Spec) -> str:
    one = any(isinstance(getattr(spec.impedance, name), tuple) for name in units(spec))
    parts = [f"{name} {quantity(getattr(spec.impedance, name), unit)}" for name, unit in units(spec).items()]
    return ", ".join(parts) + (": one controller for the whole range" if one else "")


def _controller(spec: Spec) -> str:
    asked = spec.controller
    kind = "disturbance observer (10)" if asked.type == "dob" else "dynamic-error feedback (20)"
    if asked.coefficients is not None:
        how = "given coefficients, certified as they are"
    elif asked.form is not None:
        how = "of the form (23)"
    else:
        how = f"of order {asked.order}"
    corners = [(f"{name} filter", value) for name, value in asked.filters if isinstance(value, Fraction)]
    return ", ".join([f"{kind}, {how}", *(f"{name} at {number(value)} rad/s" for name, value in corners)])


def _objective(spec: Spec) -> str:
    text = f"attenuate load disturbances to {number(spec.objective.attenuation)} up to the highest frequency possible"
    error = spec.objective.rendering_error
    return text if error is None else f"{text}, and render the impedance within {number(error)} there"


def _demands(spec: Spec) -> str:
    asked, parts = spec.constraints, ["stable in free motion and against a rigid wall"]
    if asked.eq9 is not None:
        parts.append("robust stability (9)")
    if asked.eq12 is not None:
        on = "" if asked.eq12.band is None else f" on {span(*asked.eq12.band)} rad/s"
        parts.append(f"passivity (12), {asked.eq12.form}{on}")
    if asked.eq18 is not None:
        parts.append(f"robust stability with actuator (18), {asked.eq18.form}, {asked.eq18.coupling}")
    if asked.peak is not None:
        parts.append(f"peak |1−Q̃| ≤ {number(asked.peak)}")
    if asked.noise is not None:
        parts.append(f"command per sensor noise ≤ {number(asked.noise.gain)}")
    if asked.friction == "require":
        parts.append("no limit cycle from friction in free motion")
    if asked.tolerance is not None:
        parts.append(f"all of it with coefficients off by {number(100 * asked.tolerance)} %")
    return "; ".join(parts)
