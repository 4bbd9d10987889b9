"""Claims are sandwiches: true at the margin, false at the twin's level, where its witness says."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest
from certificate_equations import Loop, number, slack
from certificate_joints import PAPER_Q, SERIES_ELASTIC, random_case, rational, reference, spec, subject
from mpmath import mpf, workdps

from robimp.models.controller import Compensator
from robimp.models.rational import exact, fraction
from robimp.synthesis.certificate.claim import Claim, Refutation
from robimp.synthesis.certificate.claims import certify, counterexamples
from robimp.synthesis.certificate.hurwitz import is_hurwitz
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.certificate.prover import Prover, Subject
from robimp.synthesis.certificate.stability import IDEAL, prove_stability
from robimp.synthesis.certificate.witness import Witness
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec.model import Polynomials, Spec

PROVEN, REFUTED, UNDECIDED = Outcome.PROVEN, Outcome.REFUTED, Outcome.UNDECIDED
STABILITY = ("hurwitz", "box")  # about roots, not about one frequency
SEEDS = range(30)
NEAR_ZERO, NEAR_INFINITY = Fraction(1, 10**40), Fraction(10**40)


@cache
def random_claims(seed: int) -> tuple[Spec, Polynomials, tuple[Claim, ...]]:
    asked, coefficients = random_case(seed)
    return asked, coefficients, certify(*subject(asked, coefficients))


def named(claims: tuple[Claim, ...], id: str, form: str | None = None) -> Claim:
    return next(c for c in claims if c.id == id and form in (None, c.form))


def violation(asked: Spec, coefficients: Polynomials, claim: Claim) -> mpf:
    """Slack of a claim's statement at its twin's level and witness, a limit at 0 or ∞ taken very close to it."""
    twin = claim.refuted_at
    assert twin is not None and twin.witness is not None
    omega = {0: NEAR_ZERO, None: NEAR_INFINITY}.get(twin.witness.omega, twin.witness.omega)
    load = twin.witness.load
    true = None if load is None else tuple(fraction(p) for p in (load.inertia, load.damping, load.stiffness))
    with workdps(400):
        loop = Loop(asked, coefficients, number(omega), true)
        return slack(loop, claim.id, claim.form, number(twin.value), number(asked.objective.attenuation))


@pytest.mark.parametrize("seed", SEEDS)
def test_every_witness_violates_the_equation_itself(seed):
    asked, coefficients, claims = random_claims(seed)
    for claim in claims:
        if claim.form not in STABILITY and claim.refuted_at is not None:
            at_limit = claim.refuted_at.witness.omega in (0, None)
            found = violation(asked, coefficients, claim)
            assert found < (mpf(10) ** -20 if at_limit else 0), (claim.id, claim.form)


@pytest.mark.parametrize("seed", SEEDS)
def test_proven_levels_hold_at_many_frequencies(seed):
    """The other half of the sandwich, at the nominal load and the box's corners."""
    asked, coefficients, claims = random_claims(seed)
    box = asked.uncertainty.box
    loads = [None]
    if box is not None:
        loads += [(i, b, k) for i in box.inertia for b in box.damping for k in box.stiffness]
    for claim in claims:
        if claim.form in STABILITY or claim.status is not PROVEN:
            continue
        low, high = (float(claim.interval[0]), claim.interval[1])
        top = 1e5 if high is None else float(high)
        for k in range(25):
            omega = mpf(max(low, 1e-3 * top)) * (top / max(low, 1e-3 * top)) ** (mpf(k) / 25)
            for load in loads:
                loop = Loop(asked, coefficients, omega, load)
                value = slack(loop, claim.id, claim.form, number(claim.margin), number(asked.objective.attenuation))
                assert value > -1e-9 * abs(loop.m), (claim.id, claim.form, float(omega))


