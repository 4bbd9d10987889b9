"""One file per constraint, each stating its equation once. To add one: its file, its test, its line here."""

from __future__ import annotations

from ..setting import Setting
from .attenuation import bandwidth, peak
from .eq9 import eq9
from .eq12 import eq12
from .eq18 import eq18
from .friction import friction
from .inequality import Constraint
from .noise import noise
from .rendering import rendering

REGISTRY = (eq9, eq12, eq18, bandwidth, rendering, peak, noise, friction)


def constraints(setting: Setting, only: str | None = None) -> tuple[Constraint, ...]:
    """Every condition a specification asks for or wants reported; `only`: those of one id, its builder's name."""
    wanted = [build for build in REGISTRY if only in (None, build.__name__)]
    return tuple(constraint for build in wanted for constraint in build(setting))
