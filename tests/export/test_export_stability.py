"""The sampled loop as it is: against SciPy's discretisation, and against a joint moved tick by tick."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from export_joints import IDEAL, JOINT, Drive, compensator, held, law_of, replaced, setting_of
from flint import acb, acb_poly, fmpq
from scipy.linalg import expm
from scipy.signal import cont2discrete

from robimp.models.rational import RationalFunction, descending, exact
from robimp.models.sampling import Hold
from robimp.synthesis.certificate.enclosure.cells import Cells
from robimp.synthesis.certificate.enclosure.joint import family_of
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.export.box import Box, alias_bound
from robimp.synthesis.export.law import Law
from robimp.synthesis.export.pulse import precision, prove_sampled, pulse
from robimp.synthesis.export.targets import Subject, document
from robimp.synthesis.problem.setting import Setting

FILTERED = replaced(
    JOINT,
    (
        "{type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}",
        "{type: dynamic-feedback, coefficients: {numerator: [2.5], denominator: [1]},"
        " filters: {force: 100, position: none, derivative: 1000}}",
    ),
)
COMMON = replaced(JOINT, ("denominator: [1, 70.75, 2500]}}", "denominator: [1, 70.75, 2500]}, filters: {force: 400}}"))
UNCERTAIN = replaced(
    JOINT,
    ("stiffness: [0, 0]}}", "stiffness: [0, 0]}, actuator: {motor_inertia: ±15 %, spring_stiffness: ±10 %}}"),
    ("stiffness: 1.25}", "stiffness: [0.5, 4]}"),
)
LATE = replaced(JOINT, ("delay: 1 ms", "delay: 0.3 ms"))
UNDELAYED = replaced(JOINT, ("delay: 1 ms", "delay: 0"))
JOINTS = {"paper": JOINT, "late": LATE, "undelayed": UNDELAYED, "ideal": IDEAL, "two filters": FILTERED, "one": COMMON}


def floats(p: object) -> list[float]:
    """Descending coefficients of a polynomial of balls."""
    return [float(c.mid()) for c in reversed(p.coeffs())]  # type: ignore[attr-defined]


def matrices(num: list[float], den: list[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Controllable form of num/den, descending."""
    from scipy.signal import tf2ss

    A, B, C, D = tf2ss(num, den)
    return A, B, C, float(D[0, 0])


