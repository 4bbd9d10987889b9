"""From a specification to a proven controller. Names load when first used, so a check never imports a solver.

from robimp.synthesis import load, synthesize, check, simulate

Each function does what the command of its name does; `help(...)` shows an example that runs.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .api import bound, init, judge, load, parse, schema, simulate, synthesize
    from .check import Verdict
    from .check import check_file as check
    from .errors import ExitCode, InfeasibleError, InputError, MismatchError, RefutedError, RobimpError, UndecidedError
    from .export import Exported, export
    from .identify import from_responses as identify
    from .pipeline import Result
    from .report import write as report
    from .spec.model import Polynomials, Spec
    from .sweep.result import Map
    from .sweep.run import map_plane

__all__ = [
    "ExitCode",
    "Exported",
    "InfeasibleError",
    "InputError",
    "Map",
    "MismatchError",
    "Polynomials",
    "RefutedError",
    "Result",
    "RobimpError",
    "Spec",
    "UndecidedError",
    "Verdict",
    "bound",
    "check",
    "export",
    "identify",
    "init",
    "judge",
    "load",
    "map_plane",
    "parse",
    "report",
    "schema",
    "simulate",
    "synthesize",
]

_HOME = {
    "Exported": ".export",
    "Map": ".sweep.result",
    "Polynomials": ".spec.model",
    "Result": ".pipeline",
    "Spec": ".spec.model",
    "Verdict": ".check",
    "map_plane": ".sweep.run",
    **dict.fromkeys(("bound", "init", "judge", "load", "parse", "schema", "simulate", "synthesize"), ".api"),
}
_CALLABLE = ("check", "export", "identify", "report")  # packages that are their own main function


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name in _CALLABLE:
        return import_module(f".{name}", __name__)
    return getattr(import_module(_HOME.get(name, ".errors"), __name__), name)
