"""Print how fast joints are simulated, against what one would use instead: `make bench-simulation`.

Everything runs in this process and this run, one thread unless said, processor time; comparable by ratio.
"""

from __future__ import annotations

import ctypes
import os
import resource
import subprocess
import tempfile
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import control
import numpy as np
from scipy.integrate import solve_ivp

from robimp.synthesis import load
from robimp.synthesis.simulation import loads
from robimp.synthesis.simulation.adversary.population import CHUNK, drawn
from robimp.synthesis.simulation.batch.environment import through_spring
from robimp.synthesis.simulation.batch.ladder import ladder
from robimp.synthesis.simulation.batch.law import SampledLaw, sampled_law
from robimp.synthesis.simulation.batch.run import LEVELS, simulate_batch
from robimp.synthesis.simulation.batch.switched import Imperfections, Switched, switched
from robimp.synthesis.spec.model import IdealActuator, Impedance, Plant, Spec

ROOT = Path(__file__).parents[1]
SPEC = load(ROOT / "examples" / "haninger2016-paper.yaml")
C = ((Fraction(2000),), (Fraction(1), Fraction("70.75"), Fraction(500)))
FAULTS = Imperfections(load_friction=0.05, motor_friction=0.02)
TICK, TICKS = 1e-3, 10_000
PUSH = 0.3 * np.sin(2 * np.pi * np.arange(TICKS) * TICK)
SMOOTH = (1e-3, 1e-4)  # rad/s: what a smoothed friction calls standing still
JOINTS = 100  # of the comparison with C
Array = np.ndarray[Any, np.dtype[np.float64]]


def timed(work: Callable[[], Any], runs: int = 3) -> tuple[float, Any]:
    """Least processor time [s] of some runs after one that compiles, and the result."""
    result = work()
    seconds = []
    for _ in range(runs):
        began = time.process_time()
        work()
        seconds.append(time.process_time() - began)
    return min(seconds), result


