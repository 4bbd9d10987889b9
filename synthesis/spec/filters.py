"""Sensor filters of a specification: given corners, or one that the search chooses with the controller."""

from __future__ import annotations

from fractions import Fraction

from .fields import above, described, entries, require
from .model import FREE, Filters
from .tree import Node, Scalar
from .units import FREQUENCY

GIVEN = "nothing is searched where coefficients are given; give the corner they were made for, or leave `force` out"
TOGETHER = (
    "a free force filter acts on the whole dynamic error, and equal filters render better; leave `position` out, "
    "or give both corners"
)
ALONE = "only `force` can be free; leave `position` out: θ then has the filter of τ_int, whose corner is found"
UNPAID = (
    "no constraint charges for a fast derivative, so that what is possible only grows with its corner; "
    "give the one the drive differentiates with"
)


def filters(node: Node, *, coefficients: bool) -> Filters:
    """Sensor filters. coefficients: whether those of the controller are given, so that nothing is searched."""
    section = entries(node, optional=("force", "position", "derivative"))
    force, position, derivative = (section.get(key) for key in ("force", "position", "derivative"))
    free = force is not None and _is_free(force)
    if free and force is not None:
        require(not coefficients, f"expected an angular frequency > 0; found free: {GIVEN}", force.where)
    if position is not None:
        require(
            not _is_free(position), f"expected an angular frequency > 0, or none; found free: {ALONE}", position.where
        )
        require(not free, f"expected no position filter beside `force: free`: {TOGETHER}", position.where)
    if derivative is not None:
        require(not _is_free(derivative), f"expected an angular frequency > 0; found free: {UNPAID}", derivative.where)
    unfiltered = isinstance(position, Scalar) and position.text == "none"
    return Filters(
        force=FREE if free else _corner(force),
        position="none" if unfiltered else _corner(position),
        derivative=_corner(derivative),
    )


def _is_free(node: Node) -> bool:
    """Whether a corner is left to the search. Raises: InputError where that is meant, but not written so."""
    text = node.text if isinstance(node, Scalar) else ""
    meant = text.strip().casefold() == FREE
    message = f"expected an angular frequency > 0, or free; found {described(node)}; write free"
    require(not meant or text == FREE, message, node.where)
    return meant


def _corner(node: Node | None) -> Fraction | None:
    return None if node is None else above(node, 0, FREQUENCY)
