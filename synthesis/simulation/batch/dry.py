"""One tick of a joint with dry friction: exact linear steps between events, an implicit step at each.

Friction is the set `f ∈ −F_c Sgn(v)`: between −F_c and F_c at rest, opposing the motion otherwise. While neither
contact changes between sticking and slipping, the torque does not saturate and the wall is not met, the joint is linear
and its step exact. A step at whose end one of these no longer holds, or in which the wall may have been met, is halved
until only the finest is left, and that one is implicit: the friction of both contacts is what makes the velocities at
its *end* obey the law. A contact that sticks has the velocity zero, not a small one.

State x: load velocity, load angle, then (if there is a motor) motor velocity, angle, then the rest. Inputs w of a
step: see `INPUTS`. Switches, each −1, 0 or 1: where load and motor slip to (0: stick), saturation, wall (0: clear).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled, inlined

Array = NDArray[np.float64]
Switches = NDArray[np.int64]

INPUTS = ("push", "disturbance", "held", "motion", "load_friction", "motor_friction", "limit", "wall_offset")
FRICTION, LIMIT, WALL = 4, 6, 7  # of INPUTS
CONTACTS = 2  # load, motor: their velocities are x[0] and x[2]
SATURATED, TOUCHING = 2, 3  # of switches
READ = ("load_friction", "motor_friction", "demand", "tau_int")  # rows: friction that holds the contact, torques
DEMAND, TAU_INT = 2, 3
RESOLVED = 0.5  # rad of the motion on the wall that a step against it may take
SWEEPS = 50  # of the two contacts; they meet only through the spring, so two or three suffice


class Limits(NamedTuple):
    """Coulomb friction of load and motor [N·m], torque limit [N·m] (inf: none), wall: stiffness, damping, place [rad].

    `stiction`: what a contact at rest holds, over its Coulomb friction; at least 1. `wall_rate`: [rad/s], of the
    lightest load on the wall.
    """

    load_friction: float
    motor_friction: float
    torque: float
    wall_stiffness: float
    wall_damping: float
    wall_place: float
    stiction: float
    wall_rate: float


@inlined
def mode(switches: Switches) -> int:
    """Which of the sixteen linear systems holds: bits for load stuck, motor stuck, saturated, touching."""
    bits = 1 if switches[0] == 0 else 0
    bits += 2 if switches[1] == 0 else 0
    bits += 4 if switches[SATURATED] != 0 else 0
    return bits + (8 if switches[TOUCHING] != 0 else 0)


@compiled
def halved(
    x: Array, w: Array, steps: Array, rows: Array, switches: Switches, limits: Limits, y: Array, h: float
) -> int:
    """Advance x by a tick h [s] in which something switches, each step as long as its laws hold to its end.

    `steps` (modes, levels, n, n + m) and `rows` (modes, 4, n + m); changes x and switches; y is scratch, (n,). Returns
    how many implicit steps it took.
    """
    whole = 1 << (steps.shape[1] - 1)
    at, events = 0, 0
    while at < whole:
        span = (at & -at) if at else whole
        level = _level(span, whole)
        while span > 1:
            advance(x, w, steps, level, switches, limits, y)
            good = holds(y, w, rows, switches, limits)
            if good and limits.wall_place < np.inf:
                touching = switches[TOUCHING] != 0
                good = not wall_missed(x[0], x[1], y[0], y[1], touching, limits, h * span / whole)
            if good:
                break
            span, level = span >> 1, level + 1
        if span == 1:
            _implicit(x, w, steps, rows, switches, limits, y)
            events += 1
        for i in range(len(x)):
            x[i] = y[i]
        at += span
    return events


@inlined
def _level(span: int, whole: int) -> int:
    level = 0
    while span < whole:
        span <<= 1
        level += 1
    return level


@inlined
def advance(x: Array, w: Array, steps: Array, level: int, switches: Switches, limits: Limits, y: Array) -> None:
    """`y = x + D_ℓ (x, w)` with the friction of the contacts that slip."""
    w[FRICTION] = -limits.load_friction * switches[0]
    w[FRICTION + 1] = -limits.motor_friction * switches[1]
    w[LIMIT] = limits.torque * switches[SATURATED] if switches[SATURATED] else 0.0
    w[WALL] = limits.wall_stiffness * limits.wall_place if switches[TOUCHING] else 0.0
    _linear(x, w, steps, mode(switches), level, y)


@inlined
def _linear(x: Array, w: Array, steps: Array, m: int, level: int, y: Array) -> None:
    n = len(x)
    for i in range(n):
        value = x[i]
        for j in range(n):
            value += steps[m, level, i, j] * x[j]
        for j in range(len(w)):
            value += steps[m, level, i, n + j] * w[j]
        y[i] = value


@inlined
def read(rows: Array, m: int, signal: int, x: Array, w: Array) -> float:
    """A signal of READ in mode m, by its row over state and inputs."""
    value = 0.0
    for j in range(len(x)):
        value += rows[m, signal, j] * x[j]
    for j in range(len(w)):
        value += rows[m, signal, len(x) + j] * w[j]
    return value


@inlined
def _touches(x: Array, limits: Limits) -> bool:
    """Behind the place of the wall, and pressed: it does not pull."""
    depth = x[1] - limits.wall_place
    return bool(depth > 0 and limits.wall_stiffness * depth + limits.wall_damping * x[0] > 0)


@inlined
def _saturation(demand: float, limits: Limits) -> int:
    return 0 if abs(demand) <= limits.torque else (1 if demand > 0 else -1)


@inlined
def _sticks(y: Array, w: Array, rows: Array, m: int, contact: int, limits: Limits) -> bool:
    return bool(abs(read(rows, m, contact, y, w)) <= limits[contact] * limits.stiction)


@compiled
def wall_missed(
    v: float, theta: float, v_end: float, theta_end: float, touching: bool, limits: Limits, h: float
) -> bool:
    """Whether the wall may have been met, or left, within a step h [s] whose ends do not show it.

    It turned in between: it went no further than where the tangents of the two ends cross.
    """
    if touching and limits.wall_rate * h > RESOLVED:
        return True
    away = -1.0 if touching else 1.0
    if not (away * v > 0 and away * v_end < 0):
        return False
    furthest = theta + v * (theta_end - v_end * h - theta) / (v - v_end)
    return bool(away * (furthest - limits.wall_place) > 0)


@inlined
def holds(y: Array, w: Array, rows: Array, switches: Switches, limits: Limits) -> bool:
    """Whether the laws that were assumed for a step still hold at its end."""
    m, good = mode(switches), True  # one way out: the compiler then keeps no count of references
    for contact in range(CONTACTS):
        if limits[contact] > 0:
            if switches[contact] == 0:
                good = good and _sticks(y, w, rows, m, contact, limits)
            else:
                good = good and y[2 * contact] * switches[contact] > 0
    if limits.torque < np.inf:
        good = good and _saturation(read(rows, m, DEMAND, y, w), limits) == switches[SATURATED]
    if limits.wall_place < np.inf:
        good = good and _touches(y, limits) == (switches[TOUCHING] != 0)
    return good


@compiled
def _implicit(x: Array, w: Array, steps: Array, rows: Array, switches: Switches, limits: Limits, y: Array) -> None:
    """The finest step: frictions such that the velocities at its end obey them (a linear complementarity problem)."""
    finest = steps.shape[1] - 1
    if limits.torque < np.inf:
        switches[SATURATED] = _saturation(read(rows, mode(switches), DEMAND, x, w), limits)
    if limits.wall_place < np.inf:
        switches[TOUCHING] = 1 if _touches(x, limits) else 0
    for _ in range(CONTACTS + 1):  # stuck contacts stay stuck unless that asks too much of them
        advance(x, w, steps, finest, switches, limits, y)
        torn = False
        for contact in range(CONTACTS):
            if switches[contact] == 0 and not _sticks(y, w, rows, mode(switches), contact, limits):
                switches[contact] = 1 if read(rows, mode(switches), contact, y, w) < 0 else -1
                torn = True
        if not torn:
            break
    _frictions(x, w, steps, switches, limits, y)
    for contact in range(CONTACTS):
        if limits[contact] > 0 and switches[contact] != 0:
            v = 2 * contact
            if abs(w[FRICTION + contact]) < limits[contact]:
                y[v] = 0.0
                switches[contact] = 0
            else:
                switches[contact] = 1 if w[FRICTION + contact] < 0 else -1


@compiled
def _frictions(x: Array, w: Array, steps: Array, switches: Switches, limits: Limits, y: Array) -> None:
    """Frictions of the contacts that are not stuck by turns, each the best answer to the other, and the step y."""
    n, m, finest = len(x), mode(switches), steps.shape[1] - 1
    for _ in range(SWEEPS):
        changed = False
        for contact in range(CONTACTS):
            if limits[contact] > 0 and switches[contact] != 0:
                _linear(x, w, steps, m, finest, y)
                v, old, gain = (
                    y[2 * contact],
                    w[FRICTION + contact],
                    steps[m, finest, 2 * contact, n + FRICTION + contact],
                )
                new = old - v / gain if gain > 0 else (-np.inf if v > 0 else np.inf)
                new = min(max(new, -limits[contact]), limits[contact])
                changed = changed or abs(new - old) > 1e-15 * limits[contact]
                w[FRICTION + contact] = new
        if not changed:
            break
    _linear(x, w, steps, m, finest, y)