def once(work: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time [s] of one run, and the result."""
    began = time.process_time()
    result = work()
    return time.process_time() - began, result


def smoothed(joint: Switched, speed: float) -> Callable[[Array, Array], Array]:
    """The flow with friction `−F tanh(v/speed)`: what a general integrator needs."""
    n, flow = joint.states, joint.flows[0, 0]
    frictions = np.array([FAULTS.load_friction, FAULTS.motor_friction])
    return lambda x, w: (
        flow[:, :n] @ x + flow[:, n:] @ w - flow[:, n + 4 : n + 6] @ (frictions * np.tanh(x[:3:2] / speed))
    )


def lsoda(law: SampledLaw, plant: Switched, speed: float) -> Array:
    """θ at the ticks, by solve_ivp's LSODA from tick to tick, the controller between."""
    flow, row, x = smoothed(plant, speed), plant.rows[0, 0, 3], np.zeros(plant.states)
    xi, w, theta = np.zeros(len(law.A)), np.zeros(8), np.zeros(TICKS)
    for k in range(TICKS):
        w[0], theta[k] = PUSH[k], x[1]
        sensed = np.array([row @ np.concatenate([x, w]), x[1]])
        w[2] = (law.C @ xi + law.D @ sensed)[0]
        xi = law.A @ xi + law.B @ sensed
        solved = solve_ivp(lambda _, state: flow(state, w), (0, TICK), x, method="LSODA", rtol=1e-7, atol=1e-10)
        x = solved.y[:, -1]
    return theta


def by_control(joint: Switched, speed: float) -> Array:
    """θ at the ticks, by control.input_output_response: it has no sampled controllers, so a continuous one."""
    flow = smoothed(joint, speed)

    def update(_: float, x: Array, u: Array, __: Any) -> Array:
        return flow(x, np.concatenate([np.atleast_1d(u), np.zeros(7)]))

    system = control.nlsys(update, lambda _, x, u, p: x[1], inputs=1, outputs=1, states=joint.states)
    times = np.arange(TICKS) * TICK
    response = control.input_output_response(
        system,
        times,
        PUSH,
        np.zeros(joint.states),
        solve_ivp_method="LSODA",
        solve_ivp_kwargs={"rtol": 1e-7, "atol": 1e-10},
    )
    return np.asarray(response.outputs)


def one_joint() -> None:
    """10 s at 1 kHz with friction."""
    plant, law = switched(SPEC, None, loads(SPEC)[:1], FAULTS), sampled_law(SPEC, C)
    whole = switched(SPEC, C, loads(SPEC)[:1], FAULTS)
    fine = {True: simulate_batch(plant, TICK, PUSH, law=law, every=1, levels=26).trace("theta")}
    sampled, run = timed(lambda: simulate_batch(plant, TICK, PUSH, law=law, every=1))
    continuous, other = timed(lambda: simulate_batch(whole, TICK, PUSH, every=1))
    error = abs(run.trace("theta") - fine[True]).max()
    print(
        f"one joint, 10 s, 1 kHz control, stick and slip: {sampled * 1e3:.2f} ms, {error:.1e} rad from a run 2^13 finer"
    )
    for speed in SMOOTH:
        seconds, theta = once(lambda speed=speed: lsoda(law, plant, speed))
        far = abs(theta - fine[True]).max()
        print(
            f"  solve_ivp LSODA, friction smoothed over {speed:g} rad/s: "
            f"{seconds:.2f} s = {seconds / sampled:.0f}×, {far:.1e} rad off"
        )
    for speed in SMOOTH:
        seconds, theta = once(lambda speed=speed: by_control(whole, speed))
        far = abs(theta - other.trace("theta")).max()
        print(
            f"  control.input_output_response (continuous controller, ours {continuous * 1e3:.2f} ms), "
            f"{speed:g} rad/s: "
            f"{seconds:.2f} s = {seconds / continuous:.0f}×, {far:.1e} rad off (torque held here, interpolated there)"
        )


def against_c() -> None:
    """The same algorithm in C, given the same matrices, on one thread; in both the ladders are built as well."""
    table = drawn(SPEC, JOINTS, np.random.default_rng(0))
    plant, law = switched(SPEC, None, table, FAULTS), sampled_law(SPEC, C)
    ours, run = timed(lambda: simulate_batch(plant, TICK, PUSH, law=law, threads=1))
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "joint.so"
        flags = ["-O2", "-march=native", "-shared", "-fPIC"]
        subprocess.run(
            ["gcc", *flags, str(ROOT / "benchmarks" / "simulation.c"), "-o", str(library), "-lm"], check=True
        )
        joint = ctypes.CDLL(str(library)).joint
        theirs, out = timed(lambda: _in_c(joint, plant, law))
    assert np.allclose(out[:, 1], run.late, rtol=1e-6), "both compute the same"
    each = 1e6 / (JOINTS * TICKS)
    print(
        f"{JOINTS} joints with friction, one thread: {ours * each:.3f} µs per tick, "
        f"C -O2 {theirs * each:.3f} µs: {ours / theirs:.2f}×"
    )


def _in_c(joint: Any, plant: Switched, law: SampledLaw) -> Array:
    n, width = plant.flows.shape[2:]
    steps, rows, out = np.empty((16, LEVELS, n, width)), np.zeros((16, 4, width)), np.zeros((JOINTS, 2))
    limits = np.array([FAULTS.load_friction, FAULTS.motor_friction, FAULTS.torque_limit, FAULTS.stiction])

    def at(array: Array) -> Any:
        return array.ctypes.data_as(ctypes.c_void_p)

    for i in range(JOINTS):
        for k, mode in enumerate(plant.modes):
            ladder(plant.flows[i, k], TICK, steps[mode])
            rows[mode] = plant.rows[i, k]
        joint(
            n, LEVELS, at(steps), at(rows), at(limits), ctypes.c_long(TICKS), at(PUSH), len(law.A),
            at(law.A), at(law.B), at(law.C), at(law.D), at(out[i]),
        )  # fmt: skip
    return out


def ten_thousand() -> None:
    """10,000 loads × 10 s on every core, in chunks as `robimp simulate` does."""
    table, law = drawn(SPEC, 10_000, np.random.default_rng(0)), sampled_law(SPEC, C)
    for words, faults in (("without friction", Imperfections()), ("with friction", FAULTS)):

        def work(faults: Imperfections = faults) -> None:
            for first in range(0, len(table), CHUNK):
                simulate_batch(switched(SPEC, None, table[first : first + CHUNK], faults), TICK, PUSH, law=law)

        began = time.perf_counter()
        seconds, _ = once(work)
        wall = time.perf_counter() - began
        print(
            f"10,000 loads × 10 s at 1 kHz {words}: "
            f"{seconds:.1f} s of processor, {wall:.1f} s on {os.cpu_count()} cores"
        )
    print(f"largest memory of this process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


def energy() -> None:
    """Two masses and a spring, nothing lost, 10⁶ steps of 1 ms."""
    joint = switched(
        _idle(),
        _NOTHING,
        np.array([[2.0, 0, 0]]),
        environment=through_spring(50, 0, Fraction(1, 2)),
    )
    start = np.zeros(joint.states)
    start[0] = 1.0
    run = simulate_batch(joint, TICK, np.zeros(1_000_001), start=start, every=1_000_000)
    speed, torque = run.trace("velocity")[-1], run.trace("tau_int")[-1]
    total = speed**2 + 0.25 * ((2 - 2 * speed) / 0.5) ** 2 + torque**2 / 100
    print(f"energy of two masses and a spring after 10⁶ steps of 1 ms: {total - 1:.1e} of it gained")


_NOTHING = ((Fraction(0),), (Fraction(1),))


def _idle() -> Spec:
    """A mass whose controller has nothing to do."""
    parts = {"inertia": Fraction(2), "damping": Fraction(0), "stiffness": Fraction(0)}
    joint = {"plant": Plant(**parts), "impedance": Impedance(**parts), "actuator": IdealActuator(type="ideal")}
    return SPEC.model_copy(update=joint)


def main() -> None:
    """Run everything."""
    one_joint()
    against_c()
    ten_thousand()
    energy()


if __name__ == "__main__":
    main()
