"""Stability of the sampled loop for every joint of the boxes: no root reaches the unit circle.

With the nominal loop proven stable, exactly, none does if the characteristic function f ≠ 0 at z = e^{jωT} for every ω
in [0, π/T] and every parameter. There the joint answers with its frequency response behind the hold, and with all
aliases at ω ± 2πk/T, which are bounded:

    f = (joint denominator)·(law denominator) + (law numerator)·((joint numerator)·hold + (joint denominator)·R),
    |R| ≤ ω κ ζ(3) (1/(ω_s − ω)³ + 1/ω_s³),   κ ≥ ω² |joint| from π/T on,   ω_s = 2π/T

as |hold| ≤ ω/|ω_k| at the k-th alias ω_k. f is affine in load and impedance: on a cell it fills a zonotope. Only the
parameters of uncertain actuators are halved, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, product
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from ..certificate.claim import Claim, Refutation
from ..certificate.enclosure.cells import Cells, Part, axis
from ..certificate.enclosure.claims import EVERY
from ..certificate.enclosure.exclusion import off_zero
from ..certificate.enclosure.joint import Family
from ..certificate.enclosure.wave import Wave
from ..certificate.outcome import Outcome
from ..certificate.stability import MODES
from ..certificate.witness import Witness, short
from ..problem.constraints.inequality import WHOLE
from ..problem.grid import frequency_scale
from .law import Law
from .pulse import characteristic, decays, precision
from .sampled_joint import SampledJoint

if TYPE_CHECKING:
    from numpy.typing import NDArray

START, ROUNDS, MOST_CELLS = 600, 24, 20_000
HALVINGS = 12  # of the axis beyond π/T, for a bound there
ZETA_3 = 1.2020570
SHARES = (0.99, 0.95, 0.9, 0.8, 0.65, 0.5)  # of the certificate's margin that are tried
MOST_VERTICES = 64
ABOVE = 1 + 1e-12  # for roundings of single steps


@dataclass(frozen=True)
class Box:
    """Every joint of a family's boxes, at one end (free or locked), under one law."""

    family: Family
    law: Law
    end: str

    def prove(self, certified: Fraction | None) -> Claim:
        """Whether the box is stable, stretched by as much of the certified factor as is reached; or where it is not."""
        stretched = [short(float(certified or 0) * share, up=False) for share in SHARES]
        levels = [v for v in stretched if v > 1] + [Fraction(1)]
        proven = next((v for v in levels if self.excluded(v)), None)
        unstable = None if proven else next(self._unstable(), None)
        status = Outcome.PROVEN if proven else Outcome.UNDECIDED if unstable is None else Outcome.REFUTED
        return Claim(
            id=f"stability-{self.end}",
            equation=MODES[self.end][0],
            form="box",
            statement=f"{MODES[self.end][1]} of the sampled loop decays for every joint of the boxes, stretched by v, "
            "aliases included",
            uncertainty=EVERY[self.end],
            interval=WHOLE,
            required=True,
            status=status,
            margin=proven,
            refuted_at=None if unstable is None else Refutation(Fraction(1), unstable),
        )

    @np.errstate(all="ignore")
    def excluded(self, spread: Fraction) -> bool:
        """Whether f ≠ 0 on the whole circle for every joint of the box stretched by a factor."""
        setting = self.family.setting
        family = replace(self.family, setting=setting.held(None), spread=spread, loads=True)
        m, rate = len(family.parameters), float(self.law.rate)
        last = short(pi * rate * ABOVE, digits=12, up=True)
        kappa = self._kappa(family, pi * rate * (1 - 1e-9))
        if not np.isfinite(kappa):
            return False
        low = frequency_scale(setting)[0] / 30
        bent = np.array([k for k, name in enumerate(family.parameters) if name.startswith("actuator.")], dtype=int)
        for cells in axis(min(low, rate), float(last) * 2, m, START, (Fraction(0), last)):
            for turn in range(ROUNDS):
                away = off_zero([self._f(family, cells, kappa)], cells)
                cells = cells[~away]
                if not cells.size:
                    break
                in_turn = bent.size and turn % 2
                cells = cells.split_parameter(_widest(cells, bent)) if in_turn else cells.split_frequency()
                if cells.size > MOST_CELLS:
                    return False
            if cells.size:
                return False
        return True

    def _f(self, family: Family, cells: Cells, kappa: float) -> Wave:
        """The characteristic function with its aliases."""
        joint, omega_s = SampledJoint(family, cells, self.law), 2 * pi * float(self.law.rate)
        hold = self.family.setting.loop.actuator.hold
        assert hold is not None
        num, den, feedback, behind = joint.characteristic(self.end)
        high = cells.z[1] * ABOVE
        R = alias_bound(kappa, omega_s * (1 - 1e-12), high)
        aliases = Wave(cells.ball(-high * R, high * R), cells.ball(-R, R), joint.s.x)
        return den * behind + feedback * (num * cells.hold(hold) + den * aliases)

    def _kappa(self, family: Family, start: float) -> float:
        """A bound of `ω² |joint|` from a frequency on."""
        cells = Cells.whole(Part.HIGH, np.array([[0.0], [1 / start]]), len(family.parameters))
        every = np.arange(len(family.parameters))
        for turn in range(HALVINGS):
            joint = SampledJoint(family, cells, self.law)
            num, den, _, _ = joint.characteristic(self.end)
            size = abs(num * joint.s.x / den)
            bound = size.shifted(min(size.order, 0)).upper if size.order >= 0 else np.array([np.inf])
            if np.isfinite(bound).all():
                return float(bound.max())
            in_turn = every.size and turn % 2 == 0
            cells = cells.split_parameter(_widest(cells, every)) if in_turn else cells.split_frequency()
        return np.inf

    def _unstable(self) -> Iterator[Witness]:
        """Vertices of the boxes whose sampled loop is proven unstable."""
        ranges = replace(self.family, loads=True).parameters
        for ends in islice(product(*ranges.values()), MOST_VERTICES):
            values = dict(zip(ranges, ends, strict=True))
            load, wish = (self._numbers(values, part) for part in ("load", "impedance"))
            setting = self.family.setting.at({k: v for k, v in values.items() if k.startswith("actuator.")})
            with precision(1024):
                law = replace(self.law, desired=replace(self.law.desired, **wish))
                at = replace(setting.loop.nominal, **load)
                stable = decays(characteristic(setting, law, self.end, at))
            if stable is False:
                yield Witness(None, at if load else None)

    @staticmethod
    def _numbers(values: dict[str, fmpq], part: str) -> dict[str, fmpq]:
        return {name.split(".")[1]: value for name, value in values.items() if name.startswith(part)}


def alias_bound(kappa: float, omega_s: float, omega: Any) -> Any:
    """`|R|/ω ≤ κ ζ(3) (1/(ω_s − ω)³ + 1/ω_s³)`, at frequencies ω [rad/s] below half of ω_s."""
    return ABOVE * kappa * ZETA_3 * (1 / (omega_s - omega) ** 3 + 1 / omega_s**3)


def _widest(cells: Cells, among: NDArray[np.int_]) -> NDArray[np.int_]:
    """Of these parameters the one of which most is left."""
    return np.asarray(among[np.argmax((cells.t[1] - cells.t[0])[among], axis=0)])
