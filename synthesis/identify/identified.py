"""Records to a nominal model, what they deviate from it, and the weight that covers the deviation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..notebook import card
from ..spec.model import Interval, Polynomials
from ..spec.record import Bounds, Record, envelope, unusable
from ..spec.selection import select
from ..spec.table import MAX_ROWS
from .cover import MOST_ORDER, cover, steps
from .nominal import MOST_ORDER as MOST_POLES
from .nominal import Load, Transfer, fit_load, fit_transfer

Kind = Literal["load", "actuator"]
Beyond = Literal["hold"] | Interval


@dataclass(frozen=True)
class Identified:
    """What measured responses say: `measured = model·(1+Δ)`, `|Δ(jω)| ≤ |weight(jω)|`.

    `bounds`: the largest |Δ| of the kept records at each frequency [rad/s]. `spread`: their largest deviation from
    their own mean, (n,): what no choice of a model undercuts by much. `beyond`: |Δ| below and above the measured band,
    as stated. `left_out`: records by name, and why; `other_amplitudes`: names of those outside of `amplitude`.
    """

    kind: Kind
    model: Load | Transfer
    weight: Polynomials
    bounds: Bounds
    spread: tuple[float, ...]
    beyond: Interval
    amplitude: Interval | None
    kept: tuple[Record, ...]
    left_out: dict[str, str]
    other_amplitudes: tuple[str, ...]

    def __repr__(self) -> str:
        largest = f"|Δ| up to {float(max(value for _, value in self.bounds)):.3g}"
        return f"<Identified {self.kind} from {len(self.kept)} records: {largest}, {len(self.left_out)} left out>"

    def _repr_html_(self) -> str:
        rows = [("records", ", ".join(record.name for record in self.kept)), ("W(s)", str(self.weight))]
        rows += [(f"left out: {name}", reason) for name, reason in self.left_out.items()]
        return card(f"{self.kind}, identified", rows=rows)

    @property
    def omega(self) -> NDArray[np.float64]:
        """Measured frequencies (n,) [rad/s]."""
        return np.array([float(omega) for omega, _ in self.bounds])

    @property
    def deviation(self) -> NDArray[np.float64]:
        """Largest |Δ| at the measured frequencies, (n,)."""
        return np.array([float(value) for _, value in self.bounds])

    def gain(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """`|weight(jω)|`, (n,)."""
        N, D = (
            np.polyval([float(c) for c in part], 1j * omega)
            for part in (self.weight.numerator, self.weight.denominator)
        )
        return np.asarray(abs(N / D))


def identify(
    records: Sequence[Record],
    *,
    kind: Kind,
    beyond: Beyond,
    amplitude: Interval | None = None,
    exclude: Sequence[str] = (),
    order: int = 2,
    poles: int = 4,
    zeros: int = 1,
) -> Identified:
    """Leave out dead and incoherent records, fit the nominal model, cover every other record by a weight.

    The weight holds at every ω: between two samples of a record with the larger of the two, outside of the measured
    band with what is stated.

    Args:
        records: of a load `θ/τ_int` [rad/(N·m)], or of an actuator's `H`, torque per torque with the output locked.
        kind: which of the two.
        beyond: |Δ| (below, above) the measured band, or `hold`: the deviations at its ends.
        amplitude: range of the excitation that counts; required when the records have several.
        exclude: names of records, `*` and `?` stand for any letters.
        order: of the weight, at most.
        poles: of H.
        zeros: of H, fewer than poles.

    Raises:
        InputError: nothing usable among the records, or an order out of range.
    """
    if not records:
        raise InputError("expected at least one record of frequency responses")
    _demand(0 <= order <= MOST_ORDER, f"expected an order of the weight from 0 to {MOST_ORDER}; found {order}")
    _demand(1 <= poles <= MOST_POLES, f"expected 1 to {MOST_POLES} poles; found {poles}")
    _demand(0 <= zeros < poles, f"expected fewer zeros than poles, at least 0; found {zeros} and {poles}")
    selection = select(records, amplitude, exclude, None)
    kept, left_out = selection.kept, dict.fromkeys(selection.excluded, "excluded by name")
    while faults := unusable(kept):
        left_out |= faults
        kept = tuple(record for record in kept if record.name not in faults)
    _demand(bool(kept), f"no usable record is left: {next(iter(left_out.items()), '')}")
    count = len({sample.omega for record in kept for sample in record.samples})
    _demand(count <= MAX_ROWS, f"expected at most {MAX_ROWS} frequencies in all records; found {count}")
    model = fit_load(kept) if kind == "load" else fit_transfer(kept, poles, zeros)
    bounds = envelope(kept, model.inverse)
    ends = _ends(bounds, beyond)
    weight = cover(steps(bounds, *ends), order)
    spread, others = _spread(kept, bounds), selection.other_amplitudes
    return Identified(kind, model, weight, bounds, spread, ends, amplitude, kept, left_out, others)


def _ends(bounds: Bounds, beyond: Beyond) -> Interval:
    if beyond == "hold":
        return bounds[0][1], bounds[-1][1]
    for stated, (omega, measured) in zip(beyond, (bounds[0], bounds[-1]), strict=True):
        least = f"expected at least the {float(measured):g} that was measured at {float(omega):g} rad/s"
        _demand(stated >= measured, f"beyond: {least}; found {float(stated):g}")
    return beyond


def _spread(records: Sequence[Record], bounds: Bounds) -> tuple[float, ...]:
    """Largest deviation from the mean, relative to it, of the records that have the frequency."""
    found: dict[Fraction, list[complex]] = {omega: [] for omega, _ in bounds}
    for record in records:
        for sample in record.samples:
            found[sample.omega].append(complex(sample.re, sample.im))
    means = [np.mean(values) for values in found.values()]
    return tuple(
        float(max(abs(np.array(values) / mean - 1))) if mean else float("inf")
        for values, mean in zip(found.values(), means, strict=True)
    )


def _demand(condition: bool, message: str) -> None:
    if not condition:
        raise InputError(message)