@pytest.mark.parametrize("seed", SEEDS)
def test_sandwiches_are_tight(seed):
    _, _, claims = random_claims(seed)
    for claim in claims:
        if claim.status is PROVEN and claim.refuted_at is not None and claim.id != "bandwidth":
            margin, beyond = float(claim.margin), float(claim.refuted_at.value)
            harder = -1 if claim.id in ("peak", "rendering") else 1
            assert harder * (beyond - margin) > 0
            assert abs(beyond - margin) <= max(0.01 * abs(beyond), 1e-6), (claim.id, claim.form)


def test_the_random_joints_are_not_all_alike():
    """Controls the tests above: both outcomes, limits at 0 and loads occur among their claims."""
    claims = [claim for seed in SEEDS for claim in random_claims(seed)[2]]
    twins = [c.refuted_at.witness for c in claims if c.refuted_at is not None and c.refuted_at.witness is not None]
    for id in ("eq9", "eq12", "eq18", "peak", "friction"):
        assert {c.status for c in claims if c.id == id} >= {PROVEN, REFUTED}
    assert any(c.form == "hurwitz" and c.status is REFUTED for c in claims)
    assert any(w.omega == 0 for w in twins)
    assert any(w.load is not None for w in twins)


# The paper's controllers ---------------------------------------------------------------------------------------------


def test_the_papers_q_is_proven_with_its_bandwidth():
    claims = certify(*reference())
    assert {c.status for c in claims if c.required} == {PROVEN}
    band = named(claims, "bandwidth")
    assert Fraction("8.87") <= band.margin < band.refuted_at.value <= Fraction("8.88")
    assert float(named(claims, "eq12", "structured").margin) == pytest.approx(0.10, abs=0.005)
    assert counterexamples(*reference(), omega_B=8.8) == ()


def test_the_papers_q_is_not_passive_at_the_stiffer_impedance():
    impedance = {"inertia": "0.03", "damping": "0.25", "stiffness": "3"}
    claim = named(certify(*reference(impedance=impedance)), "eq12", "structured")
    assert claim.status is REFUTED
    assert abs(claim.refuted_at.witness.omega - Fraction("51.3")) < 1
    assert violation(spec(impedance=impedance), rational(*PAPER_Q), claim) < 0
    found = counterexamples(*reference(impedance=impedance), omega_B=8.0)
    assert any(c.id == "eq12" and abs(c.omega - 51.3) < 1 for c in found)


@pytest.mark.parametrize("position", ["none", None, "100"])
def test_the_papers_feedback_gain_has_verified_refutations(position):
    asked = spec(
        controller={"type": "dynamic-feedback", "filters": {"force": "100", "position": position, "derivative": "1000"}}
    )
    gain = rational(["2.5"], ["1"])
    claims = certify(*subject(asked, gain))
    assert UNDECIDED not in {c.status for c in claims if c.required}
    refuted = [c for c in claims if c.status is REFUTED and c.form != "hurwitz"]
    assert refuted  # 1 − Q̃ = 1/3.5 at best: friction or passivity fails somewhere
    for claim in refuted:
        assert violation(asked, gain, claim) <= 0


# Limits --------------------------------------------------------------------------------------------------------------


def half_damping(**more: object) -> Spec:
    box = {"inertia": ("0.024", "0.036"), "damping": ("0.1", "0.3"), "stiffness": ("0", "0")}
    return spec(uncertainty={"box": box}, **more)


def test_a_radius_of_one_at_frequency_zero_makes_eq9_an_equality():
    """With K̂ = 0 and half the damping, W(0) = 1 exactly while |Ω+Q| = |1+Ω|."""
    claim = named(certify(*subject(half_damping(), rational(*PAPER_Q))), "eq9")
    assert (claim.status, claim.refuted_at.witness.omega) == (REFUTED, 0)
    less = {"inertia": ("0.024", "0.036"), "damping": ("0.1001", "0.3"), "stiffness": ("0", "0")}
    assert named(certify(*reference(uncertainty={"box": less})), "eq9").status is PROVEN


