"""Second-order sections as a drive computes them: as SciPy filters, and as one would by hand, to the bit."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import bilinear, butter, sosfilt, tf2sos

from robimp.synthesis import load
from robimp.synthesis.errors import InputError
from robimp.synthesis.simulation import loads
from robimp.synthesis.simulation.batch.law import sampled_law
from robimp.synthesis.simulation.batch.run import simulate_batch
from robimp.synthesis.simulation.batch.shipped import ShippedLaw
from robimp.synthesis.simulation.batch.switched import switched
from robimp.synthesis.simulation.sections import run
from robimp.synthesis.spec.model import Filters

SOS = butter(5, 0.07, output="sos")
NOISE = np.random.default_rng(0).standard_normal(2000)


def by_hand(sos: np.ndarray, x: np.ndarray, number: type) -> np.ndarray:
    """The recursion with NumPy's scalars, which round each operation and fuse none."""
    state = [[number(0), number(0)] for _ in sos]
    out = []
    for sample in x:
        value = number(sample)
        for (b0, b1, b2, _, a1, a2), z in zip(sos.astype(number), state, strict=True):
            y = b0 * value + z[0]
            z[0] = (b1 * value - a1 * y) + z[1]
            z[1] = b2 * value - a2 * y
            value = y
        out.append(value)
    return np.array(out)


@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_to_the_bit_what_each_operation_rounded_gives(number: type) -> None:
    out = run(SOS, NOISE, number)
    assert out.dtype == number
    assert (out == by_hand(SOS, NOISE, number)).all()


def test_as_scipy_filters() -> None:
    np.testing.assert_allclose(run(SOS, NOISE), sosfilt(SOS, NOISE), rtol=0, atol=1e-14)


def test_single_precision_differs_from_double_by_its_rounding() -> None:
    difference = abs(run(SOS, NOISE, np.float32) - run(SOS, NOISE)).max()
    assert 1e-9 < difference < 1e-5


@pytest.mark.parametrize(
    ("sos", "dtype", "says"),
    [
        (SOS * 2, np.float64, "fourth"),
        (SOS[:, :5], np.float64, "rows b0"),
        (SOS[0], np.float64, "rows b0"),
        (SOS, np.float16, "float16"),
    ],
)
def test_refused(sos: np.ndarray, dtype: type, says: str) -> None:
    with pytest.raises(InputError, match=says):
        run(sos, NOISE, dtype)


SPEC = load(Path(__file__).parents[2] / "examples" / "haninger2016-paper.yaml")
C = ((Fraction(2000),), (Fraction(1), Fraction("70.75"), Fraction(500)))
T = 1e-3
PUSH = np.sin(2 * np.pi * np.arange(1500) * T)


def with_filters(**corners: int) -> object:
    controller = SPEC.controller.model_copy(update={"filters": Filters(**{k: Fraction(v) for k, v in corners.items()})})
    return SPEC.model_copy(update={"controller": controller})


def low_pass(corner: float) -> np.ndarray:
    return tf2sos(*bilinear([1.0], [1 / corner, 1.0], 1 / T))


def shipped(delay: int = 0, arithmetic: str = "float64", **filters: float) -> ShippedLaw:
    """(20) as `sampled_law` has it, by sections: backward differences, Tustin's rule."""
    wish, plant = SPEC.impedance, SPEC.plant

    def differences(inertia: float, damping: float, stiffness: float) -> list[float]:
        I, B, K = inertia / T**2, damping / T, stiffness  # noqa: E741
        return [I + B + K, -2 * I - B, I]

    gap = [float(getattr(plant, k) - getattr(wish, k)) for k in ("inertia", "damping", "stiffness")]
    imp = [float(getattr(wish, k)) for k in ("inertia", "damping", "stiffness")]
    sos = tf2sos(*bilinear([float(c) for c in C[0]], [float(c) for c in C[1]], 1 / T))
    taps = [[1, 0, 0], differences(*imp), differences(*gap)]
    given = {name: low_pass(corner) for name, corner in filters.items()}
    return ShippedLaw.of(taps, sos, T, delay=delay, arithmetic=arithmetic, **given)


class TestShippedLaw:
    """Sections within the loop."""

    @pytest.mark.parametrize("delay", [0, 2])
    @pytest.mark.parametrize(
        "filters", [{}, {"force": 300, "position": 200, "derivative": 1000}], ids=["plain", "filters"]
    )
    def test_moves_the_joint_as_the_same_law_in_matrices(self, filters: dict[str, int], delay: int) -> None:
        joint = switched(SPEC, None, loads(SPEC)[:1])
        theta = [
            simulate_batch(joint, T, PUSH, law=law, every=1).trace("theta")
            for law in (sampled_law(with_filters(**filters), C, rate=1000, delay=delay), shipped(delay, **filters))
        ]
        np.testing.assert_allclose(theta[1], theta[0], rtol=0, atol=1e-9 * abs(theta[0]).max())

    @pytest.mark.parametrize("arithmetic", ["float64", "float32"])
    def test_computes_its_filters_to_the_bit_as_run_does(self, arithmetic: str) -> None:
        law = ShippedLaw.of([[1, 0, 0], [0, 0, 0], [0, 0, 0]], SOS, T, arithmetic=arithmetic)
        run_ = simulate_batch(switched(SPEC, None, loads(SPEC)[:1]), T, NOISE, law=law, every=1)
        assert (run_.trace("tau_d") == run(SOS, run_.trace("tau_int"), arithmetic)).all()

    def test_single_precision_is_near_double_and_not_the_same(self) -> None:
        joint = switched(SPEC, None, loads(SPEC)[:1])
        theta = [
            simulate_batch(joint, T, PUSH, law=shipped(arithmetic=kind), every=1).trace("theta")
            for kind in ("float64", "float32")
        ]
        assert 1e-12 < abs(theta[0] - theta[1]).max() < 1e-3
