"""What a word that is not known at its place was probably meant to be."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from functools import cache
from typing import Any, get_args

from .model import Section, Spec

SYMBOLS = {  # of the paper, to the keys that hold them
    "I": "inertia", "m": "inertia", "mass": "inertia", "B": "damping", "K": "stiffness", "J": "motor_inertia",
    "b_m": "motor_damping", "K_sp": "spring_stiffness", "C_t": "torque_loop", "Q": "coefficients",
}  # fmt: skip


def suggestion(text: str, choices: Iterable[str], section: str | None = None) -> str:
    """`did you mean …?`, where the word belongs, or the choices. section: dotted key of where it stands; None: a word.

    A key that is known in sections below this one belongs there.
    """
    known = tuple(choices)
    near = [SYMBOLS[text]] if SYMBOLS.get(text) in known else get_close_matches(text[:80], known, n=1)
    if near:
        return f"did you mean `{near[0]}`?"
    homes = [] if section is None else _places().get(text, [])
    below = [home for home in homes if not section or home.startswith(f"{section}.")]
    home = f"it belongs into {' or '.join(f'`{home}`' for home in below or homes)}" if homes else ""
    if below:
        return home
    expected = f"expected one of {', '.join(known)}" if known else "this section has no keys; write {}"
    return f"{expected}; {home}" if home else expected


@cache
def _places() -> dict[str, list[str]]:
    """Every key of a specification to the sections that have it."""
    found: dict[str, list[str]] = {}
    for section, key in _keys(Spec, ""):
        if section and section not in found.setdefault(key, []):
            found[key].append(section)
    return found


def _keys(annotation: Any, section: str) -> Iterator[tuple[str, str]]:
    for part in (annotation, *get_args(annotation)):
        if isinstance(part, type) and issubclass(part, Section):
            for key, field in part.model_fields.items():
                yield section, key
                yield from _keys(field.annotation, f"{section}.{key}".lstrip("."))
