"""Constraints that no complex number X satisfies together at some frequency, and how near to it X can come.

The least set of them that leaves no X is named (in the plane three are enough where they are convex), and for each one
the best level any X reaches there while the others hold: by how much the wish is out of reach.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...models.sampling import Held
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Role
from ..problem.grid import frequency_scale
from ..problem.setting import Setting
from .plane import EXISTS, NONE, Demand, Plane
from .reason import Impossible, name, shortfall

if TYPE_CHECKING:
    from numpy.typing import NDArray

POINTS = 300
BEYOND = 1e6  # times the highest frequency of the joint: as good as infinite
CLEARLY = 1e-6  # relative shortfall in the limit that is no equality
STEPS = 16  # of a bisection
FIRST_STEP, WIDENINGS = 1e-3, 30  # of a level, in its own unit or relative, doubled until some X reaches it

Group = tuple[Demand, ...]


def conflict(setting: Setting) -> Impossible | None:
    """Why what is required leaves no X at some frequency; the objective's own constraints count at ω → 0 only."""
    clash = _clash(setting)
    return clash if clash is None or isinstance(clash, Impossible) else _described(setting, *clash)


def conflicting(setting: Setting) -> bool:
    """Whether there is a conflict: the same without the description."""
    return _clash(setting) is not None


def _clash(setting: Setting) -> Impossible | tuple[list[Group], NDArray[np.float64]] | None:
    """Constraints and the frequencies at which they leave no X, or what fails at ω → ∞."""
    low, high = frequency_scale(setting)
    omega = np.geomspace(low / 30, high * 30, POINTS)
    groups = groups_of(setting)
    off_band = [group for group in groups if not group[0].constraint.on_band]
    for chosen, where in ((groups, omega[:1]), (off_band, omega)):
        empty = where[_search(setting, where, chosen) == NONE]
        if empty.size:
            return chosen, empty
    return _at_infinity(setting, off_band, high * BEYOND)


def groups_of(setting: Setting) -> list[Group]:
    """Required constraints, each for every vertex of the ranges."""
    found: dict[tuple[str, str], list[Demand]] = {}
    for vertex in setting.vertices():
        for c in constraints(vertex):
            if c.level is not None:
                found.setdefault((c.id, c.form), []).append(Demand(c, vertex, float(c.level)))
    return [tuple(group) for group in found.values()]


def _search(setting: Setting, omega: NDArray[np.float64], groups: Sequence[Group]) -> NDArray[np.int_]:
    return Plane(setting, omega).search([demand for group in groups for demand in group])


def _described(setting: Setting, groups: Sequence[Group], empty: NDArray[np.float64]) -> Impossible:
    """The least set of constraints that conflict, where the first of them is farthest out of reach."""
    some = empty[[empty.size // 2]]
    least = list(groups)
    for group in groups:
        rest = [other for other in least if other is not group]
        if rest and _search(setting, some, rest)[0] == NONE:
            least = rest
    omega = empty[_search(setting, empty, least) == NONE]
    reached = [_best(setting, omega, group, [o for o in least if o is not group]) for group in least]
    first = least[0][0]
    k = int(np.argmax(np.nan_to_num(np.abs(reached[0] - first.level), nan=np.inf)))
    names = [name(group[0].constraint) for group in least]
    while_others = " while the rest holds" if len(least) > 1 else ""
    why = "; ".join(
        f"{n}: {shortfall(group[0].constraint, float(levels[k]))}{while_others}"
        for n, group, levels in zip(names, least, reached, strict=True)
    )
    remedy = next((group[0].constraint.remedy for group in least if group[0].constraint.remedy), "relax one of them")
    return Impossible(" and ".join(names), float(omega[k]), why, remedy if len(least) == 1 else "relax one of them")


def _best(setting: Setting, omega: NDArray[np.float64], group: Group, others: Sequence[Group]) -> NDArray[np.float64]:
    """The hardest level of a constraint that some X reaches while the others hold; nan where none. Returns (n,)."""
    plane, asked = Plane(setting, omega), group[0].level
    rest = [demand for other in others for demand in other]

    def reaches(level: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.asarray(plane.search([*(replace(d, level=level) for d in group), *rest]) == EXISTS)

    hard, easy, step = np.full(omega.size, float(asked)), np.full(omega.size, np.nan), FIRST_STEP
    role = group[0].constraint.role
    for _ in range(WIDENINGS):
        level = {Role.CEILING: asked * (1 + step), Role.FLOOR: asked - step, Role.RADIUS: max(1 - step, 0.0)}[role]
        reached = reaches(np.full(omega.size, level)) & np.isnan(easy)
        easy[reached] = level
        hard[np.isnan(easy)] = level
        step *= 2
        if not np.isnan(easy).any() or (role is Role.RADIUS and level == 0):
            break
    for _ in range(STEPS):
        middle = (hard + easy) / 2
        reached = reaches(np.nan_to_num(middle, nan=asked))
        hard, easy = np.where(reached, hard, middle), np.where(reached, middle, easy)
    return easy


def _at_infinity(setting: Setting, groups: Sequence[Group], far: float) -> Impossible | None:
    """A constraint that fails where Q̃ has died out, as it must beyond every actuator (`Q̃ ~ s⁻²` or faster)."""
    H, F = setting.loop.actuator.H, setting.loop.filters.force
    if isinstance(H, Held):
        return None
    own = 2 if setting.spec.controller.type == "dob" else 0
    if own + H.relative_degree + F.relative_degree < 2:
        return None
    plane = Plane(setting, np.array([far]))
    for demand in (d for group in groups for d in group if d.constraint.band[1] is None):
        slack = plane.relative_slack(demand, 0.0)
        if slack < -CLEARLY:
            why = f"Q̃ has died out there, and what is left misses by {-100 * slack:.3g} % of its size"
            return Impossible(name(demand.constraint), np.inf, why, "relax it")
    return None
