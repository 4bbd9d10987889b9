"""What was identified as a specification: YAML in which every number says where it came from."""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction
from math import pi

from ..errors import InputError, Location
from ..spec.model import Polynomials
from ..spec.reader import read_tree
from ..spec.tree import Mapping
from .identified import Identified
from .nominal import Load, Transfer, output_impedance

_COLUMN = 30  # where comments begin

_WISHES = """\
actuator:
  type: ideal                 # NOT MEASURED: write your actuator here

impedance:                    # what the port should feel like: a WISH, yours to change
  inertia: nominal
  damping: {damping}
  stiffness: {stiffness}

controller: {{type: dob, order: 2}}                # CHOOSE
objective: {{maximize: bandwidth, attenuation: 0.5}}  # CHOOSE
constraints:                  # CHOOSE what must be proven
  eq9: {{}}
  eq18: {{form: half-plane, coupling: physical}}
  peak: 2
"""


def specification(
    found: Identified, *, name: str, base: str | None = None, spring: Fraction | None = None, motion: str = "rotary"
) -> str:
    """The YAML text of a specification with what was identified.

    Args:
        found: a load, which becomes `plant` and `uncertainty`, or an actuator, which becomes `actuator`.
        name: of the specification, where there is no base.
        base: text of a specification whose other sections are taken over as they stand; needed for an actuator.
        spring: stiffness behind an actuator's H, from which its output impedance follows.
        motion: rotary or linear, where there is no base.

    Raises:
        InputError: something that was not measured is missing.
    """
    head = "\n".join(f"# {line}" for line in _head(found))
    if isinstance(found.model, Load):
        sections = {"plant": _plant(found.model, motion), "uncertainty": _uncertainty(found)}
    else:
        sections = {"actuator": _actuator(found, found.model, spring)}
    if base is not None:
        return f"{head}\n{_merged(base, sections)}"
    if not isinstance(found.model, Load):
        raise InputError("the output was locked, so the load is not known; give a specification as base (--base)")
    plant = found.model.plant
    wishes = _WISHES.format(damping=_text(plant.damping * 2), stiffness=_text(plant.stiffness * 2))
    begin = f"robimp: 1\nname: {name}\nmotion: {motion}\n"
    return "\n".join([head, begin, *sections.values(), wishes])


def _head(found: Identified) -> list[str]:
    low, high = (float(found.bounds[k][0]) / 2 / pi for k in (0, -1))
    what = "θ/τ_int of the load" if found.kind == "load" else "H of the actuator, output locked"
    range_ = "" if found.amplitude is None else f", amplitudes {' to '.join(map(_text, found.amplitude))}"
    lines = [f"Identified from {len(found.kept)} measured responses, {what}: {low:.4g} to {high:.4g} Hz{range_}"]
    lines += [f"  kept: {_printable(record.name)}" for record in found.kept]
    lines += [f"  left out: {_printable(name)}: {reason}" for name, reason in found.left_out.items()]
    count = len(found.other_amplitudes)
    return [*lines, f"  left out: {count} of other amplitudes"] if count else lines


def _printable(name: str) -> str:
    """A name that cannot end the comment it stands in."""
    return "".join(sign if sign.isprintable() else "?" for sign in name)


def _plant(load: Load, motion: str) -> str:
    plant, turns = load.plant, motion == "rotary"
    units = ("kg·m²", "N·m·s/rad", "N·m/rad") if turns else ("kg", "N·s/m", "N/m")
    values = (("inertia", plant.inertia), ("damping", plant.damping), ("stiffness", plant.stiffness))
    rows = [_row("plant:", "fitted to all kept responses: least squares of |G/Ĝ − 1|")]
    rows += [_row(f"  {key}: {_text(value)}", unit) for (key, value), unit in zip(values, units, strict=True)]
    return "\n".join(rows) + "\n"


def _uncertainty(found: Identified) -> str:
    return "\n".join(["uncertainty:", *_weight(found, "  "), *_stated(found, "  # ")]) + "\n"


def _weight(found: Identified, indent: str) -> list[str]:
    numerator, denominator = (f"[{', '.join(map(_text, part))}]" for part in _parts(found.weight))
    note = "|Δ(jω)| ≤ |W(jω)| at every ω: fitted, rounded, then proven exactly"
    return [
        _row(f"{indent}weight:", note),
        f"{indent}  numerator: {numerator}",
        f"{indent}  denominator: {denominator}",
    ]


