"""Every claim under attack in the time domain: inside nothing may give, just outside something must."""

from .attack import Challenge, challenge

__all__ = ["Challenge", "challenge"]
