"""The joint that a specification describes, with or without a hold between torque demand and actuator."""

from __future__ import annotations

from ..spec.model import Spec
from .equations import Compensator, Load
from .excitation import default_frequencies
from .held import HeldJoint, Lags, held_poles, pair
from .joint import Joint, Poles, free_equations, poles_of, wall_equations


def assemble(spec: Spec, compensator: Compensator, load: Load) -> Joint:
    """The joint that `spec` describes, carrying `load`, under the controller with compensator C.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    lags = lags_of(spec)
    if lags is None:
        return Joint(load, free_equations(spec, compensator, load))
    return HeldJoint(load, free_equations(spec, compensator, load, command="held"), lags)


def poles_against_wall(spec: Spec, compensator: Compensator) -> Poles:
    """Poles with θ locked: a rigid wall answers the actuator, `τ_int = −τ_sea`.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    lags = lags_of(spec)
    if lags is None:
        return poles_of(wall_equations(spec, compensator))
    return held_poles(pair(wall_equations(spec, compensator, command="held"), lags))


def lags_of(spec: Spec) -> Lags | None:
    """Hold and delay of a specification, in steps fine enough for its own frequencies; None: continuous."""
    return None if spec.sampling is None else Lags.of(spec.sampling, float(default_frequencies(spec).max()))
