"""The nearest H∞ problem: the joint's generalized plant in state space, for `hinfsyn` and D–K iteration.

What carries over: the joint with torque loop and the inner compensation of (2); the controller acting on the dynamic
error alone; inertia and damping of the load as two scalar uncertainties; passivity as `|reflected/incident| ≤ 1` at a
port closed by a damper β; the attenuation as the dynamic error `|G_imp θ − τ_int|` per disturbance, which is
`|(1−Q̃) G_imp/Z|` and so near `|1−Q̃|` where Z is near G_imp.

What cannot be said: `1−Q̃` itself (it belongs to the locked output, and one K in two loops is no H∞ problem), passivity
up to ω = ∞ (reflection tends to 1 there, so 3 % is given away), (9), (18), real instead of complex parameters, a range
of impedances (its middle is taken), and the order of the controller (reduced afterwards).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from task import Task

from robimp.synthesis.spec.model import SeriesElasticActuator

STATES, INPUTS, CONTROLS, MEASUREMENTS = 6, 6, 1, 1
GIVEN_AWAY = 0.97  # of the reflection coefficient
NOISE, EFFORT = 1e-3, 1e-3  # what makes the problem regular: sensor noise and a price of torque
FLOOR = 1 / 3  # of the attenuation: what the weight asks for at ω = 0


@dataclass(frozen=True)
class JointModel:
    """ẋ and outputs as linear functions of states and inputs; omega_1 [rad/s] places the performance weight."""

    task: Task
    omega_B: float

    def generalized_plant(self, *, uncertain: bool) -> Any:
        """Inputs (w_I, w_B,) port, d, n, u; outputs (z_I, z_B,) reflected, performance, effort, e: a `StateSpace`."""
        import control

        columns = np.array([self._flow(*row) for row in np.eye(STATES + INPUTS)]).T
        A, B = columns[:STATES, :STATES], columns[:STATES, STATES:]
        C, D = columns[STATES:, :STATES], columns[STATES:, STATES:]
        kept = slice(0 if uncertain else 2, None)
        return control.ss(A, B[:, kept], C[kept], D[kept, kept])

    def _flow(self, *states_and_inputs: float) -> list[float]:
        """Rates of the states, then the outputs."""
        theta, speed, motor, motor_speed, lag, weight, w_I, w_B, port, d, n, u = states_and_inputs
        spec, desired = self.task.setting.spec, self.task.setting.loop.desired
        a, box = spec.actuator, spec.uncertainty.box
        assert isinstance(a, SeriesElasticActuator) and box is not None
        I, B, K = (float(v) for v in (spec.plant.inertia, spec.plant.damping, spec.plant.stiffness))  # noqa: E741
        I_imp, B_imp, K_imp = (float(v) for v in (desired.inertia, desired.damping, desired.stiffness))
        J, b_m, K_sp = (float(v) for v in (a.motor_inertia, a.motor_damping, a.spring_stiffness))
        loop, beta = a.torque_loop, B_imp
        r_I, r_B = float(box.inertia[1]) / I - 1, float(box.damping[1]) / B - 1
        tau_d = u + (B - B_imp) * speed + (K - K_imp) * theta
        tau_sea = K_sp * (motor - theta)
        error = tau_d - tau_sea
        corner = float(loop.derivative_corner)
        tau_m = float(loop.feedforward) * tau_d + float(loop.kp) * error + float(loop.kd) * corner * (error - lag)
        tau_int = port - beta * speed
        acceleration = (tau_int + d + tau_sea - B * (speed + r_B * w_B) - K * theta) / I - r_I * w_I
        wished = I_imp * acceleration + B_imp * speed + K_imp * theta
        delta, M = self.task.attenuation, self.task.peak
        floor = delta * FLOOR
        omega_1 = self.omega_B / np.sqrt(delta**2 - floor**2)
        dynamic_error = wished - tau_int
        performance = dynamic_error / M + weight
        rates = [
            speed,
            acceleration,
            motor_speed,
            (tau_m - b_m * motor_speed - tau_sea) / J,
            corner * (error - lag),
            omega_1 * (1 - floor / M) * dynamic_error - omega_1 * floor * weight,
        ]
        reflected = GIVEN_AWAY * (port - 2 * beta * speed)
        return [*rates, acceleration, speed, reflected, performance, EFFORT * u, NOISE * n - dynamic_error]


def natural_frequency(task: Task) -> float:
    """√(K_sp(1+kp)/J) of the torque loop [rad/s]."""
    a = task.setting.spec.actuator
    assert isinstance(a, SeriesElasticActuator)
    return math.sqrt(a.spring_stiffness * (1 + a.torque_loop.kp) / a.motor_inertia)
