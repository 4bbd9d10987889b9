"""A result as JSON: the figures a script reads, and what the simulation measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..pipeline import Result


def summary(result: Result) -> dict[str, Any]:
    """Outcome, bandwidth, bound, the force filter's corner where it was free [rad/s], and every claim's status."""
    return {
        "exit_code": int(result.exit_code),
        "outcome": result.outcome.value,
        "omega_B": float(result.omega_B),
        "bound": result.bound.omega_B if result.bound is not None and result.bound.limited else None,
        "seconds": result.seconds,
        "force_filter": None if result.corner is None else float(result.corner.omega),
        "out_of_time": result.late,
        "check": {"seconds": result.check_seconds, "time_limit": result.check_limit},
        "claims": [
            {"id": c.id, "form": c.form, "required": c.required, "status": c.status.value} for c in result.claims
        ],
        "simulation": {
            "trials": len(result.trials.trials),
            "impedance_error": result.agreement.impedance_error,
            "lowest_energy": result.agreement.lowest_energy,
        },
        "sampled": result.sampled.to_json(),
    }


def simulation(result: Result) -> dict[str, Any]:
    """Every trial of the simulation, and the comparison with a sampled controller."""
    return {**result.trials.to_json(), "sampled": result.sampled.to_json()}
