"""Pieces that tests put into the good specification, which says none of these keys."""

from __future__ import annotations

Pair = tuple[str, str]

_ACTUATOR = """{type: series-elastic, motor_inertia: 0.01, motor_damping: 0.05, spring_stiffness: 4.8,
  torque_loop: {kp: 10, kd: 0.25, derivative_corner: 1000, feedforward: 1}}"""
TWO_PORT = (
    "{type: two-port, transfer: {numerator: [100], denominator: [1, 20, 100]},\n"
    "  impedance: {numerator: [0.01, 0.05, 0], denominator: [1/100, 1]}}"
)


def sampling(text: str) -> Pair:
    """In line 12."""
    return "peak: 2.0}", f"peak: 2.0}}\nsampling: {text}"


def stiffness(text: str) -> Pair:
    """In line 8."""
    return "stiffness: 1.25", f"stiffness: {text}"


def inertia(text: str) -> Pair:
    """In line 8."""
    return "inertia: nominal", f"inertia: {text}"


def loose_actuator(text: str) -> Pair:
    """In line 5."""
    return "stiffness: [0, 0]}", f"stiffness: [0, 0]}}, actuator: {text}"


def table(text: str) -> Pair:
    """In line 5."""
    return "stiffness: [0, 0]}", f"stiffness: [0, 0]}}, table: {text}"


def actuator(text: str) -> Pair:
    """In lines 6 and 7."""
    return _ACTUATOR, text


def spring(text: str) -> Pair:
    """In line 6."""
    return "spring_stiffness: 4.8", f"spring_stiffness: {text}"


def motor(text: str) -> Pair:
    """In line 6."""
    return "motor_inertia: 0.01", f"motor_inertia: {text}"


def demand(text: str) -> Pair:
    """In line 11."""
    return "peak: 2.0", f"peak: 2.0, {text}"


EVERY_NEW_KEY = (
    sampling("{rate: 1 kHz, delay: 1 ms}"),
    stiffness("[0.2, 4]"),
    inertia("nominal ±10 %"),
    ("inertia: ±20 %", "inertia: ±10 %"),
    table("{points: [[0, 0.1], [1 Hz, 5 %], [100, 1/3]], beyond: hold}, actuator: {motor_inertia: ±10 %}"),
    demand("noise: {gain: 30, above: 200 rad/s}, tolerance: float32"),
)