def test_a_radius_of_one_at_frequency_zero_has_no_disc():
    """The exact disc needs W < 1 strictly, although its inequality is not strict."""
    constraints_ = {"eq12": {"form": "disc", "band": ("0", "1"), "margin": "0"}}
    claim = named(certify(*subject(half_damping(constraints=constraints_), rational(*PAPER_Q))), "eq12", "disc")
    assert (claim.status, claim.refuted_at.witness.omega) == (REFUTED, 0)


@pytest.mark.parametrize(
    ("inertia", "stiffness", "omega"), [("0.03", "0.1", 0), ("0.001", "1.5", None), ("0.03", "1.5", "none")]
)
@pytest.mark.parametrize("form", ["structured", "disc"])
def test_port_that_is_negative_in_the_limit_is_refuted_there(form, inertia, stiffness, omega):
    """`C = 0`: Z = G_imp + G⁻¹ − Ĝ⁻¹, a negative spring or mass for some loads; Re(Z/jω) does not see it."""
    box = {"inertia": ("0.024", "0.036"), "damping": ("0.2", "0.2"), "stiffness": ("0", "2")}
    asked = spec(
        actuator={"type": "ideal"},
        plant={"stiffness": "1"},
        impedance={"inertia": inertia, "stiffness": stiffness},
        uncertainty={"box": box},
        controller={"type": "dynamic-feedback"},
        constraints={"eq12": {"form": form, "margin": "0"}},
    )
    claim = named(certify(*subject(asked, rational(["0"], ["1"]))), "eq12", form)
    if form == "disc":  # W ≥ 1 here: refuted whatever the limit
        assert claim.status is REFUTED
    else:
        assert claim.status is (PROVEN if omega == "none" else REFUTED)
        assert omega == "none" or claim.refuted_at.witness.omega == omega


def test_an_exact_model_has_radius_zero():
    asked = spec(uncertainty={"box": None, "weight": None}, constraints={"eq12": {"form": "disc", "margin": "0"}})
    claims = certify(*subject(asked, rational(*PAPER_Q)))
    assert named(claims, "eq9").status is named(claims, "eq12", "disc").status is PROVEN


def test_unbounded_radius_is_refuted_without_a_crash():
    """W ≥ 1 inside the band: no level of the disc claim is finite."""
    asked = spec(
        uncertainty={"box": None, "weight": rational(["3", "0"], ["1", "10"]).model_dump()},
        constraints={"eq9": None, "eq12": {"form": "disc", "band": ("0", "100"), "margin": "0"}},
    )
    claim = named(certify(*subject(asked, rational(*PAPER_Q))), "eq12", "disc")
    assert claim.status is REFUTED
    assert violation(asked, rational(*PAPER_Q), claim) < 0


def test_bandwidth_is_the_attenuations_own_when_no_band_meets_the_rendering_error():
    box = {"inertia": ("0.024", "0.036"), "damping": ("0.12", "0.28"), "stiffness": ("0", "1")}
    asked = spec(objective={"rendering_error": "0.01"}, uncertainty={"box": box})
    claims = certify(*subject(asked, rational(*PAPER_Q)))
    band, rendering = named(claims, "bandwidth"), named(claims, "rendering")
    assert float(band.margin) == pytest.approx(8.875, abs=0.01)
    assert rendering.status is REFUTED
    assert violation(asked, rational(*PAPER_Q), rendering) < 0
    limited = certify(*subject(spec(objective={"rendering_error": "0.6"}), rational(*PAPER_Q)))
    assert named(limited, "rendering").status is PROVEN
    assert violation(spec(), rational(*PAPER_Q), named(limited, "bandwidth")) < 0  # its twin speaks of the attenuation


def test_no_attenuation_at_all_is_refuted_at_frequency_zero():
    asked = spec(objective={"attenuation": "0.1"})  # 1 − Q(0) = 0.2
    band = named(certify(*subject(asked, rational(*PAPER_Q))), "bandwidth")
    assert (band.status, band.margin, band.refuted_at.witness.omega) == (REFUTED, None, 0)
    touching = named(certify(*subject(spec(objective={"attenuation": "0.2"}), rational(*PAPER_Q))), "bandwidth")
    assert touching.status is UNDECIDED  # it holds at ω = 0 alone: no band, and no frequency that refutes one


