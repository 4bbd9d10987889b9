"""What is not known of the joint: a box of loads, a weight, a table, a box of actuators."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal, cast

from ..errors import InputError, Location
from .data_file import data_file
from .exact import decimal_text
from .fields import described, entries, polynomials, quantity, require, word
from .measured import measured, origin
from .model import Actuator, ActuatorBox, Box, Interval, Plant, SeriesElasticActuator, Table, Uncertainty
from .ranges import around
from .table import Point, ordered, read_table
from .tree import Node, Sequence, joined
from .units import FREQUENCY, RATIO, Mechanics

_LOAD = {"inertia": "inertia", "damping": "damping", "stiffness": "stiffness"}
_MOTOR = {"motor_inertia": "inertia", "motor_damping": "damping", "spring_stiffness": "stiffness"}
_SPRUNG = ("inertia", "spring_stiffness", "motor_inertia")  # what must not vanish


def uncertainty(
    node: Node, units: Mechanics, plant: Plant, actuator: Actuator | None, folder: Path | None
) -> Uncertainty:
    """A box, a weight, a table (or measured responses, which become one), any of them; and a box of actuators.

    Args:
        node: the section.
        units: of the boxes.
        plant: the nominal load.
        actuator: the nominal actuator; None: it could not be read, and its own error is reported.
        folder: where data files are; None: nowhere.
    """
    section = entries(node, optional=("box", "weight", "table", "measured", "actuator"))
    message = "expected `box:`, `weight:`, `table:` or `measured:`; a load known exactly has a box of [v, v]"
    require(bool(section.keys() - {"actuator"}), message, node.where)
    both = "expected a table or measured responses, which become one; found both; keep the larger bounds in one table"
    require(not section.keys() >= {"table", "measured"}, both, node.where)
    table = _table(section["table"], folder) if "table" in section else None
    return Uncertainty(
        box=_box(section["box"], units, plant) if "box" in section else None,
        weight=polynomials(section["weight"]) if "weight" in section else None,
        actuator=_actuator(section["actuator"], units, actuator) if "actuator" in section and actuator else None,
        table=measured(section["measured"], plant, folder) if "measured" in section else table,
    )


def _box(node: Node, units: Mechanics, plant: Plant) -> Box:
    section = entries(node, optional=_LOAD)
    for key in _LOAD:
        value = decimal_text(getattr(plant, key))
        require(key in section, f"expected {key} too; write {key}: [{value}, {value}] if it is exact", node.where)
    return Box(**_intervals(section, _LOAD, units, plant))


def _actuator(node: Node, units: Mechanics, actuator: Actuator) -> ActuatorBox:
    message = f"only a series-elastic actuator has these parameters; this one is {actuator.type}; remove the box"
    if not isinstance(actuator, SeriesElasticActuator):
        raise InputError(message, node.where)
    section = entries(node, optional=_MOTOR)
    require(bool(section), f"expected one of {', '.join(_MOTOR)}, or several; found none", node.where)
    return ActuatorBox(**_intervals(section, _MOTOR, units, actuator))


def _intervals(
    section: dict[str, Node], kinds: dict[str, str], units: Mechanics, nominal: Plant | SeriesElasticActuator
) -> dict[str, Interval]:
    found = {key: around(node, getattr(units, kinds[key]), getattr(nominal, key)) for key, node in section.items()}
    for key, (low, _) in found.items():
        sign = "> 0" if key in _SPRUNG else "≥ 0"
        message = f"expected a box in which every {key} is {sign}; found {decimal_text(low)} at its low end"
        message += "; write a smaller share, or [low, high]"
        require(low > 0 or (low == 0 and key not in _SPRUNG), message, section[key].where)
    return found


def _table(node: Node, folder: Path | None) -> Table:
    section = entries(node, optional=("file", "points", "beyond", "measured"))
    where = node.where
    given = " and ".join(key for key in ("file", "points") if key in section) or "none"
    require(given in ("file", "points"), f"expected exactly one of file, points; found {given}; keep one", where)
    missing = Location(where.file, where.line, where.column, joined(where.key, "beyond"))
    message = "write `beyond: hold` to say that the first bound holds down to ω = 0 and the last one up to ω = ∞"
    require("beyond" in section, f"expected this key; it is missing, and it has no default; {message}", missing)
    beyond = cast(Literal["hold"], word(section["beyond"], "hold"))
    if "file" in section:
        file = section["file"]
        require("measured" not in section, "only points carry the files they came from; remove it", where)
        return Table(points=read_table(data_file(file, folder), file.where), beyond=beyond)
    points = section["points"]
    if not isinstance(points, Sequence):
        message = f"expected a list of points, [[10, 0.1], [100, 0.5]]; found {described(points)}"
        raise InputError(message, points.where)
    source = origin(section["measured"]) if "measured" in section else None
    return Table(points=ordered(_points(points), points.where), beyond=beyond, measured=source)


def _points(node: Sequence) -> Iterator[Point]:
    for item in node.items:
        if not isinstance(item, Sequence) or len(item.items) != 2:
            found = f"a list of {len(item.items)}" if isinstance(item, Sequence) else described(item)
            raise InputError(f"expected a point [frequency, bound]; found {found}", item.where)
        omega, bound = item.items
        yield Point(item.where, quantity(omega, FREQUENCY), quantity(bound, RATIO))