def _stated(found: Identified, indent: str) -> list[str]:
    """What W covers, in words."""
    k = int(found.deviation.argmax())
    where = f"{found.omega[k] / 2 / pi:.4g} Hz"
    low, high = (_text(value) for value in found.beyond)
    return [
        f"{indent}W covers every kept record: at its samples, and between two of them the larger of both",
        f"{indent}below and above the measured band: |Δ| ≤ {low} and |Δ| ≤ {high}, as stated",
        f"{indent}largest deviation: {found.deviation[k]:.4g} at {where}; from the records' mean {found.spread[k]:.4g}",
    ]


def _actuator(found: Identified, model: Transfer, spring: Fraction | None) -> str:
    if spring is None:
        message = "a locked output shows H, not what the actuator leaves at a moving port; give the spring's stiffness"
        raise InputError(f"{message} (--spring), behind a proportional torque loop or with feedforward 1")
    H, Z_a = model.polynomials, output_impedance(model.polynomials, spring)
    rows = ["actuator:", "  type: two-port"]
    rows.append(_row("  transfer:", "H, fitted to all kept responses"))
    if not model.minimum_phase:
        rows.append("    # with a zero on the right: delay, which limits what any controller reaches")
    rows += _polynomials(H)
    rows.append(_row("  impedance:", f"Z_a = K_sp·(1 − H/H(0)), K_sp = {_text(spring)}, by hand"))
    rows += _polynomials(Z_a)
    rows.append("  # NOT COVERED by any claim: the deviation of H from this, |H/Ĥ − 1| ≤ |W|, with")
    rows += _weight(found, "  #   ")
    return "\n".join([*rows, *_stated(found, "  # ")]) + "\n"


def _polynomials(value: Polynomials) -> list[str]:
    numerator, denominator = (f"[{', '.join(map(_text, part))}]" for part in _parts(value))
    return [f"    numerator: {numerator}", f"    denominator: {denominator}"]


def _parts(value: Polynomials) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    return value.numerator, value.denominator


def _merged(base: str, sections: dict[str, str]) -> str:
    """The base with some of its sections replaced; all other lines, comments included, stay."""
    root = read_tree(base.encode(), "base")
    lines = base.splitlines()
    if not isinstance(root, Mapping) or any(place.column != 1 for place, _ in root.entries.values()):
        raise InputError("expected sections that begin at the left margin, each in a line of its own", Location("base"))
    _demand_no_loss(root, sections)
    starts = sorted((place.line or 1) - 1 for place, _ in root.entries.values())
    for key, text in sorted(sections.items(), key=lambda item: _line(root, item[0], len(lines)), reverse=True):
        first = _line(root, key, len(lines))
        last = next((start for start in starts if start > first), len(lines))
        while last > first and (not lines[last - 1].strip() or lines[last - 1].startswith("#")):
            last -= 1
        lines[first:last] = text.rstrip().splitlines()
    return "\n".join(lines) + "\n"


def _line(root: Mapping, key: str, end: int) -> int:
    return (root.entries[key][0].line or 1) - 1 if key in root.entries else end


def _demand_no_loss(root: Mapping, sections: dict[str, str]) -> None:
    """An uncertain actuator in the base was not measured here: it must not vanish with the uncertain load."""
    if "uncertainty" not in sections or "uncertainty" not in root.entries:
        return
    old = root.entries["uncertainty"][1]
    if isinstance(old, Mapping) and "actuator" in old.entries:
        message = "would be lost, for the section is replaced; take it out of the base, and add it to what is written"
        raise InputError(message, Location("base", old.entries["actuator"][0].line, key="uncertainty.actuator"))


def _row(text: str, comment: str) -> str:
    return f"{text:<{_COLUMN}}# {comment}"


def _text(value: Fraction) -> str:
    """A finite decimal in full."""
    exact = Context(prec=200).divide(Decimal(value.numerator), Decimal(value.denominator))
    if Fraction(exact) != value:
        return str(value)
    return f"{exact:f}" if -7 < exact.adjusted() < 9 else f"{exact:e}"
