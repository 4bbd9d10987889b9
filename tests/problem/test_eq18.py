"""(18), robust stability with actuator dynamics: the family `|D₀ − M| + W|T| < |M|`."""

from __future__ import annotations

import numpy as np
import pytest
from written_out import Joint, disc, only, ordering, random_controller, setting, sides

from robimp.synthesis.problem.constraints.inequality import Role

LARGE = "{weight: {numerator: [2, 10], denominator: [1, 30]}}"  # W from 0.3 to 2
FORMS, COUPLINGS = ("paper", "lumped", "half-plane"), ("frozen", "physical")


def asked(name: str, coupling: str, **more: str):
    return setting(f"{{eq18: {{form: {name}, coupling: {coupling}}}}}", **more)


def loop(w: Joint, coupling: str) -> tuple[np.ndarray, np.ndarray]:
    """T and D₀ of the theory."""
    T = w.A_cl * (w.Omega + w.Q) if coupling == "frozen" else (1 - w.Q) * w.Z_a * w.G_hat + w.H * (w.Omega + w.Q)
    return T, 1 - w.Q + T


def reference(w: Joint, name: str, D0: np.ndarray) -> np.ndarray:
    return {"paper": np.ones_like(D0), "lumped": 1 + w.Omega, "half-plane": D0}[name]


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("name", FORMS)
def test_each_form_is_the_small_gain_test_with_its_reference(rng, omega, name: str, coupling: str) -> None:
    joint = asked(name, coupling)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    T, D0 = loop(w, coupling)
    M = reference(w, name, D0)
    (inequality,) = only(joint, "eq18").inequalities
    for v in (1.0, 0.3):
        got = ordering(*sides(joint, inequality, v, C, omega))
        np.testing.assert_allclose(got, ordering(abs(D0 - M) + v * w.W * abs(T), abs(M)), atol=1e-7)
    other = {"paper": 1 + w.Omega, "lumped": D0, "half-plane": np.ones_like(D0)}[name]
    assert not np.allclose(got, ordering(abs(D0 - other) + 0.3 * w.W * abs(T), abs(other)), atol=1e-3)


def test_frozen_paper_form_is_the_printed_inequality(rng, omega) -> None:
    """`|−Q + A_cl(Ω+Q)| + W|A_cl||Ω+Q| < 1`: the worst case of the printed norm over the disc."""
    joint = asked("paper", "frozen")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    worst = np.abs(w.A_cl * (-w.Q / w.A_cl + (w.Omega + w.Q) * (1 + disc(w.W, 721)))).max(axis=0)
    left, right = sides(joint, only(joint, "eq18").inequalities[0], 1.0, C, omega)
    np.testing.assert_allclose(left / right, worst, rtol=1e-3)
    assert not np.allclose(left / right, abs(-w.Q + w.A_cl * (w.Omega + w.Q)), rtol=1e-2)


def test_frozen_lumped_form_is_eq9_with_the_lumped_weight(rng, omega) -> None:
    """`(|A_cl−1| + W|A_cl|)·|Ω+Q| < |1+Ω|`."""
    joint = asked("lumped", "frozen")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    lumped = abs(w.A_cl - 1) + w.W * abs(w.A_cl)
    left, right = sides(joint, only(joint, "eq18").inequalities[0], 1.0, C, omega)
    np.testing.assert_allclose(left / right, lumped * abs(w.Omega + w.Q) / abs(1 + w.Omega), rtol=1e-7)


