"""What an experiment gives: curves to draw, and observations beside the paper's findings."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...spec.model import Filters, SeriesElasticActuator, Spec
from ..equations import Compensator, Load, loads

Array = NDArray[np.float64]

FRICTION = 0.05  # N·m, Coulomb, on the load: the paper calls its own "rather large" and prints no figure
STICTION = 1.2
SPRING = Fraction(24, 5)  # N·m/rad [published]
FEEDBACK: Compensator = ((Fraction(5, 2),), (Fraction(1),))  # C_imp = 2.5 of (20), published
NONE: Compensator = ((Fraction(0),), (Fraction(1),))  # (2): no feedback of τ_int


@dataclass(frozen=True)
class Observation:
    """A finding of the paper, the figure measured here, and whether it comes out the same."""

    finding: str
    measured: str
    reproduced: bool

    def __str__(self) -> str:
        return f"{'reproduced' if self.reproduced else 'NOT reproduced'}: {self.finding} ({self.measured})"


@dataclass(frozen=True, eq=False)
class Curve:
    """One line of the figure: abscissa and ordinate, (n,) each, in the units of the experiment's axes."""

    name: str
    x: Array
    y: Array


@dataclass(frozen=True, eq=False)
class Experiment:
    """Title, axes, curves and observations of one figure."""

    title: str
    axes: tuple[str, str]
    curves: tuple[Curve, ...]
    observations: tuple[Observation, ...]
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain values; curves as lists."""
        curves = [{"name": curve.name, "x": curve.x.tolist(), "y": curve.y.tolist()} for curve in self.curves]
        seen = [asdict(each) for each in self.observations]
        return {"title": self.title, "axes": self.axes, "observations": seen, "notes": self.notes, "curves": curves}


def rivals(spec: Spec, C: Compensator) -> dict[str, tuple[Spec, Compensator]]:
    """The three controllers the paper compares, on the same joint: (2), (20) with its filters, and the one given."""
    filters = Filters(force=Fraction(100), position="none", derivative=Fraction(1000))
    feedback = spec.model_copy(update={"controller": spec.controller.model_copy(update={"filters": filters})})
    return {"traditional (2)": (spec, NONE), "dynamic feedback (20)": (feedback, FEEDBACK), given(spec): (spec, C)}


def given(spec: Spec) -> str:
    """What the controller that is tried is called."""
    return "DOB (10)" if spec.controller.type == "dob" else "C_imp given (20)"


def demand_papers_joint(spec: Spec) -> None:
    """The paper's stiffnesses, torques and friction are those of its own joint: a rotary one behind its spring.

    Raises: InputError for another.
    """
    actuator = spec.actuator
    spring = actuator.spring_stiffness if isinstance(actuator, SeriesElasticActuator) else None
    if spec.motion != "rotary" or spring != SPRING:
        raise InputError(
            f"{spec.name}: the paper's experiments are those of its own joint, rotary behind a spring of "
            f"{float(SPRING):g} N·m/rad: its stiffnesses, torques and friction mean nothing on this one"
        )


def notes(spec: Spec, *, wishes: bool) -> tuple[str, ...]:
    """What was moved, beside what a certificate speaks of; `wishes`: with the paper's impedances, not its own."""
    sampled = spec.sampling is not None
    impedances = "the paper's impedances" if wishes else "the certificate's impedance"
    return (
        f"{impedances}; Coulomb friction {FRICTION:g} N·m on the load",
        *(["the controller is moved as a continuous one, though the certificate's is sampled"] if sampled else []),
    )


def wishing(spec: Spec, stiffness: Fraction, damping: Fraction) -> Spec:
    """The same joint asked for another impedance."""
    wish = spec.impedance.model_copy(update={"stiffness": stiffness, "damping": damping})
    return spec.model_copy(update={"impedance": wish})


def true_load(spec: Spec) -> Load:
    """The load that is there: the corner of the box with most inertia and least damping, for no model is exact."""
    return max(loads(spec), key=lambda load: (load.inertia, -load.damping))
