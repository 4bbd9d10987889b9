"""Enclosures hold what they enclose: forms, waves, cells of every part of the axis, and the hold."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import fmpq, fmpq_poly

from robimp.models.rational import RationalFunction
from robimp.models.sampling import Hold
from robimp.models.uncertainty import Table
from robimp.synthesis.certificate.enclosure.cells import Cells, Part, axis
from robimp.synthesis.certificate.enclosure.form import Form
from robimp.synthesis.certificate.enclosure.search import Halving, minimum
from robimp.synthesis.certificate.enclosure.wave import Wave

RNG = np.random.default_rng(7)
HOLD = Hold(fmpq(1, 1000), fmpq(1, 700))


def form(n: int = 40, m: int = 3, away: float = 0.0) -> Form:
    """A random form; with `away` it stays above that."""
    c = RNG.normal(size=(1 + m, n)) * 10.0 ** RNG.uniform(-3, 1, size=(1 + m, n))
    rho = np.abs(RNG.normal(size=n)) * 10.0 ** RNG.uniform(-6, 0, size=n)
    if away:
        c[0] = np.abs(c[1:]).sum(axis=0) + rho + away * 10.0 ** RNG.uniform(-6, 1, size=n)
    return Form(c, rho)


def samples(*forms: Form) -> list[np.ndarray]:
    """Values of forms at common random parameters, corners among them: (100, n) each."""
    m, n = forms[0].c.shape[0] - 1, forms[0].c.shape[1]
    t = RNG.uniform(-1, 1, size=(100, m, n))
    t[:40] = np.sign(t[:40])
    found = []
    for f in forms:
        noise = RNG.choice([-1.0, 1.0, 0.3], size=(100, n))
        found.append(f.c[0] + (f.c[1:] * t).sum(axis=1) + noise * f.rho)
    return [*found, t]


def inside(f: Form, values: np.ndarray, t: np.ndarray) -> None:
    """Every value lies in the form at its own parameters, and between its bounds."""
    rest = np.abs(values - f.c[0] - (f.c[1:] * t).sum(axis=1))
    assert (rest <= f.rho * (1 + 1e-12) + 1e-300).all()
    assert (values >= f.lower).all()
    assert (values <= f.upper).all()


@pytest.mark.parametrize("seed", range(20))
def test_operations_enclose(seed: int) -> None:
    a, b, positive = form(), form(), form(away=1.0)
    x, y, z, t = samples(a, b, positive)
    inside(a + b, x + y, t)
    inside(a - b, x - y, t)
    inside(a * b, x * y, t)
    inside(a * 0.1, x * 0.1, t)
    inside(a + Fraction(1, 3), x + 1 / 3, t)
    inside(positive.sqrt(), np.sqrt(z), t)
    inside(positive.inverse(), 1 / z, t)
    inside((-positive).inverse(), -1 / z, t)


def test_a_form_that_may_vanish_has_no_inverse_and_its_root_starts_at_zero() -> None:
    wide = Form(np.array([[1.0], [2.0]]), np.zeros(1))
    with np.errstate(all="ignore"):
        assert not np.isfinite(wide.inverse().rho).any()
        root = wide.sqrt()
    assert root.lower[0] <= 0 <= np.sqrt(3) <= root.upper[0]


def test_forgetting_the_remainder_would_be_noticed() -> None:
    """Control of the test above: the check sees a ρ that is too small."""
    a, b = form(), form()
    x, y, t = samples(a, b)
    product = a * b
    with pytest.raises(AssertionError):
        inside(Form(product.c, 0.2 * product.rho), x * y, t)


def omega_of(cells: Cells, share: np.ndarray) -> np.ndarray:
    """A frequency of each cell."""
    z = cells.z[0] + (cells.z[1] - cells.z[0]) * (share + 1) / 2
    return 1 / z if cells.part is Part.HIGH else z


def value_of(f: Form | int, cells: Cells, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Range of a form at one point of each cell."""
    if isinstance(f, int):
        return np.zeros(cells.size), np.zeros(cells.size)
    z = cells.z[0] + (cells.z[1] - cells.z[0]) * (share + 1) / 2
    middle = f.c[0] + f.c[1] * share
    low, high = (middle - f.rho) * z**f.order, (middle + f.rho) * z**f.order
    return np.nan_to_num(low, nan=-np.inf), np.nan_to_num(high, nan=np.inf)  # what is not a number says nothing