@pytest.mark.parametrize("coupling", COUPLINGS)
def test_half_plane_is_exact_over_the_disc(many, coupling: str) -> None:
    """It holds iff no Δ of the disc makes D zero: then the nearest approach of D to 0 is its slack."""
    joint = asked("half-plane", coupling, uncertainty=LARGE)
    verdicts = set()
    for rng, omega in many:
        C = random_controller(joint, rng)
        w = Joint(joint, C, omega)
        T, D0 = loop(w, coupling)
        left, right = sides(joint, only(joint, "eq18").inequalities[0], 1.0, C, omega)
        holds = left < right
        verdicts |= set(holds)
        nearest, slack = np.abs(D0 + disc(w.W, 721) * T).min(axis=0), abs(D0) - w.W * abs(T)
        half_step = np.pi / 720 * w.W * abs(T)  # on the rim, between two samples
        assert np.all(nearest[holds] >= slack[holds] * (1 - 1e-9))
        assert np.all(nearest[holds] <= (slack + half_step)[holds] * (1 + 1e-9))
        Delta = -D0 / T  # the one that makes D zero
        assert np.all((abs(Delta) <= w.W) == ~holds)
    assert verdicts == {True, False}


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("name", ["paper", "lumped"])
def test_other_references_are_sufficient_only(many, name: str, coupling: str) -> None:
    joints = [asked(form, coupling, uncertainty=LARGE) for form in (name, "half-plane")]
    gap = False
    for rng, omega in many:
        C = random_controller(joints[0], rng)
        sufficient, exact = (
            ordering(*sides(joint, only(joint, "eq18").inequalities[0], 1.0, C, omega)) > 0 for joint in joints
        )
        assert np.all(exact[sufficient])
        gap |= bool(np.any(exact & ~sufficient))
    assert gap


def test_physical_coupling_is_the_port_of_every_load(rng, omega) -> None:
    """Up to factors without zeros, `D = 1−Q + (1+Δ)T` is the port `Z` for the load `G = Ĝ(1+Δ)`; frozen, it is not."""
    joint = asked("half-plane", "physical")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    neglected = 0.0
    for g in w.loads(rng, 5):
        Delta = w.g_hat / g - 1
        port = w.Z(g) * (1 + w.L) * (1 - w.Q) / g
        T, _ = loop(w, "physical")
        np.testing.assert_allclose(1 - w.Q + (1 + Delta) * T, port, rtol=1e-7)
        frozen, _ = loop(w, "frozen")
        A_true = w.H * g / (g + w.Z_a)
        coupled = 1 - w.Q + (1 + Delta) * A_true * (w.Omega + w.Q)
        neglected = max(neglected, abs((1 - w.Q + (1 + Delta) * frozen) / coupled - 1).max())
    assert neglected > 1e-4


def test_ideal_actuator_makes_lumped_and_half_plane_eq9(rng, omega) -> None:
    ideal = {"actuator": "{type: ideal}"}
    C = random_controller(asked("lumped", "frozen", **ideal), rng)
    joint = setting("{eq9: {}}", **ideal)
    eq9 = ordering(*sides(joint, only(joint, "eq9").inequalities[0], 1.0, C, omega))
    for name, coupling in (("lumped", "frozen"), ("half-plane", "frozen"), ("half-plane", "physical")):
        joint = asked(name, coupling, **ideal)
        got = ordering(*sides(joint, only(joint, "eq18").inequalities[0], 1.0, C, omega))
        np.testing.assert_allclose(got, eq9, atol=1e-9)
    joint = asked("paper", "frozen", **ideal)
    assert not np.allclose(ordering(*sides(joint, only(joint, "eq18").inequalities[0], 1.0, C, omega)), eq9, atol=1e-3)


def test_printed_form_needs_omega_below_one_where_the_actuator_is_ideal(rng) -> None:
    """Stiffness from nothing: |Ω| → ∞ at ω → 0, and no Q helps."""
    low = np.array([1e-3, 1e-2])
    joint = asked("paper", "frozen")
    w = Joint(joint, random_controller(joint, rng), low)
    assert np.all(abs(w.Omega) > 1)
    left, right = sides(joint, only(joint, "eq18").inequalities[0], 1.0, w.C, low)
    assert np.all(left > right)
    half_plane = asked("half-plane", "frozen")
    left, right = sides(half_plane, only(half_plane, "eq18").inequalities[0], 1.0, w.C, low)
    assert np.all(left < right)


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("name", FORMS)
def test_what_it_says_it_is(name: str, coupling: str) -> None:
    constraint = only(asked(name, coupling), "eq18")
    assert constraint.form == f"{name}/{coupling}"
    assert ("A_cl at the nominal load" in constraint.statement) is (coupling == "frozen")
    assert (constraint.level, constraint.role, constraint.strict) == (1, Role.RADIUS, True)
    assert constraint.inequalities[0].convex is (name != "half-plane")