# Metamorphic ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", ["1/2", "2", "3"])
def test_margin_of_k_times_the_weight_is_the_margin_over_k(k):
    def margins(scale: Fraction) -> dict[str, float]:
        weight = {"numerator": (scale * Fraction("0.3"), scale), "denominator": (Fraction(1), Fraction(40))}
        asked = spec(uncertainty={"box": None, "weight": weight}, constraints={"eq12": None})
        return {c.id: float(c.margin or 0) for c in certify(*subject(asked, rational(*PAPER_Q)))}

    small, plain = margins(Fraction(1, 10) * Fraction(k)), margins(Fraction(1, 10))
    for id in ("eq9", "eq18"):
        assert small[id] == pytest.approx(plain[id] / float(Fraction(k)), rel=1e-4)
        assert small[id] > 1


def test_margin_scales_with_box_and_weight_together():
    """v multiplies the whole radius W_b + W_w + W_b W_w once, not each of its parts."""
    asked = spec(
        uncertainty={"weight": rational(["0.05", "0.5"], ["1", "60"]).model_dump()}, constraints={"eq12": None}
    )
    setting, C = subject(asked, rational(*PAPER_Q))
    claim = named(certify(setting, C), "eq9")
    assert claim.status is PROVEN
    assert abs(claim.refuted_at.value - claim.margin) < claim.margin / 100
    assert violation(asked, rational(*PAPER_Q), claim) <= 0


@pytest.mark.parametrize("actuator", [SERIES_ELASTIC, {"type": "ideal"}])
def test_a_bigger_box_never_turns_false_into_true(actuator):
    verdicts: dict[tuple[str, str], list[float]] = {}
    for percent in (5, 25, 40, 55, 70, 90):
        spread = Fraction(percent, 100)
        box = {
            name: (v * (1 - spread), v * (1 + spread))
            for name, v in (("inertia", Fraction("0.03")), ("damping", Fraction("0.2")), ("stiffness", Fraction("0.1")))
        }
        asked = spec(actuator=actuator, plant={"stiffness": "0.1"}, uncertainty={"box": box})
        for claim in certify(*subject(asked, rational(*PAPER_Q))):
            if claim.id in ("eq9", "eq18") or claim.form == "structured":
                level = float(claim.margin) if claim.status is PROVEN else float("-inf")
                verdicts.setdefault((claim.id, claim.form), []).append(level)
    for levels in verdicts.values():
        assert all(a >= b - 1e-5 * abs(a) or a == b for a, b in itertools.pairwise(levels)), levels
    assert any(levels[-1] == float("-inf") < levels[0] for levels in verdicts.values())


def faster(asked: Spec, coefficients: Polynomials, a: Fraction) -> tuple[Spec, Polynomials]:
    """The same joint with time running a times faster: s → s/a in every dynamic stiffness, filter and controller."""

    def stiffness(section: object) -> object:
        return section.model_copy(update={"inertia": section.inertia / a**2, "damping": section.damping / a})

    def coefficients_of(p: Polynomials) -> Polynomials:
        parts = ((p.numerator, len(p.numerator)), (p.denominator, len(p.denominator)))
        scaled = [[c / a ** (n - 1 - k) for k, c in enumerate(part)] for part, n in parts]
        return rational(*scaled)

    def interval(pair: tuple[Fraction, Fraction] | None, factor: Fraction) -> tuple[Fraction, Fraction] | None:
        return None if pair is None else (pair[0] * factor, pair[1] * factor)

    box, weight, m = asked.uncertainty.box, asked.uncertainty.weight, asked.actuator
    if box is not None:
        box = box.model_copy(
            update={"inertia": interval(box.inertia, 1 / a**2), "damping": interval(box.damping, 1 / a)}
        )
    if m.type == "series-elastic":
        loop = m.torque_loop.model_copy(
            update={"kd": m.torque_loop.kd / a, "derivative_corner": m.torque_loop.derivative_corner * a}
        )
        m = m.model_copy(
            update={"motor_inertia": m.motor_inertia / a**2, "motor_damping": m.motor_damping / a, "torque_loop": loop}
        )
    filters = {name: c * a if isinstance(c, Fraction) else c for name, c in asked.controller.filters}
    eq12 = asked.constraints.eq12
    if eq12 is not None:
        eq12 = eq12.model_copy(update={"band": interval(eq12.band, a), "margin": eq12.margin / a})
    return asked.model_copy(
        update={
            "plant": stiffness(asked.plant),
            "impedance": stiffness(asked.impedance),
            "uncertainty": asked.uncertainty.model_copy(
                update={"box": box, "weight": None if weight is None else coefficients_of(weight)}
            ),
            "actuator": m,
            "controller": asked.controller.model_copy(
                update={"filters": asked.controller.filters.model_copy(update=filters)}
            ),
            "constraints": asked.constraints.model_copy(update={"eq12": eq12}),
        }
    ), coefficients_of(coefficients)


