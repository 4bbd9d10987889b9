"""The one shape every constraint has, at each frequency:

    Σ gain_i·|a_i + b_i X| + Re(e + f X) + [v]  ≤  [v]·|g + h X|   or   Re(g + h X)

`a, b, e, f, g, h` are exact rational functions of s = jω, X is Q or Q̃, gains depend on the radius W(ω) of Δ, and the
*level* v enters in one place, named by its role. From this one definition come the margin (NumPy), the cone (cvxpy),
the NLP expression (CasADi), the proof (exact) and the curve in the report: each walks the same terms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from typing import Any

import numpy as np

from ....models.impedance import DynamicStiffness
from ....models.rational import ONE, ZERO, RationalFunction
from ..variable import Variable as Variable

Band = tuple[Fraction, Fraction | None]  # interval of ω [rad/s], upper end None for infinity
WHOLE: Band = (Fraction(0), None)


class Gain(Enum):
    """Factors made of the radius W of |Δ| ≤ W. `|Δ/(1+Δ)| ≤ R`; it fills the disc of `centre` and radius RHO."""

    ONE = "1"
    W = "W"
    R = "W/(1−W)"
    RHO = "W/(1−W²)"

    def of(self, W: Any) -> Any:
        """The factor for an array or expression of W; infinite on arrays where W ≥ 1 leaves Δ/(1+Δ) unbounded."""
        if self is Gain.ONE:
            return 1.0
        if self is Gain.W:
            return W
        return _unbounded_beyond_one(W, np.inf, lambda W: W / (1 - W) if self is Gain.R else W / (1 - W**2))


def centre(W: Any) -> Any:
    """Centre `−W²/(1−W²)` of the disc that Δ/(1+Δ) fills when |Δ| ≤ W < 1; its radius is RHO."""
    return _unbounded_beyond_one(W, -np.inf, lambda W: -(W**2) / (1 - W**2))


def _unbounded_beyond_one(W: Any, limit: float, ratio: Callable[[Any], Any]) -> Any:
    if hasattr(W, "where_below_one"):  # an enclosure
        return W.where_below_one(ratio(W))
    if not isinstance(W, np.ndarray):
        return ratio(W)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(W < 1, ratio(W), limit)


class Source(Enum):
    """Which Δ the gains speak of."""

    NONE = "none"
    DISC = "disc"  # weight and table alone, V; the box is handled at its corners
    LUMPED = "lumped"  # all in one disc, W = W_b + V + W_b V


class Role(Enum):
    """Where the level v enters, and which way it tightens."""

    RADIUS = "v·W"  # v scales the uncertainty: larger is harder, 1 is required
    FLOOR = "+ v"  # v is added on the left: larger is harder
    CEILING = "v·right"  # v scales the right side: larger is easier

    @property
    def harder(self) -> int:
        """+1 when raising v tightens the constraint, −1 when it loosens it."""
        return -1 if self is Role.CEILING else 1


@dataclass(frozen=True)
class Affine:
    """`constant + slope·X`."""

    constant: Any  # rational functions, or enclosures of their values
    slope: Any

    @classmethod
    def of(cls, constant: Any, slope: Any = ZERO) -> Affine:
        """From anything a rational function can be made of."""
        return cls(RationalFunction.lift(constant), RationalFunction.lift(slope))

    def __call__(self, X: RationalFunction) -> Any:
        """The exact value for one X(s)."""
        return self.constant + self.slope * X

    def __add__(self, other: Affine) -> Affine:
        return Affine(self.constant + other.constant, self.slope + other.slope)

    def __mul__(self, factor: Any) -> Affine:
        return Affine(self.constant * factor, self.slope * factor)


X = Affine(ZERO, ONE)
ONE_MINUS_X = Affine(ONE, -ONE)


@dataclass(frozen=True)
class Term:
    """`gain·|affine + c·shift|` or its real part, c the centre of the disc of Δ/(1+Δ)."""

    affine: Affine
    gain: Gain = Gain.ONE
    shift: Affine | None = None


@dataclass(frozen=True)
class Inequality:
    """One inequality at every frequency of an interval, for one load (a corner) or for none in particular."""

    variable: Variable
    role: Role
    right: Affine
    modulus_right: bool
    moduli: tuple[Term, ...] = ()
    reals: tuple[Term, ...] = ()
    source: Source = Source.NONE
    load: DynamicStiffness | None = None

    @property
    def convex(self) -> bool:
        """Whether the set of X is convex: the right side is a fixed number or a real part."""
        return not self.modulus_right or self.right.slope == ZERO

    def sides(self, v: Any, W: Any, X: Any, at: Any) -> tuple[Any, Any]:
        """Left and right side. `at` turns a rational function into its values; X and the results are of that kind.

        Arithmetic only, so the same lines serve NumPy arrays, cvxpy and CasADi expressions: objects that add,
        multiply and have `abs` and `.real`. Every numeric view of a constraint comes from here.
        """

        def value(affine: Affine) -> Any:
            constant = at(affine.constant)
            return constant if affine.slope == ZERO else constant + at(affine.slope) * X

        W = v * W if self.role is Role.RADIUS else W
        left = v if self.role is Role.FLOOR else 0.0
        for terms, part in ((self.moduli, abs), (self.reals, lambda z: z.real)):
            for term in terms:
                inside = value(term.affine)
                if term.shift is not None:
                    inside = inside + value(term.shift) * centre(W)
                left = left + part(inside if term.gain is Gain.ONE else inside * term.gain.of(W))
        right = abs(value(self.right)) if self.modulus_right else value(self.right).real
        return left, v * right if self.role is Role.CEILING else right

    def level(self, W: Any, X: Any, at: Any) -> tuple[Any, Any]:
        """Numerator and denominator of the level v at which both sides are equal; see `sides` for the arguments.

        FLOOR, RADIUS: the hardest one that holds, where the numerator is positive. CEILING: the least one.
        """
        if self.role is Role.CEILING:
            return self.sides(1.0, W, X, at)
        if self.role is Role.FLOOR:
            rest, right = self.sides(0.0, W, X, at)
            return right - rest, 1.0
        fixed, scaled = (tuple(t for t in self.moduli if (t.gain is Gain.ONE) is one) for one in (True, False))
        moving = replace(self, moduli=scaled, right=Affine.of(0), modulus_right=False)
        rest, right = replace(self, moduli=fixed).sides(0.0, W, X, at)
        if any(term.gain is Gain.R for term in scaled):  # vW/(1−vW), which is 1 at vW = 1/2
            whole, _ = moving.sides(1.0, 0.5, X, at)
            return right - rest, (whole + right - rest) * W
        whole, _ = moving.sides(1.0, W, X, at)
        return right - rest, whole


def needs_disc(inequality: Inequality) -> bool:
    """Whether its gains are those of Δ/(1+Δ), which mean something only where W < 1."""
    terms = inequality.moduli + inequality.reals
    return any(term.gain in (Gain.R, Gain.RHO) or term.shift is not None for term in terms)


@dataclass(frozen=True)
class Constraint:
    """A numbered condition: its inequalities (all must hold), what is asked of it, what to do where it is impossible.

    positive_real: the ends s = 0 and ∞ count, too.
    level: the v that is required, or None when the claim is only reported. band: where it holds;
    `on_band`: [0, ω_B], the objective's own; `largest_band`: the largest interval on which it holds.
    """

    id: str
    equation: str
    form: str
    statement: str
    uncertainty: str
    inequalities: tuple[Inequality, ...]
    level: Fraction | None
    band: Band = WHOLE
    on_band: bool = False
    largest_band: bool = False
    strict: bool = True
    positive_real: bool = False
    remedy: str = ""

    @property
    def required(self) -> bool:
        """Whether the specification asks for it."""
        return self.level is not None

    @property
    def role(self) -> Role:
        """Where the level enters; the same in all inequalities."""
        return self.inequalities[0].role
