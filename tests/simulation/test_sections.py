"""Second-order sections as a drive computes them: as SciPy filters, and as one would by hand, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from robimp.synthesis.errors import InputError
from robimp.synthesis.simulation.sections import run

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
