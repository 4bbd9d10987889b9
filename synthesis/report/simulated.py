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
        return {**found, "findings": [], "drawn": 0}
    findings = [finding.to_json() for finding in done.attacked.findings]
    return {**found, "findings": findings, "drawn": len(done.attacked.drawn.loads)}


def arrays(done: Replay) -> bytes:
    """NPZ: of the joints drawn their loads (n, 3), member of the ranges, energies [J], largest angle [rad], growth."""
    import numpy as np

    drawn = done.attacked.drawn if done.attacked else None
    columns = {} if drawn is None else {key: value for key, value in vars(drawn).items() if np.ndim(value)}
    stream = BytesIO()
    np.savez_compressed(stream, **columns)
    return stream.getvalue()
