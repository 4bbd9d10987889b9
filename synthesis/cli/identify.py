"""`robimp identify`: nominal model and W(ω) from measured frequency responses."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError, Location
from .common import Json, bounded_bytes, complain, dumped, say

if TYPE_CHECKING:
    from ..identify import Identified

Files = Annotated[list[Path], typer.Argument(metavar="FRF...", help="Frequency responses (CSV).")]
Of = Annotated[str, typer.Option("--of", metavar="load|actuator", help="θ/τ of a load, or H with the output locked.")]
Amplitude = Annotated[str | None, typer.Option(metavar="LOW:HIGH", help="Amplitudes that count, such as 1:5.")]
Beyond = Annotated[str | None, typer.Option(metavar="hold|LOW:HIGH", help="|Δ| outside of the measured band.")]
Order = Annotated[int, typer.Option(metavar="N", help="Order of the weight W, at most.")]
Poles = Annotated[int, typer.Option(metavar="N", help="Poles of an actuator's H.")]
Zeros = Annotated[int, typer.Option(metavar="N", help="Zeros of an actuator's H.")]
Exclude = Annotated[list[str] | None, typer.Option(metavar="RECORD", help="Leave a record out; * stands for letters.")]
Base = Annotated[Path | None, typer.Option(metavar="SPEC", help="Specification whose other sections are taken over.")]
Spring = Annotated[str | None, typer.Option(metavar="K_SP", help="Stiffness of an actuator's spring, SI.")]
Motion = Annotated[str, typer.Option(metavar="rotary|linear", help="Of the joint, where there is no base.")]
Output = Annotated[Path | None, typer.Option("--output", "-o", metavar="SPEC", help="Write a specification (YAML).")]


def identify(
    files: Files,
    of: Of = "load",
    amplitude: Amplitude = None,
    beyond: Beyond = None,
    order: Order = 2,
    poles: Poles = 4,
    zeros: Zeros = 1,
    exclude: Exclude = None,
    base: Base = None,
    spring: Spring = None,
    motion: Motion = "rotary",
    output: Output = None,
    as_json: Json = False,
) -> None:
    """A nominal model and a weight that covers every measured response, from frequency responses."""
    from ..identify import identify as identified
    from ..identify import read_files
    from ..report.progress import status_line
    from ..storage import demand_replaceable

    for option, value, words in (("--of", of, ("load", "actuator")), ("--motion", motion, ("rotary", "linear"))):
        if value not in words:
            raise InputError(f"expected {' or '.join(words)}; found {value!r}", Location(option))
    if output is not None:
        demand_replaceable(output)
    records = read_files(files)
    with status_line() as progress:
        progress("fitting a nominal model and the weight")
        found = identified(
            records,
            kind="load" if of == "load" else "actuator",
            beyond=_beyond(beyond),
            amplitude=None if amplitude is None else _range("--amplitude", amplitude),
            exclude=exclude or (),
            order=order,
            poles=poles,
            zeros=zeros,
        )
    for name, reason in found.left_out.items():
        complain(f"left out: {name}: {reason}")
    if output is not None:
        _write(found, output, base, None if spring is None else _number("--spring", spring), motion)
    say(dumped(_json(found, output)) if as_json else "\n".join(_lines(found, output)))


def _write(found: Identified, output: Path, base: Path | None, spring: Fraction | None, motion: str) -> None:
    """Write the specification, if it is one. Raises: InputError."""
    import re

    from ..identify import specification
    from ..spec.load import build_spec
    from ..spec.reader import MAX_BYTES, decode, read_tree
    from ..storage import write_atomic

    name = re.sub(r"[^A-Za-z0-9._-]", "-", output.stem).strip(".-_")[:64] or "joint"
    text = None if base is None else decode(bounded_bytes(base, MAX_BYTES), str(base))
    written = specification(found, name=name, base=text, spring=spring, motion=motion)
    build_spec(read_tree(written.encode(), str(output)), output.parent)  # what is written can be read
    write_atomic(output, written.encode())


def _beyond(text: str | None) -> Any:
    if text is None:
        message = "expected this option, for nothing was measured outside of the band; write hold to say that the"
        raise InputError(f"{message} deviations at its ends hold there, or LOW:HIGH for |Δ|", Location("--beyond"))
    return "hold" if text == "hold" else _range("--beyond", text)


def _range(option: str, text: str) -> tuple[Fraction, Fraction]:
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"expected LOW:HIGH, such as 1:5; found {text!r}", Location(option))
    return _number(option, low), _number(option, high)


def _number(option: str, text: str) -> Fraction:
    from ..spec.exact import parse_number

    try:
        value = parse_number(text)
    except ValueError as error:
        raise InputError(f"expected a number; found {text!r}: {error}", Location(option)) from None
    if value < 0:
        raise InputError(f"expected a number ≥ 0; found {text!r}", Location(option))
    return value


def _lines(found: Identified, output: Path | None) -> list[str]:
    from math import pi

    model = ", ".join(f"{key} {value}" for key, value in _model(found).items())
    others = f", {len(found.other_amplitudes)} of other amplitudes" if found.other_amplitudes else ""
    faulty = f"{len(found.left_out)} left out{others}"
    lines = [f"IDENTIFIED  {found.kind} from {len(found.kept)} records; {faulty}"]
    lines += [f"nominal: {model}", f"W: {_polynomials(found.weight)}  covers every record at every ω (exact)"]
    lines.append(f"{'Hz':>9}  {'from the mean':>13}  {'from nominal':>12}  {'|W|':>7}")
    rows = zip(found.omega / 2 / pi, found.spread, found.deviation, found.gain(found.omega), strict=True)
    lines += [f"{hertz:9.4g}  {spread:13.3f}  {value:12.3f}  {gain:7.3f}" for hertz, spread, value, gain in rows]
    return lines if output is None else [*lines, f"specification: {output}"]


def _json(found: Identified, output: Path | None) -> dict[str, Any]:
    return {
        "file": None if output is None else str(output),
        "kind": found.kind,
        "kept": [record.name for record in found.kept],
        "left_out": found.left_out,
        "other_amplitudes": list(found.other_amplitudes),
        "nominal": _model(found),
        "weight": {k: [str(c) for c in getattr(found.weight, k)] for k in ("numerator", "denominator")},
        "beyond": [str(value) for value in found.beyond],
        "omega": found.omega.tolist(),
        "from_mean": list(found.spread),
        "from_nominal": found.deviation.tolist(),
        "covered": found.gain(found.omega).tolist(),
    }


def _model(found: Identified) -> dict[str, Any]:
    from ..identify.nominal import Load

    if isinstance(found.model, Load):
        return {key: float(getattr(found.model.plant, key)) for key in ("inertia", "damping", "stiffness")}
    return {"H": _polynomials(found.model.polynomials), "minimum phase": found.model.minimum_phase}


def _polynomials(value: Any) -> str:
    parts = (value.numerator, value.denominator)
    return " / ".join(f"[{', '.join(f'{float(c):.6g}' for c in part)}]" for part in parts)