def holds_at(wave: Wave, cells: Cells, share: np.ndarray, expected: np.ndarray, slack: float = 1e-9) -> None:
    """A complex value at one point of each cell lies in a wave there."""
    omega = omega_of(cells, share)
    for part, value in ((wave.p, expected.real), (wave.q, expected.imag / omega)):
        low, high = value_of(part, cells, share)
        room = slack * (np.abs(value) + np.abs(expected))
        assert (value >= low - room).all()
        assert (value <= high + room).all()


@pytest.mark.parametrize("part", [0, 1, 2])
@pytest.mark.parametrize("share", [-0.9, -0.2, 0.5, 0.99])
def test_waves_hold_rational_functions_and_the_hold(part: int, share: float) -> None:
    cells = axis(0.3, 3000.0, 0, 60, (Fraction(0), None))[part]
    at = np.full(cells.size, share)
    s = 1j * omega_of(cells, at)
    p, q = fmpq_poly([3, 0, 2, 5]), fmpq_poly([1, 4, 7, 1, 2])
    wave = cells.s
    num, den = 3 + 2 * s**2 + 5 * s**3, 1 + 4 * s + 7 * s**2 + s**3 + 2 * s**4
    with np.errstate(all="ignore"):
        holds_at(wave.polynomial(p), cells, at, num)
        holds_at(wave.polynomial(p) / wave.polynomial(q), cells, at, num / den)
        holds_at(1 / wave, cells, at, 1 / s)
        holds_at(cells.hold(HOLD), cells, at, HOLD(s))
        low, high = value_of(abs(wave.polynomial(p) / wave.polynomial(q)), cells, at)
    assert (np.abs(num / den) >= low * (1 - 1e-9)).all()
    assert (np.abs(num / den) <= high * (1 + 1e-9)).all()


@pytest.mark.parametrize("part", [0, 1, 2])
@pytest.mark.parametrize("share", [-0.9, 0.5])
def test_numbers_meet_waves_of_every_order(part: int, share: float) -> None:
    """A number stays a number: also one that comes as a polynomial or a rational function, and with 1/s beside it."""
    cells = axis(0.3, 3000.0, 0, 60, (Fraction(0), None))[part]
    at = np.full(cells.size, share)
    s = 1j * omega_of(cells, at)
    p, third = fmpq_poly([3, 0, 2, 5]), fmpq(1, 3)
    num = 3 + 2 * s**2 + 5 * s**3
    with np.errstate(all="ignore"):
        for wave, value in (
            (cells.s.polynomial(p), num),
            (1 / cells.s, 1 / s),
            (cells.s.polynomial(p) / cells.s, num / s),
        ):
            for number in (third, fmpq_poly([third]), RationalFunction.lift(third)):
                holds_at(wave + number, cells, at, value + 1 / 3)
                holds_at(wave * number, cells, at, value / 3)
                holds_at(wave - number, cells, at, value - 1 / 3)
        assert (wave * fmpq_poly([0])).p == 0 == (wave * 0).q
        holds_at(cells.s.polynomial([0, 0, 5, 0]), cells, at, 5 * s**2)
        with pytest.raises(AssertionError):
            holds_at(wave * third, cells, at, value / 2)


