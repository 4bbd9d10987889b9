"""What the examples have in common: rows of (what, ours, published or expected), and recorded certificates."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

from robimp.synthesis import check, load
from robimp.synthesis.spec import canonical

FOLDER = Path(__file__).parent
Row = tuple[str, float, float]


def show(rows: list[Row]) -> None:
    """Print what was compared."""
    width = max(len(what) for what, _, _ in rows)
    print(f"{'':{width}}  {'ours':>9}  expected")
    for what, ours, expected in rows:
        print(f"{what:{width}}  {ours:9.4g}  {expected:.4g}")


def recorded(name: str) -> dict[str, Any]:
    """The recorded certificate of examples/NAME.yaml, re-proven here. Raises: ValueError if it does not hold."""
    path = FOLDER / "certificates" / f"{name}.json"
    verdict = check(path)
    if verdict.exit_code:
        raise ValueError(f"{path}: {verdict.message}")
    certificate: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    if certificate["spec"] != canonical(load(FOLDER / f"{name}.yaml")):
        raise ValueError(f"{path}: of another specification than {name}.yaml; record it again with `robimp synth`")
    return certificate


def omega_B(certificate: dict[str, Any]) -> float:
    """Its proven bandwidth [rad/s]."""
    return float(Fraction(certificate["bandwidth"]["proven"]))


def margin(certificate: dict[str, Any], id: str, form: str) -> float:
    """The proven margin of one claim."""
    return float(Fraction(_claim(certificate, id, form)["margin"]))


def witness(certificate: dict[str, Any], id: str, form: str) -> dict[str, Any]:
    """Where one claim fails at the next level: its frequency [rad/s] and the load."""
    found: dict[str, Any] = _claim(certificate, id, form)["refuted_at"]
    return found


def _claim(certificate: dict[str, Any], id: str, form: str) -> dict[str, Any]:
    claims: list[dict[str, Any]] = certificate["claims"]
    return next(claim for claim in claims if (claim["id"], claim["form"]) == (id, form))
