"""From measured frequency responses to C code: identify, certify, export, compile (needs a C compiler, `cc`).

measured/frf/ holds six sweeps of a load that is never quite the same. Expected: the mean inertia, which the simulation
behind the sweeps knows; and the exported controller as filters of its samples, with NumPy.
"""

from __future__ import annotations

import subprocess
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np
from compared import FOLDER, Row, omega_B, show
from flint import fmpq_poly

from robimp.synthesis import load, synthesize
from robimp.synthesis.export import Exported, export
from robimp.synthesis.identify import identify, read_files
from robimp.synthesis.simulation.sections import run

MEASURED = FOLDER / "measured"
INERTIA = (0.033 + 0.028 + 0.030 + 0.030) / 4  # of the four sweeps of 1 and 2 N·m, see measured/measure.py
MAIN = """
#include "measured_table.h"
#include <math.h>
#include <stdio.h>
int main(void)
{
    measured_table controller;
    double sample[2], torque;
    if (measured_table_init(&controller, 10000, HUGE_VAL) != MEASURED_TABLE_OK) return 1;
    while (fread(sample, sizeof *sample, 2, stdin) == 2) {
        torque = measured_table_step(&controller, sample[0], sample[1]);
        fwrite(&torque, sizeof torque, 1, stdout);
    }
    return 0;
}
"""


def compare() -> list[Row]:
    """The fit, the certificate, what of it holds for the code, and the code itself."""
    records = read_files(sorted((MEASURED / "frf").glob("*.csv")))  # the dead one is found and left out
    found = identify(records, kind="load", amplitude=(Fraction(1), Fraction(2)), beyond="hold")
    result = synthesize(load(MEASURED / "measured.yaml"))
    code = export(result.certificate_bytes(), target="c", rate=10_000)
    samples = np.random.default_rng(0).normal(size=(10_000, 2))
    samples[:2] = 0  # the joint is at rest
    torque, same = compiled(code, samples), numpy(code, samples)
    apart = float(np.max(abs(torque - same)) / np.max(abs(same)))
    return [
        ("inertia fitted to four sweeps [kg·m²]", float(found.model.plant.inertia), INERTIA),
        ("exit code of the certificate", result.exit_code, 0),
        ("exit code of the export at 10 kHz", code.exit_code, 0),
        ("ω_B with the shipped coefficients, and continuous", float(_omega_B(code)), omega_B(result.certificate)),
        ("largest difference of C from NumPy, of the largest torque", apart, 0),
    ]


def _omega_B(code: Exported) -> float:
    return next(float(each.claim.margin) for each in code.claims if each.id == "bandwidth" and each.claim)


def compiled(code: Exported, samples: np.ndarray) -> np.ndarray:
    """Torques [N·m] of the exported code, compiled. samples: (n, 2), τ_int [N·m] and θ [rad]."""
    with tempfile.TemporaryDirectory() as folder:
        code.write(folder)
        (Path(folder) / "main.c").write_text(MAIN, encoding="utf-8")
        compiler = "cc -std=c99 -O2 -ffp-contract=off -o main main.c measured_table.c -lm"
        subprocess.run(compiler.split(), cwd=folder, check=True)
        done = subprocess.run([f"{folder}/main"], input=samples.tobytes(), capture_output=True, check=True)
    return np.frombuffer(done.stdout)


def numpy(code: Exported, samples: np.ndarray) -> np.ndarray:
    """The same as filters of the samples: `τ_d = C (M τ_int − M G_imp θ) + M_d (Ĝ⁻¹ − G_imp) θ`."""
    law, (tau_int, theta) = code.law, samples.T
    error = filtered(law.error.M, tau_int) - filtered(law.error.stiffness(law.desired), theta)
    compensation = law.compensated.stiffness(law.nominal) - law.compensated.stiffness(law.desired)
    return run(law.compensator.sos, error, np.float64) + filtered(compensation, theta)


def filtered(polynomial: fmpq_poly, signal: np.ndarray) -> np.ndarray:
    """A polynomial of z⁻¹, the delay of one tick, applied to a signal that was 0 before."""
    return np.convolve([int(c.p) / int(c.q) for c in polynomial.coeffs()], signal)[: len(signal)]


if __name__ == "__main__":
    show(compare())
