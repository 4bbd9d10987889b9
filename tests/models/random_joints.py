"""Random joints: exact numbers, as the models have them and as values for the symbols of the equations of motion."""

from __future__ import annotations

import random
from dataclasses import dataclass

import sympy as sp
from elimination import (
    B,
    C,
    C_t,
    F,
    F_d,
    F_theta,
    G_imp,
    H,
    I,
    J,
    K,
    K_sp,
    Z_a,
    b_m,
    expression,
    feedforward,
    g_hat,
)

from robimp.models.actuator import SeriesElastic
from robimp.models.closed_loop import ImpedanceLoop
from robimp.models.controller import Compensator, Filters, low_pass
from robimp.models.impedance import DynamicStiffness
from robimp.models.rational import RationalFunction, exact, polynomial


@dataclass(frozen=True)
class Joint:
    """A joint with random numbers and filters."""

    loop: ImpedanceLoop
    actuator: SeriesElastic
    load: DynamicStiffness
    C: Compensator

    @property
    def values(self) -> dict[sp.Symbol, sp.Expr]:
        def number(q: object) -> sp.Rational:
            return sp.Rational(str(q))

        filters, a = self.loop.filters, self.actuator
        return {
            I: number(self.load.inertia),
            B: number(self.load.damping),
            K: number(self.load.stiffness),
            J: number(a.J),
            b_m: number(a.b_m),
            K_sp: number(a.K_sp),
            feedforward: number(a.feedforward),
            C_t: expression(a.C_t),
            C: expression(self.C.rational),
            F: expression(filters.force),
            F_theta: expression(filters.force if filters.position is None else filters.position),
            F_d: expression(filters.derivative),
            g_hat: expression(self.loop.nominal.rational),
            G_imp: expression(self.loop.desired.rational),
            H: expression(self.loop.actuator.H),
            Z_a: expression(self.loop.actuator.Z_a),
        }


class Draw:
    """Random exact numbers and models."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)

    def number(self) -> object:
        return exact(f"{self.rng.randint(1, 99)}/{self.rng.randint(1, 20)}")

    def stiffness(self) -> DynamicStiffness:
        return DynamicStiffness(self.number(), self.number(), self.number())  # type: ignore[arg-type]

    def function(self, order: int, *, proper: int = 1) -> RationalFunction:
        """Random, of given order, with `proper` more poles than zeros."""
        return RationalFunction.of(
            [self.number() for _ in range(order + 1 - proper)], [self.number() for _ in range(order + 1)]
        )

    def compensator(self) -> Compensator:
        return Compensator(polynomial([self.number(), self.number()]), polynomial([self.number() for _ in range(3)]))

    def series_elastic(self) -> SeriesElastic:
        return SeriesElastic(  # type: ignore[arg-type]
            self.number(), self.number(), self.number(), self.function(1, proper=0), self.number()
        )

    def filters(self, kind: str) -> Filters:
        if kind == "none":
            return Filters()
        position = {"shared": None, "separate": low_pass(self.number()), "unfiltered": RationalFunction.of([1])}[kind]  # type: ignore[arg-type]
        return Filters(low_pass(self.number()), position, low_pass(self.number()))  # type: ignore[arg-type]

    def joint(self, filters: str = "none") -> Joint:
        actuator = self.series_elastic()
        loop = ImpedanceLoop(actuator.two_port, self.stiffness(), self.stiffness(), self.filters(filters))
        return Joint(loop, actuator, self.stiffness(), self.compensator())
