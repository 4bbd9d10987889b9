"""A constraint that no complex number X satisfies at some frequency, by closed form; at ω → 0 by leading coefficients.

These statements are exact where a search of the plane cannot look: in the limit, and where W reaches 1.
"""

from __future__ import annotations

import numpy as np
from flint import fmpq

from ...models.rational import ZERO, RationalFunction, to_float
from ...models.sampling import Held
from ...models.uncertainty import Uncertainty
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Affine, Constraint, Inequality, needs_disc
from ..problem.grid import Evaluator, frequency_scale
from ..problem.setting import Setting
from .reason import Impossible, name


def alone(setting: Setting) -> Impossible | None:
    """The first required constraint that fails by itself for every X: at ω → 0, or at its worst frequency."""
    low, high = frequency_scale(setting)
    evaluator = Evaluator(setting, np.geomspace(low / 30, high * 30, 600))
    for c in (c for vertex in setting.vertices() for c in constraints(vertex)):
        if not c.required or c.on_band:
            continue
        for inequality in c.inequalities:
            if c.band[0] == 0 and (ratio := _ratio_at_zero(inequality, setting)) >= 1:
                return _exceeded(c, 0.0, ratio)
            inside = evaluator.inside(c)
            if needs_disc(inequality) and np.any(beyond := inside & (evaluator.radius(inequality.source) >= 1)):
                why = "W ≥ 1 there, which leaves Δ/(1+Δ) unbounded"
                return Impossible(name(c), float(evaluator.omega[beyond][0]), why, c.remedy)
            if c.form == "disc" and c.band[1] is None and _lasts(setting.uncertainty):
                why = "the disc leaves the phase of Z free there (its budget falls like 1/ω, the disc does not)"
                return Impossible(name(c), np.inf, why, c.remedy)
            ratio_on_grid = np.where(inside, _best_ratio(inequality, evaluator), 0.0)
            k = int(np.argmax(ratio_on_grid))
            if ratio_on_grid[k] >= 1:
                return _exceeded(c, float(evaluator.omega[k]), float(ratio_on_grid[k]))
    return None


def _exceeded(c: Constraint, omega: float, ratio: float) -> Impossible:
    """By how much: the least left/right that any X reaches."""
    why = "its right side vanishes" if np.isinf(ratio) else f"left/right is at best {ratio:.4g} and must be below 1"
    return Impossible(name(c), omega, why, c.remedy)


def _lasts(uncertainty: Uncertainty) -> bool:
    """Whether W(∞) > 0: an uncertain inertia, or a weight that is not strictly proper."""
    box, weight, table = uncertainty.box, uncertainty.weight, uncertainty.table
    return (
        (box is not None and box.inertia[0] < box.inertia[1])
        or (weight is not None and weight.relative_degree == 0)
        or (table is not None and table.bound[-1] > 0)
    )


def _best_ratio(inequality: Inequality, evaluator: Evaluator) -> np.ndarray:
    """min over X of left/right on the grid; 0 where the right side depends on X. Returns (n,)."""
    omega = evaluator.omega
    if not inequality.modulus_right or inequality.right.slope != ZERO or len(inequality.moduli) > 2:
        return np.zeros_like(omega)
    W = evaluator.radius(inequality.source)
    fixed, distances = np.zeros_like(omega), []
    for term in inequality.moduli:
        gain = np.broadcast_to(term.gain.of(W), omega.shape)
        a, b = term.affine.constant.at(omega), term.affine.slope.at(omega)
        if term.affine.slope == ZERO:
            fixed = fixed + gain * np.abs(a)
        else:
            distances.append((gain * np.abs(b), -a / b))
    if len(distances) == 2:  # two weighted distances from X: best at the heavier one's centre
        (w1, x1), (w2, x2) = distances
        fixed = fixed + np.minimum(w1, w2) * np.abs(x1 - x2)
    return np.asarray(fixed / np.abs(inequality.right.constant.at(omega)))


def _ratio_at_zero(inequality: Inequality, setting: Setting) -> float:
    """The same at ω → 0 for any X finite there, by leading coefficients; 0 where X still has a say."""
    if not inequality.modulus_right:
        return 0.0
    affines = [inequality.right, *(term.affine for term in inequality.moduli)]
    order = min(_order(r) for affine in affines for r in (affine.constant, affine.slope))
    if any(_order(affine.slope) <= order for affine in affines):
        return 0.0
    tiny = np.array([frequency_scale(setting)[0] * 1e-8])
    W = Evaluator(setting, tiny).radius(inequality.source)
    left = sum(float(np.max(term.gain.of(W))) * _lead(term.affine, order) for term in inequality.moduli)
    right = _lead(inequality.right, order)
    if left < right * (1 - 1e-12):
        return 0.0
    return float("inf") if right == 0 else max(left / right, 1.0)


def _order(r: RationalFunction | Held) -> int:
    """Order of the zero (negative: pole) at s = 0."""
    r = r.at_rest if isinstance(r, Held) else r
    if r.num.degree() < 0:
        return 10**6
    return _valuation(r.num.coeffs()) - _valuation(r.den.coeffs())


def _valuation(coefficients: list[fmpq]) -> int:
    return next(k for k, c in enumerate(coefficients) if c != 0)


def _lead(affine: Affine, order: int) -> float:
    """Modulus of the coefficient of s^order of the constant part at s → 0."""
    r = affine.constant
    r = r.at_rest if isinstance(r, Held) else r
    if _order(r) > order:
        return 0.0
    num, den = r.num.coeffs(), r.den.coeffs()
    return abs(to_float(num[_valuation(num)] / den[_valuation(den)]))
