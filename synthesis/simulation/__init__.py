"""The time domain: physics of (1) and (13), integrated; shares no formula with the certificate."""

from .assembly import assemble, poles_against_wall
from .equations import Compensator, Load, loads
from .excitation import Excitation, default_frequencies, multisine, step
from .joint import Joint, Poles
from .measure import MeasuredImpedance, measure_impedance
from .members import Drive, Member, members, middle_of
from .response import Response, multisine_response, simulate, step_response
from .sampled import SampledComparison, sampled_comparison, sampled_step
from .trial import Trial, Trials, Wall
from .trials import verify

__all__ = [
    "Compensator",
    "Drive",
    "Excitation",
    "Joint",
    "Load",
    "MeasuredImpedance",
    "Member",
    "Poles",
    "Response",
    "SampledComparison",
    "Trial",
    "Trials",
    "Wall",
    "assemble",
    "default_frequencies",
    "loads",
    "measure_impedance",
    "members",
    "middle_of",
    "multisine",
    "multisine_response",
    "poles_against_wall",
    "sampled_comparison",
    "sampled_step",
    "simulate",
    "step",
    "step_response",
    "verify",
]
