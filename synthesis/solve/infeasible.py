"""Why nothing can work: what no complex number X satisfies at some frequency, however it is chosen, and what to relax.

Said only with a reason that needs no solver's word: a closed form (`alone`), a search of the whole plane of X that
leaves nothing (`conflict`), or of all gains from 1e-4 to 1e6 where the controller is one (`gain`). Frequencies are
those of a grid; one that is named is a proof that no controller exists, or none with such a gain. What is shown by the
bound's solver alone (`unmet`) is evidence.
"""

from __future__ import annotations

from dataclasses import replace

from ..errors import UndecidedError
from ..problem.setting import Setting
from ..spec.model import Spec
from .alone import alone
from .conflict import conflict, conflicting
from .gain import excluded
from .reason import Impossible, Unmet
from .relaxation import Reached, droppable, smallest_relaxation
from .unmet import attainable, unmet

RELAXED = "the smallest single change that removes it: "
TRIED = "the smallest single change with which a controller was found: "


def impossible(setting: Setting, reached: Reached | None = None) -> Impossible | None:
    """Why no controller can exist, with the relaxation that helps most; None where this test finds no reason.

    reached: ω_B that a search proves for a specification, for advice that was tried; None: nothing is tried.
    """
    reason = first_reason(setting)
    if reason is None:
        return excluded(setting)
    if reason.what == "stability-free":
        return reason
    own = "" if reason.remedy.startswith("relax") else f"{reason.remedy}; "
    return replace(reason, remedy=own + advice(setting.spec, reached))


def unattainable(setting: Setting, reached: Reached | None = None) -> Unmet | None:
    """What no Q̃ in the bound's basis meets, by the solver's word, with what to relax; None: nothing."""
    reason = unmet(setting)
    return None if reason is None else replace(reason, remedy=advice(setting.spec, reached))


def advice(spec: Spec, reached: Reached | None) -> str:
    """The relaxation that helps most, in words."""
    try:
        smallest = smallest_relaxation(spec, _possible, reached or (lambda _: None))
    except UndecidedError:  # no time to try any
        return advice(spec, None)
    if smallest is None:
        key = droppable(spec, _possible)
        return "no single change of a number removes it" + (f"; without {key} it is gone" if key else "")
    if reached is None:
        return f"{RELAXED}{smallest.text}"
    if smallest.omega_B is None:
        return f"{RELAXED}{smallest.text}, but a short search finds no controller with it, nor with somewhat more"
    return f"{TRIED}{smallest.text} (with ω_B near {smallest.omega_B:.2g} rad/s or above)"


def first_reason(setting: Setting) -> Impossible | None:
    """The reason alone."""
    loop = setting.loop
    if loop.nominal.stiffness == 0 and loop.desired.stiffness == 0:
        return Impossible(
            "stability-free",
            0.0,
            "nothing restores the position when K_imp = 0 and K̂ = 0, so free motion keeps a pole at s = 0",
            "ask for a small impedance.stiffness",
        )
    return alone(setting) or conflict(setting)


def _possible(spec: Spec) -> bool:
    try:
        setting = Setting.of(spec)
        return alone(setting) is None and not conflicting(setting) and attainable(setting)
    except (ValueError, ZeroDivisionError):  # a change that leaves no joint
        return False