@pytest.mark.parametrize("seed", [1, 2, 3, 5, 8, 13])
@pytest.mark.parametrize("a", [Fraction(7), Fraction(1, 100)])
def test_time_scaling_leaves_every_required_verdict(seed, a):
    asked, coefficients, claims = random_claims(seed)
    scaled = certify(*subject(*faster(asked, coefficients, a)))
    for before, after in zip(claims, scaled, strict=True):
        assert (before.id, before.form) == (after.id, after.form)
        if before.required:
            assert after.status is before.status, before.id
        if before.margin is not None and after.margin is not None and before.form != "paper":
            dimension = {"stability-free": a, "stability-locked": a, "bandwidth": a, "friction": 1 / a}.get(
                before.id, 1
            )
            dimension = 1 / a if before.form in ("structured", "disc") else 1 if before.form == "box" else dimension
            if before.id != "bandwidth" or before.refuted_at is not None:
                assert float(after.margin) == pytest.approx(
                    float(before.margin * dimension), rel=0.02, abs=1e-5 * float(dimension)
                )


def with_factor(numerator: tuple[str, ...], denominator: tuple[str, ...], zero: int) -> Polynomials:
    """Numerator and denominator of Q multiplied by (s + zero)."""

    def times(p: tuple[str, ...]) -> list[Fraction]:
        c = [Fraction(x) for x in p]
        return [a + zero * b for a, b in zip([*c, Fraction(0)], [Fraction(0), *c], strict=True)]

    return rational(times(numerator), times(denominator))


def test_a_stable_common_factor_changes_nothing_and_an_unstable_one_is_seen_by_stability():
    plain, stable, unstable = (
        certify(*subject(spec(), p)) for p in (rational(*PAPER_Q), with_factor(*PAPER_Q, 5), with_factor(*PAPER_Q, -5))
    )
    for before, same, hidden in zip(plain, stable, unstable, strict=True):
        assert same.status is before.status
        if before.form in STABILITY or (before.id, before.form) in IDEAL:
            assert hidden.status is REFUTED
        else:
            assert hidden.status is before.status
            assert (same.margin, hidden.margin) == (before.margin, before.margin)
    assert float(named(stable, "stability-locked").margin) <= 5


def test_decide_is_monotone_between_margin_and_twin():
    setting, C = reference()
    prover = Prover.of(Subject(setting, C))
    claims = {(c.id, c.form): c for c in certify(setting, C)}
    for constraint in constraints(setting):
        claim = claims[constraint.id, constraint.form]
        if claim.status is not PROVEN or claim.refuted_at is None or constraint.on_band:
            continue
        constraint = replace(constraint, band=claim.interval)
        assert prover.decide(constraint, claim.margin) is PROVEN
        assert prover.decide(constraint, claim.refuted_at.value) is not PROVEN