def test_without_delay_it_is_the_zero_order_hold() -> None:
    G = RationalFunction.of([3, 40], [1, 7, 200, 900])
    found = pulse(G.num, G.den, Hold(exact("0.01"), fmpq(0)))
    num, den, _ = cont2discrete(([3, 40], [1, 7, 200, 900]), 0.01)
    np.testing.assert_allclose(floats(found.den), [*den, 0.0], rtol=1e-9)
    np.testing.assert_allclose(floats(found.num), [*num[0][1:], 0.0], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("delay", ["0", "0.003", "0.01", "0.027"])
@pytest.mark.parametrize("num", [[3, 40], [2, 0, 1, 5]])
def test_samples_of_a_step_are_those_of_the_joint(num: list[float], delay: str) -> None:
    """A command of 1 from tick 0 on: the division num/den in powers of z⁻¹ against the exact motion, delay and all."""
    den, T = [1, 7, 200, 900], 0.01
    G = RationalFunction.of(num, den)
    found = pulse(G.num, G.den, Hold(exact("0.01"), exact(delay)))
    a, b = floats(found.den), floats(found.num)
    b = [0.0] * (len(a) - len(b)) + b
    samples: list[float] = []
    for k in range(12):
        pushed = sum(b[: k + 1])
        samples.append((pushed - sum(a[i] * samples[k - i] for i in range(1, min(k, len(a) - 1) + 1))) / a[0])
    A, B, C, D = matrices(num, den)
    n = len(A)
    expected = []
    for k in range(12):
        since = k * T - float(delay)  # just before the k-th tick the command has acted for so long
        flow = expm(np.block([[A, B], [np.zeros((1, n + 1))]]) * max(since, 0.0))
        expected.append((C @ flow[:n, n:]).item() + (D if since > 1e-12 else 0.0))
    np.testing.assert_allclose(samples, expected, atol=1e-12)


def exported(setting: Setting, law: Law) -> dict[str, object]:
    subject = Subject(setting, law, (), "0", "0", False, "0")
    read: dict[str, object] = json.loads(json.dumps(document(subject)))
    return read


def monodromy(setting: Setting, law: Law, end: str) -> np.ndarray:
    """One tick of joint and law together, from its effect on every unit state: shares no line with the proof."""
    port, hold, load = setting.loop.actuator, setting.loop.actuator.hold, setting.loop.nominal
    den = port.d if end == "locked" else port.d * load.polynomial + port.z
    as_floats = lambda p: [float(c) for c in descending(p)]  # noqa: E731
    A, B, C, D = (
        matrices(as_floats(port.h), as_floats(den))
        if den.degree() > 0
        else (
            np.zeros((0, 0)),
            np.zeros((0, 1)),
            np.zeros((1, 0)),
            float(Fraction(str(port.h[0])) / Fraction(str(den[0]))),
        )
    )
    assert hold is not None
    T, T_d = float(Fraction(str(hold.period))), float(Fraction(str(hold.delay)))
    whole, late = int(T_d / T + 1e-9), T_d - int(T_d / T + 1e-9) * T
    n, text = len(A), exported(setting, law)

    def moved(x: np.ndarray, u: float, time: float) -> np.ndarray:
        flow = expm(np.block([[A, B], [np.zeros((1, n + 1))]]) * time)
        return flow[:n, :n] @ x + flow[:n, n] * u

    def tick(state: np.ndarray) -> np.ndarray:
        drive = Drive(text)  # type: ignore[arg-type]
        x, rest = state[:n], list(state[n:])
        queue = [rest.pop(0) for _ in range(whole + 1)]  # commands that have not acted in full, oldest first
        drive.torques, drive.angles = [rest.pop(0), rest.pop(0)], [rest.pop(0), rest.pop(0)]
        for cascade in drive.z.values():
            for section in cascade:
                section[:] = [rest.pop(0), rest.pop(0)]
        measured = (C @ x).item() + D * queue[0]
        queue.append(drive.step(0.0, measured) if end == "free" else drive.step(-measured, 0.0))
        x = moved(x, queue[0], late)
        x = moved(x, queue[1], T - late)
        memory = [v for cascade in drive.z.values() for section in cascade for v in section]
        return np.array([*x, *queue[1:], *drive.torques, *drive.angles, *memory])

    size = n + whole + 1 + 4 + 2 * sum(len(f) for f in text["filters"].values())  # type: ignore[attr-defined]
    return np.array([tick(unit) for unit in np.eye(size)]).T


@pytest.mark.parametrize("end", ["free", "locked"])
@pytest.mark.parametrize("name", JOINTS)
def test_proven_decay_is_that_of_joint_and_drive(name: str, end: str) -> None:
    setting = setting_of(JOINTS[name])
    law = law_of(setting)
    claim = prove_sampled(setting, law, end)
    radius = abs(np.linalg.eigvals(monodromy(setting, law, end))).max()
    assert claim.status is Outcome.PROVEN
    assert claim.margin is not None and claim.refuted_at is not None
    slowest = -np.log(radius) * float(law.rate)
    assert float(claim.margin) == pytest.approx(slowest, rel=2e-5)
    assert float(claim.margin) < float(claim.refuted_at.value) < float(claim.margin) * 1.001


def test_an_unstable_law_is_refuted() -> None:
    """The control: a feedback gain that a longer delay does not bear, where Z without delay would."""
    setting = setting_of(FILTERED)
    for delay, status in (("0.001", Outcome.PROVEN), ("0.02", Outcome.REFUTED)):
        late = held(setting, "0.001", delay)
        law = law_of(late)
        claim = prove_sampled(late, law, "locked")
        radius = abs(np.linalg.eigvals(monodromy(late, law, "locked"))).max()
        assert claim.status is status
        assert bool(radius < 1) is (status is Outcome.PROVEN)


@pytest.mark.parametrize("text", [JOINT, IDEAL, LATE])
def test_aliases_are_within_their_bound(text: str) -> None:
    """What samples answer beyond the response behind the hold, at corner loads; a tenth of the bound is exceeded."""
    setting = setting_of(text)
    law, hold = law_of(setting), setting.loop.actuator.hold
    assert hold is not None
    box = Box(family_of(setting, compensator(setting)), law, "free")
    rate, port = 1000.0, setting.loop.actuator
    kappa = box._kappa(replace(box.family, setting=setting.held(None), loads=True), np.pi * rate)
    ratios = []
    for load in setting.uncertainty.corners():
        den = port.d * load.polynomial + port.z
        for omega in (0.3, 3.0, 40.0, 400.0, 2000.0, 3000.0):
            with precision(256):
                found, s = pulse(port.h, den, hold), acb(0, omega)
                z, T, T_d = (s / 1000).exp(), acb(hold.period), acb(hold.delay)
                held_base = acb_poly(port.h)(s) / acb_poly(den)(s) * (-s * T_d).exp() * (1 - (-s * T).exp()) / (s * T)
                alias = abs(acb_poly(found.num)(z) / acb_poly(found.den)(z) - held_base)
                alias = float(alias.mid())
            bound = omega * alias_bound(kappa, 2 * np.pi * rate, omega)
            ratios.append(alias / bound)
    assert max(ratios) <= 1
    assert max(ratios) > 0.1


@pytest.mark.parametrize(
    ("text", "end"), [(JOINT, "free"), (IDEAL, "free"), (UNCERTAIN, "free"), (UNCERTAIN, "locked")]
)
def test_a_box_is_stable_as_its_vertices_are(text: str, end: str) -> None:
    setting = setting_of(text)
    box = Box(family_of(setting, compensator(setting)), law_of(setting), end)
    claim = box.prove(None)
    assert claim.status is Outcome.PROVEN
    assert list(box._unstable()) == []


def test_a_box_that_reaches_too_far_is_refuted_at_a_load() -> None:
    text = replaced(IDEAL, ("inertia: ±20 %", "inertia: [0.002, 0.036]"), ("delay: 1 ms", "delay: 8 ms"))
    setting = setting_of(text)
    law = law_of(setting)
    box = Box(family_of(setting, compensator(setting)), law, "free")
    assert prove_sampled(setting, law, "free").status is Outcome.PROVEN, "nominal"
    claim = box.prove(None)
    assert claim.status is Outcome.REFUTED
    assert claim.refuted_at is not None and claim.refuted_at.witness is not None
    load = claim.refuted_at.witness.load
    assert load is not None
    lightest = replace(setting, loop=replace(setting.loop, nominal=load))
    assert abs(np.linalg.eigvals(monodromy(lightest, law, "free"))).max() > 1


def test_a_factor_beyond_the_truth_is_not_proven() -> None:
    """The control of the exclusion: stretched until its lightest load is unstable, the box is not excluded."""
    setting = setting_of(replaced(IDEAL, ("delay: 1 ms", "delay: 8 ms")))
    law = law_of(setting)
    box = Box(family_of(setting, compensator(setting)), law, "free")
    assert box.excluded(Fraction(1))

    def radius(stretch: Fraction) -> float:
        nominal = setting.loop.nominal
        load = replace(nominal, inertia=nominal.inertia * exact(1 - stretch * Fraction(1, 5)))
        lighter = replace(setting, loop=replace(setting.loop, nominal=load))
        return float(abs(np.linalg.eigvals(monodromy(lighter, law, "free"))).max())

    beyond = next(v for k in range(10, 50) if radius(v := Fraction(k, 10)) > 1)
    assert not box.excluded(beyond)


def test_values_on_cells_are_those_of_the_law() -> None:
    """`discrete` and the stiffnesses at single frequencies against floats at e^{jωT}."""
    from robimp.synthesis.export.sampled_joint import SampledJoint

    for text in (JOINT, FILTERED):
        setting = setting_of(text)
        law = law_of(setting)
        omega = np.array([0.1, 9.0, 300.0, 3000.0])
        joint = SampledJoint(family_of(setting, compensator(setting)), Cells.at(omega, 0), law)
        for p in (law.compensator.num, law.compensator.den, law.error.M, law.error.V, law.compensated.A):
            wave = joint.discrete(p)
            for k, at in enumerate(omega):
                with precision(256):
                    exactly = acb_poly(p)((acb(0, -at) / 1000).exp())
                    real, imaginary = float(exactly.real.mid()), float((exactly.imag / at).mid())
                for form, value in ((wave.p, real), (wave.q, imaginary)):
                    found, spread = (0.0, 0.0) if isinstance(form, int) else (form.c[0, k], form.spread[k])
                    assert abs(found - value) <= spread + 1e-13 * abs(value)
                    assert spread <= 1e-9 * (abs(value) + 1e4)
