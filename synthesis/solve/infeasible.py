"""Why nothing can work: what no complex number X satisfies at some frequency, however it is chosen, and what to relax.

Said only with a reason that needs no solver's word: a closed form (`alone`), a search of the whole plane of X that
leaves nothing (`conflict`), or of all gains from 1e-4 to 1e6 where the controller is one (`gain`). Frequencies are
those of a grid; one that is named is a proof that no controller exists, or none with such a gain.
"""

from __future__ import annotations

from dataclasses import replace

from ..problem.setting import Setting
from ..spec.model import Spec
from .alone import alone
from .conflict import conflict, conflicting
from .gain import excluded
from .reason import Impossible
from .relaxation import droppable, smallest_relaxation

RELAXED = "the smallest single change that removes it: "


def impossible(setting: Setting) -> Impossible | None:
    """Why no controller can exist, with the relaxation that helps most; None where this test finds no reason."""
    reason = first_reason(setting)
    if reason is None:
        return excluded(setting)
    if reason.what == "stability-free":
        return reason
    smallest = smallest_relaxation(setting.spec, _possible)
    if smallest is not None:
        remedy = f"{RELAXED}{smallest.text}"
    else:
        key = droppable(setting.spec, _possible)
        remedy = "no single change of a number removes it" + (f"; without {key} it is gone" if key else "")
    own = "" if reason.remedy.startswith("relax") else f"{reason.remedy}; "
    return replace(reason, remedy=own + remedy)


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
        return alone(setting) is None and not conflicting(setting)
    except (ValueError, ZeroDivisionError):  # a change that leaves no joint
        return False