def test_a_loop_that_any_lag_makes_unstable_is_not_stable():
    """Ideal actuator, C = −3/4, −3: 1 + HCF is 1/4, and −2: no root, but H/(1 + εs) has one at 2/ε."""
    setting = Setting.of(spec(actuator={"type": "ideal"}, controller={"type": "dynamic-feedback", "order": 1}))
    for gain, expected in (("-3/4", PROVEN), ("-3", REFUTED)):
        C = setting.compensator(Polynomials(numerator=(Fraction(gain),), denominator=(Fraction(1),)))
        *_, locked = prove_stability(setting, C)
        assert (locked.id, locked.status) == ("stability-locked", expected)


def half_torque(pole: str, **constraints: object) -> tuple[Setting, Compensator]:
    """H = 1/2, Q = (80 − 10 s)/(s² + pole s + 100): with `pole` = −1 Q is unstable, though 1 + HCF and N are not."""
    asked = spec(
        plant={"inertia": "1", "damping": "2", "stiffness": "1"},
        uncertainty={"box": None, "weight": {"numerator": ("0.005",), "denominator": ("1",)}},
        actuator={
            "type": "two-port",
            "transfer": {"numerator": ("1",), "denominator": ("2",)},
            "impedance": {"numerator": ("0",), "denominator": ("2",)},
        },
        impedance={"inertia": "0.1", "damping": "0.2", "stiffness": "0.1"},
        objective={"attenuation": "0.4"},
        constraints={"eq12": {"form": "structured", "margin": "-100"}, "eq18": None, "peak": "3"} | constraints,
    )
    return subject(asked, rational(["-10", "80"], ["1", pole, "100"]))


PRINTED = {"form": "paper", "margin": "0", "band": ("1", "2")}


def test_what_speaks_of_an_ideal_actuator_supposes_a_joint_that_is_stable_behind_one():
    """`1 − Q + (1 + Δ)(Ω + Q)` cannot be kept off the axis by |Δ| where it begins on the right."""
    for pole, expected in (("1", PROVEN), ("-1", REFUTED)):
        setting, C = half_torque(pole, eq12=PRINTED)
        claims = certify(setting, C)
        assert {c.status for c in claims if c.form in STABILITY} == {PROVEN}
        for claim in (named(claims, "eq9"), named(claims, "eq12", "paper")):
            assert claim.status is expected
            if expected is REFUTED:
                low = Fraction(1) if claim.id == "eq12" else Fraction(0)
                assert claim.margin is None and claim.refuted_at == Refutation(Fraction(1), Witness(low, None))
        found = {c.id for c in counterexamples(setting, C, 1.0)}
        assert ({"eq9", "eq12"} & found) == (set() if expected is PROVEN else {"eq9", "eq12"})


def test_stability_margins_are_routh_sandwiches():
    setting, C = reference()
    for claim, p in zip(
        prove_stability(setting, C),
        (setting.loop.free(setting.loop.nominal)(C), setting.loop.locked()(C)),
        strict=True,
    ):
        for v, expected in ((claim.margin, True), (claim.refuted_at.value, False)):
            assert is_hurwitz(p, exact(v)) is expected


def test_a_band_is_respected():
    """Passivity at the stiffer impedance fails only near 51 rad/s: a band that ends before is proven."""
    impedance = {"inertia": "0.03", "damping": "0.25", "stiffness": "3"}
    for band, expected in ((("1", "30"), PROVEN), (("1", "60"), REFUTED)):
        eq12 = {"form": "structured", "band": band, "margin": "0"}
        claim = named(certify(*reference(impedance=impedance, constraints={"eq12": eq12})), "eq12", "structured")
        assert claim.status is expected
        assert claim.interval == (Fraction(band[0]), Fraction(band[1]))


@pytest.mark.parametrize("num", [["1"], ["0"]])
def test_static_controllers_have_no_mode_of_their_own(num):
    """An ideal actuator with C = 1 or 0 against a wall has no pole at all."""
    asked = spec(actuator={"type": "ideal"}, controller={"type": "dynamic-feedback"})
    claim = named(certify(*subject(asked, rational(num, ["1"]))), "stability-locked")
    assert (claim.status, claim.margin) == (PROVEN, 0)
