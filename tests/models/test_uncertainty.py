"""Boxes of loads, the radius W(ω) of Δ = Ĝ⁻¹/G⁻¹ − 1 over them, and the disc of Δ/(1+Δ)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pytest

from robimp.models.impedance import DynamicStiffness, LoadBox
from robimp.models.rational import RationalFunction, exact, to_float
from robimp.models.uncertainty import Uncertainty

Box = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]

FREE: Box = ((0.02, 0.04), (0.12, 0.28), (0, 0))  # K = 0: the paper's joint
SOFT: Box = ((0.02, 0.04), (0.12, 0.28), (1, 3))  # K > 0, damped
RESONANT: Box = ((0.02, 0.04), (0.01, 0.05), (1, 3))  # K > 0 and a resonance between 5 and 12 rad/s: W beyond 1
OMEGA = np.geomspace(0.05, 500, 40)


def uncertainty(box: Box, weight: RationalFunction | None = None) -> Uncertainty:
    intervals = [(exact(str(lo)), exact(str(hi))) for lo, hi in box]
    middle = DynamicStiffness(*((lo + hi) / 2 for lo, hi in intervals))
    return Uncertainty(middle, LoadBox(*intervals), weight)


def at(parameters: Sequence[float], omega: np.ndarray | float) -> np.ndarray:
    """G⁻¹(jω)."""
    inertia, damping, stiffness = parameters
    return np.asarray(stiffness - inertia * omega**2 + 1j * damping * omega)


def stiffness(load: DynamicStiffness, omega: np.ndarray) -> np.ndarray:
    return at([to_float(x) for x in (load.inertia, load.damping, load.stiffness)], omega)


def brute_force(u: Uncertainty, box: Box, omega: np.ndarray, points: int) -> np.ndarray:
    """Largest |Δ| over a dense grid of loads."""
    nominal, worst = stiffness(u.nominal, omega), np.zeros_like(omega)
    for load in itertools.product(*(np.linspace(lo, hi, points if hi > lo else 1) for lo, hi in box)):
        worst = np.maximum(worst, np.abs(nominal / at(load, omega) - 1))
    return worst


def corners_only(u: Uncertainty, omega: np.ndarray) -> np.ndarray:
    return np.max([np.abs(stiffness(u.nominal, omega) / stiffness(c, omega) - 1) for c in u.corners()], axis=0)


@pytest.mark.parametrize("box", [FREE, SOFT, RESONANT], ids=["free", "soft", "resonant"])
def test_box_radius_is_the_maximum_over_every_load(box: Box) -> None:
    u = uncertainty(box)
    radius, brute = u.box_radius(OMEGA), brute_force(u, box, OMEGA, 31)
    assert np.all(radius >= brute * (1 - 1e-12))
    np.testing.assert_allclose(radius, brute, rtol=2e-2)  # the grid of loads is what is coarse


def test_box_radius_is_attained_by_a_load_of_the_box() -> None:
    """Not merely a bound: refined around the best load, brute force reaches it."""
    u, omega = uncertainty(RESONANT), np.array([8.0])
    on_the_edge = (0.04, 0.01, np.linspace(1, 3, 400001))  # of least damping; K sweeps through the resonance
    g = at(on_the_edge, omega)  # type: ignore[arg-type]
    attained = np.abs(stiffness(u.nominal, omega) / g - 1).max()
    assert u.box_radius(omega)[0] == pytest.approx(attained, rel=1e-6)


def test_with_a_resonance_in_the_box_corners_alone_miss_the_maximum() -> None:
    u = uncertainty(RESONANT)
    inside = (OMEGA > 5.2) & (OMEGA < 12)
    exact_radius, at_corners = u.box_radius(OMEGA), corners_only(u, OMEGA)
    assert exact_radius.max() > 1
    assert np.any(exact_radius[inside] > 1.5 * at_corners[inside])
    assert np.all(brute_force(u, RESONANT, OMEGA[inside], 31).max() > at_corners[inside].max())


def test_without_stiffness_corners_decide() -> None:
    u = uncertainty(FREE)
    np.testing.assert_array_equal(u.box_radius(OMEGA), corners_only(u, OMEGA))
    assert u.segments() == tuple((c, c) for c in u.corners())


def test_an_undamped_resonance_makes_the_radius_infinite_but_no_crash() -> None:
    u = uncertainty(((0.02, 0.04), (0, 0.2), (1, 3)))
    radius = u.box_radius(np.array([0.5, 8.0, 100.0]))
    assert np.isinf(radius[1])
    assert np.isfinite(radius[[0, 2]]).all()


def test_without_a_box_there_is_nothing_to_cover() -> None:
    nominal = DynamicStiffness.of(1, 2, 3)
    u = Uncertainty(nominal)
    assert u.corners() == (nominal,)
    assert u.segments() == ((nominal, nominal),)
    np.testing.assert_array_equal(u.radius(OMEGA), np.zeros_like(OMEGA))


def test_the_nominal_load_lies_in_its_box() -> None:
    u = uncertainty(SOFT)
    with pytest.raises(ValueError, match="does not contain the nominal"):
        Uncertainty(DynamicStiffness.of("0.0401", "0.2", 2), u.box)
    assert u.box is not None
    assert all(u.box.contains(c) for c in u.corners())


# ---- the rectangle of G⁻¹


@pytest.mark.parametrize("omega", [0.3, 8.0, 90.0])
def test_four_corners_span_what_eight_vertices_span(omega: float) -> None:
    """In the plane of G⁻¹ the box is a rectangle; four of its vertices are inside it or on its edges."""
    box = uncertainty(RESONANT)
    w = np.array([omega])
    corners = np.array([stiffness(c, w)[0] for c in box.corners()])
    vertices = np.array([at(load, omega) for load in itertools.product(*RESONANT)])
    for part in (np.real, np.imag):
        assert part(corners).min() == pytest.approx(part(vertices).min())
        assert part(corners).max() == pytest.approx(part(vertices).max())
    assert len(corners) == 4


def test_intervals_of_one_point_give_each_corner_once() -> None:
    assert len(uncertainty(((1, 2), (3, 3), (0, 0))).corners()) == 2
    assert len(uncertainty(((1, 1), (3, 3), (2, 2))).corners()) == 1


# ---- the lemma behind `segments`


def lemma_holds(u: Uncertainty, box: Box, omega: float, threshold: float, segments: tuple) -> tuple[bool, bool]:
    """Whether `|ĝ−g| < θ|g|` holds on the segments, and on a dense set of the box."""
    w = np.array([omega])
    ts = np.linspace(0, 1, 201)
    on_segments = np.concatenate([(1 - ts) * stiffness(a, w) + ts * stiffness(b, w) for a, b in segments])
    loads = itertools.product(*(np.linspace(lo, hi, 21 if hi > lo else 1) for lo, hi in box))
    everywhere = np.array([at(load, omega) for load in loads])
    nominal = stiffness(u.nominal, w)[0]

    def holds(g: np.ndarray) -> bool:
        return bool(np.all(np.abs(nominal - g) < threshold * np.abs(g)))

    return holds(on_segments), holds(everywhere)


CASES = list(itertools.product((FREE, SOFT, RESONANT), (0.5, 6.0, 8.0, 11.0, 60.0), (0.3, 1, 1.2, 3, 9)))


def test_segments_decide_every_threshold() -> None:
    """Where the segments pass, the whole box does: below, at and above θ = 1."""
    seen = set()
    for box, omega, threshold in CASES:
        u = uncertainty(box)
        on_segments, everywhere = lemma_holds(u, box, omega, threshold, u.segments())
        assert everywhere or not on_segments, (box, omega, threshold)
        seen.add((on_segments, everywhere))
    assert {(True, True), (False, False)} <= seen


def test_without_the_edge_the_lemma_would_be_false() -> None:
    u = uncertainty(RESONANT)
    points = tuple((c, c) for c in u.corners())
    verdicts = [lemma_holds(u, RESONANT, omega, t, points) for omega in (6.0, 8.0, 11.0) for t in (1.2, 3, 9)]
    assert (True, False) in verdicts


# ---- weights


def test_weight_and_box_combine_as_the_largest_product() -> None:
    """`1+Δ = (1+Δ_box)(1+Δ_w)`: the moduli add, and their product too; brute force over phases reaches it."""
    weight = RationalFunction.of(["0.3", 1], ["0.1", 5])
    u = uncertainty(SOFT, weight)
    box, w = u.box_radius(OMEGA), np.abs(weight.at(OMEGA))
    phases = np.exp(1j * np.linspace(0, 2 * np.pi, 61))
    products = (1 + box * phases[:, None, None]) * (1 + w * phases[None, :, None]) - 1
    brute = np.abs(products).max(axis=(0, 1))
    assert np.all(u.radius(OMEGA) >= brute * (1 - 1e-12))
    np.testing.assert_allclose(u.radius(OMEGA), brute, rtol=1e-2)
    assert np.all(brute > np.maximum(box, w))
    np.testing.assert_allclose(Uncertainty(u.nominal, None, weight).radius(OMEGA), w)


# ---- Δ/(1+Δ)


def test_delta_over_one_plus_delta_is_affine_in_the_load() -> None:
    """`Δ/(1+Δ) = 1 − Ĝ G⁻¹`, exactly."""
    u = uncertainty(SOFT)
    for load in u.corners():
        Delta = u.nominal.rational / load.rational - 1
        assert Delta / (1 + Delta) == 1 - load.rational / u.nominal.rational
