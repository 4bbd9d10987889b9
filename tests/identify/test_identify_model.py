"""The nominal model: the one behind the data where there is one, and an output impedance that follows from physics."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from identify_data import HERTZ, TRUTH, compliance, record

from robimp.models.actuator import SeriesElastic, torque_loop
from robimp.models.rational import RationalFunction, descending, exact
from robimp.synthesis.errors import InputError
from robimp.synthesis.identify import identify
from robimp.synthesis.identify.nominal import Load, Transfer, fit_load, fit_transfer, output_impedance
from robimp.synthesis.spec.model import Polynomials
from robimp.synthesis.spec.record import Record

OMEGA = 2 * np.pi * np.array(HERTZ)


def sweep(load: tuple[float, float, float], name: str = "r") -> Record:
    return record([compliance(load, f) for f in HERTZ], name, omega=list(OMEGA))


def test_the_load_behind_the_data_is_found() -> None:
    plant = fit_load([sweep(TRUTH)]).plant
    assert [float(v) for v in (plant.inertia, plant.damping, plant.stiffness)] == list(TRUTH)


def test_of_several_loads_one_in_the_middle() -> None:
    loads = [(0.05 * a, 0.3 * b, 2.0 * c) for a, b, c in ((0.9, 1.2, 1), (1.1, 0.8, 1), (1, 1, 1.1), (1, 1, 0.9))]
    found = identify([sweep(load, str(k)) for k, load in enumerate(loads)], kind="load", beyond="hold")
    assert isinstance(found.model, Load)
    plant = found.model.plant
    for value, truth in zip((plant.inertia, plant.damping, plant.stiffness), TRUTH, strict=True):
        assert abs(float(value) / truth - 1) < 0.05
    middle = (float(plant.inertia), float(plant.damping), float(plant.stiffness))
    for load in loads:
        delta = np.array([compliance(load, f) / compliance(middle, f) - 1 for f in HERTZ])
        assert (abs(delta) <= found.gain(OMEGA)).all()
    assert (found.deviation <= found.gain(OMEGA)).all() and found.deviation.max() < 0.5


def test_responses_of_something_else_show_no_inertia() -> None:
    with pytest.raises(InputError, match="no inertia fits the responses"):
        fit_load([record([1 / (2 + 0.3j * w) for w in OMEGA], omega=list(OMEGA))])


@pytest.mark.parametrize(
    ("numerator", "denominator"),
    [([900], [1, 12, 900]), ([-100, 9000], [1, 60, 9000]), ([5], [1, 5]), ([4e5], [1, 160, 7600, 4e5])],
)
def test_the_transfer_behind_the_data_is_found(numerator: list[float], denominator: list[float]) -> None:
    H = np.polyval(numerator, 1j * OMEGA) / np.polyval(denominator, 1j * OMEGA)
    found = fit_transfer([record(H, omega=list(OMEGA))], len(denominator) - 1, len(numerator) - 1)
    assert [float(c) for c in found.polynomials.denominator] == pytest.approx(denominator, rel=2e-3)
    assert [float(c) for c in found.polynomials.numerator] == pytest.approx(numerator, rel=2e-3)
    assert found.minimum_phase == (numerator[0] > 0)


def test_a_fitted_transfer_is_stable_whatever_the_data() -> None:
    random = np.random.default_rng(3)
    for order in (1, 2, 3, 4):
        H = random.normal(size=len(OMEGA)) + 1j * random.normal(size=len(OMEGA))
        found = fit_transfer([record(H, omega=list(OMEGA))], order, 0)
        assert (np.roots([float(c) for c in found.polynomials.denominator]).real < 0).all()


def test_the_exact_inverse_of_a_transfer() -> None:
    model = Transfer(
        Polynomials(numerator=(Fraction(2), Fraction(3)), denominator=(Fraction(1), Fraction(4), Fraction(5)))
    )
    re, im = model.inverse(Fraction(7))
    s = 7j
    assert complex(re, im) == pytest.approx((s**2 + 4 * s + 5) / (2 * s + 3), rel=1e-14)
    with pytest.raises(InputError, match="vanishes at 1 rad/s"):
        Transfer(Polynomials(numerator=(Fraction(1), Fraction(0), Fraction(1)), denominator=(Fraction(1),))).inverse(
            Fraction(1)
        )


@pytest.mark.parametrize(("kp", "kd", "feedforward"), [(3, 0, "0.7"), (0, 0, "0.9"), (10, "0.25", 1)])
def test_the_output_impedance_behind_a_spring(kp: int, kd: object, feedforward: object) -> None:
    """With a proportional torque loop, or with feedforward 1, Z_a follows from H: the two-port of the physics."""
    C_t = torque_loop(kp, Fraction(str(kd)), 1000)
    port = SeriesElastic(exact("0.01"), exact("0.05"), exact("4.8"), C_t, exact(Fraction(str(feedforward)))).two_port
    H = Polynomials(numerator=descending(port.H.num), denominator=descending(port.H.den))
    Z_a = output_impedance(H, Fraction("4.8"))
    assert RationalFunction.of(Z_a.numerator, Z_a.denominator) == port.Z_a


def test_it_does_not_where_neither_holds() -> None:
    port = SeriesElastic(
        exact("0.01"), exact("0.05"), exact("4.8"), torque_loop(10, "0.25", 1000), exact("0.5")
    ).two_port
    H = Polynomials(numerator=descending(port.H.num), denominator=descending(port.H.den))
    Z_a = output_impedance(H, Fraction("4.8"))
    assert RationalFunction.of(Z_a.numerator, Z_a.denominator) != port.Z_a


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"order": 7}, "order of the weight from 0 to 6"),
        ({"order": -1}, "order of the weight"),
        ({"poles": 0}, "poles"),
        ({"poles": 2, "zeros": 2}, "fewer zeros than poles"),
        ({"beyond": (Fraction(0), Fraction(1))}, "beyond: expected at least the"),
    ],
)
def test_what_cannot_be_is_refused(options: dict[str, object], says: str) -> None:
    records = [sweep(TRUTH), sweep((0.06, 0.4, 2.5), "other")]
    with pytest.raises(InputError, match=says):
        identify(records, **{"kind": "load", "beyond": "hold", **options})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="at least one record"):
        identify([], kind="load", beyond="hold")
    with pytest.raises(InputError, match="no usable record is left"):
        identify([record([1, 1], coherence=[0, 0])], kind="load", beyond="hold")