@pytest.mark.parametrize("gap", [0.1, 1e-3])
def test_a_search_encloses_the_least_value_from_both_sides(gap: float) -> None:
    """`z² + 0.1 − a·z + b²·z` on z in [0, 5], a in [1, 2], b in [−1, 1]: −0.9 at a = 2, b = 0, z = 1."""
    start = Cells.whole(Part.MIDDLE, np.array([[0.0], [5.0]]), 2)
    seen: list[int] = []

    def evaluate(cells: Cells) -> list[Form]:
        seen.append(cells.size)
        z, a, b = cells.frequency(), cells.parameter(0, fmpq(1), fmpq(2)), cells.parameter(1, fmpq(-1), fmpq(1))
        return [z * z + Fraction(1, 10) - a * z + b * b * z, z + 1]

    halving = Halving(np.array([True, True]), np.array([3.0, 0.0]))
    found = minimum(evaluate, [start], gap=gap, halving=halving)
    assert found.low <= -0.9 <= found.high and found.high - found.low <= 1.01 * gap
    assert found.at is not None and found.at.form == 0 and abs(found.at.omega - 1) < 2 * gap**0.5
    for floor, proven in ((-0.91, True), (-0.89, False)):
        seen.clear()
        decided = minimum(evaluate, [start], floor=floor, halving=halving)
        assert (decided.low > floor, decided.high < floor) == (proven, not proven)
    seen.clear()
    assert minimum(evaluate, [start], floor=-20.0, halving=halving).low > -20 and len(seen) == 1, (
        "no more than it takes"
    )


def test_the_axis_is_covered_without_a_gap() -> None:
    low, middle, high = axis(0.3, 3000.0, 2, 60, (Fraction(0), None))
    assert low.z[0, 0] == 0
    assert low.z[1, -1] == middle.z[0, 0]
    assert (middle.z[1, :-1] == middle.z[0, 1:]).all()
    assert 1 / high.z[1, -1] <= middle.z[1, -1]
    assert high.z[0, 0] == 0
    for cells in (low, middle, high):
        halves = cells.split_frequency()
        assert halves.z.min() == cells.z.min()
        assert halves.z.max() == cells.z.max()
        assert np.isclose((halves.z[1] - halves.z[0]).sum(), (cells.z[1] - cells.z[0]).sum())


BANDS = [
    (Fraction(2), Fraction(50)),
    (Fraction(0), Fraction(1, 10)),
    (Fraction(1, 1000), Fraction(1, 10)),  # wholly below the joint's own frequencies
    (Fraction(1, 1000), Fraction(50)),
    (Fraction(1, 1000), None),
    (Fraction(7), Fraction(7)),
    (Fraction(2), Fraction(5000)),
    (Fraction(5000), Fraction(6000)),
    (Fraction(5000), None),
]


@pytest.mark.parametrize("band", BANDS)
def test_a_band_is_covered_without_a_gap_and_little_else(band: tuple[Fraction, Fraction | None]) -> None:
    cells = []
    for part in axis(0.3, 3000.0, 0, 30, band):
        with np.errstate(divide="ignore"):
            ends = 1 / part.z[::-1] if part.part is Part.HIGH else part.z
        cells += [(float(a), float(b)) for a, b in ends.T]
    cells.sort()
    assert cells[0][0] <= float(band[0]) <= cells[0][0] * (1 + 1e-12)
    assert cells[-1][1] >= (np.inf if band[1] is None else float(band[1]))
    assert band[1] is None or cells[-1][1] <= float(band[1]) * (1 + 1e-12)
    assert all(a[1] >= b[0] for a, b in pairwise(cells))


def test_a_table_lies_between_its_extremes() -> None:
    table = Table((fmpq(1), fmpq(10), fmpq(20)), (fmpq(1, 10), fmpq(1, 2), fmpq(1, 5)))
    low = RNG.uniform(0, 30, 200)
    high = low + RNG.uniform(0, 15, 200)
    least, most = table.extremes(low, high)
    for share in np.linspace(0, 1, 21):
        value = table(low + share * (high - low))
        assert (value >= least - 1e-15).all()
        assert (value <= most + 1e-15).all()
    assert table(np.array([0.0, 100.0])).tolist() == [0.1, 0.2]
