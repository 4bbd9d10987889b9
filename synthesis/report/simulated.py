"""A replay as files: every trial and finding as JSON, every joint drawn as arrays."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..replay import Replay


def summary(done: Replay) -> dict[str, Any]:
    """Trials, findings and how many joints were drawn."""
    found: dict[str, Any] = done.trials.to_json()
    if done.attacked is None:
        return {**found, "findings": [], "reached": [], "drawn": 0}
    findings = [finding.to_json() for finding in done.attacked.findings]
    reached = [each.to_json() for each in done.attacked.reached]
    return {**found, "findings": findings, "reached": reached, "drawn": len(done.attacked.drawn.loads)}


def table(done: Replay) -> str:
    """Every proven bound beside the worst that was simulated, for the terminal."""
    rows = [("claim", "proven", "simulated", "share")]
    for each in done.attacked.reached if done.attacked else ():
        share = "—" if each.share is None else f"{each.share:.2%}"
        rows.append((each.claim, f"{each.proven:.6g}", f"{each.simulated:.6g}", share))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def arrays(done: Replay) -> bytes:
    """NPZ: of the joints drawn their loads (n, 3), member of the ranges, energies [J], largest angle [rad], growth.

    The same with `real_` before its name for what was asked for beyond the certificate.
    """
    import numpy as np

    sets = {} if done.attacked is None else {"": done.attacked.drawn, "real_": done.attacked.real}
    columns = {
        prefix + key: value for prefix, found in sets.items() if found is not None
        for key, value in vars(found).items() if np.ndim(value)
    }  # fmt: skip
    stream = BytesIO()
    np.savez_compressed(stream, **columns)
    return stream.getvalue()
