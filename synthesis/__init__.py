"""From a specification to a proven controller. Names load when first used, so a check never imports a solver.

from robimp.synthesis import load, synthesize, check, simulate
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .check import check_file as check
    from .errors import ExitCode, InfeasibleError, InputError, MismatchError, RefutedError, RobimpError, UndecidedError
    from .pipeline import Result, synthesize
    from .simulation import verify as simulate
    from .solve.bound import bound
    from .spec import load_spec as load
    from .spec import parse_spec as parse
    from .spec.model import Spec
    from .sweep.result import Map
    from .sweep.run import map_plane
else:
    from . import check  # a package that can be called

__all__ = [
    "ExitCode",
    "InfeasibleError",
    "InputError",
    "Map",
    "MismatchError",
    "RefutedError",
    "Result",
    "RobimpError",
    "Spec",
    "UndecidedError",
    "bound",
    "check",
    "load",
    "map_plane",
    "parse",
    "simulate",
    "synthesize",
]

_HOME = {
    "bound": (".solve.bound", "bound"),
    "load": (".spec", "load_spec"),
    "map_plane": (".sweep.run", "map_plane"),
    "parse": (".spec", "parse_spec"),
    "simulate": (".simulation", "verify"),
    "synthesize": (".pipeline", "synthesize"),
    "Map": (".sweep.result", "Map"),
    "Result": (".pipeline", "Result"),
    "Spec": (".spec.model", "Spec"),
}


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOME.get(name, (".errors", name))
    return getattr(import_module(module, __name__), attribute)
