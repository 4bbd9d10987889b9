"""Every claim under attack in the time domain: inside nothing may give, just outside something must."""

from ..simulation.adversary.population import Reality
from ..simulation.batch.switched import Imperfections
from .attack import IDEAL, Challenge, challenge

__all__ = ["IDEAL", "Challenge", "Imperfections", "Reality", "challenge"]
