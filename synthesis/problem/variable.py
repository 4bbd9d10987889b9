"""The closed-loop quantities that constraints are about."""

from __future__ import annotations

from enum import Enum


class Variable(Enum):
    """What X stands for."""

    Q = "Q"  # Q̃ behind an ideal actuator: the Q of the paper's (9), (12), (18)
    Q_TILDE = "Q̃"  # complementary sensitivity of the physical loop, (★)
    L = "L"  # loop gain HCF
    COMMAND = "Q̃/H"  # CF/(1+HCF), command torque per noise of the torque sensor
