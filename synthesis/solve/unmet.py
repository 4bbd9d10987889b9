"""Why the bound finds nothing: constraints that no Q̃ of its basis meets together, though at each frequency some X does.

With one of them eased as far as it takes, the bound's convex program says how near the best Q̃ comes to it while the
others hold as asked, and its multipliers say where. A solver's figures on a grid and a finite basis are evidence, not
a proof: what is said here leaves the question undecided.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint, Role
from ..problem.setting import Setting
from .band import BandProgram
from .bound import FIRST_TERMS, SLOW, wide_program
from .cone import Failure
from .reason import Unmet, name, place, shortfall

CLEARLY = 1e-3  # beyond the level asked; less is within what the solver is accurate to


def unmet(setting: Setting) -> Unmet | None:
    """A least set of constraints that no Q̃ of the basis meets, even as ω_B → 0; None where it finds no such set."""
    program = _program(setting)
    least = list(dict.fromkeys(watched.rows.id for watched in program.watched))
    if not _excluded(program, least):
        return None
    for id in list(least):
        rest = [other for other in least if other != id]
        if rest and _excluded(_program(setting, rest), rest):
            least = rest
    program = _program(setting, least)
    found = {c.id: c for c in constraints(setting) if c.id in least and c.required}
    said = [(c, said) for c in found.values() if (said := _missed(program, c, len(least) > 1)) is not None]
    if not said:
        return None
    names, omega = [name(c) for c in found.values()], said[0][1][1]
    why = "; ".join(f"{name(c)}: {text}" for c, (text, _) in said)
    return Unmet(" and ".join(names), omega, why, "", f"any Q̃ made of {FIRST_TERMS} basis functions")


def attainable(setting: Setting) -> bool:
    """Whether some Q̃ of the basis meets everything as ω_B → 0; where the solver is lost, one may."""
    program = _program(setting)
    return not _excluded(program, [watched.rows.id for watched in program.watched])


def _program(setting: Setting, among: Sequence[str] | None = None) -> BandProgram:
    return wide_program(setting, FIRST_TERMS, among, SLOW)


def _excluded(program: BandProgram, among: Sequence[str]) -> bool:
    """Whether the solver finds no Q̃ that meets a program's constraints, of which there may be none."""
    if not among:
        return False
    level = program.level(program.omega[0], "" if program.band else among[-1])
    return level is Failure.INFEASIBLE or (not isinstance(level, Failure) and level > 1 + CLEARLY)


def _missed(program: BandProgram, constraint: Constraint, others: bool) -> tuple[str, float] | None:
    """By how much the best Q̃ misses one constraint while the others hold, and where [rad/s]; None if none helps."""
    level = program.level(program.omega[0], constraint.id)
    if isinstance(level, Failure):
        return None
    omega = 0.0 if constraint.on_band else next(b.most for b in program.binding() if b.constraint == constraint.id)
    if constraint.role is Role.RADIUS:
        text = f"left/right is at best {level:.4g} and must be below 1"
    else:
        asked = float(constraint.level or 0)
        best = asked * level if constraint.role is Role.CEILING else asked - (level - 1) * program.unit(constraint.id)
        text = shortfall(constraint, best, "such a Q̃")
    return f"{text}, at {place(omega)}{' while the rest holds' if others else ''}", omega
