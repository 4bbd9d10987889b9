"""Draw one of the paper's experiments as the simulator repeats it, with the paper's own Q, and say what came out."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import matplotlib.pyplot as plt

from robimp.synthesis import load
from robimp.synthesis.simulation.experiments import EXPERIMENTS, Experiment

FOLDER = Path(__file__).parent
DOB = (
    (Fraction(2000),),
    (Fraction(1), Fraction("70.75"), Fraction(500)),
)  # C = Q/(1−Q), Q = 0.8·50²/(s²+1.415·50 s+50²)


def draw(name: str) -> Experiment:
    """Run an experiment, `fig9` … `fig12` or `hunting`; write NAME.svg, print which findings it repeats."""
    experiment = EXPERIMENTS[name](load(FOLDER / "haninger2016-paper.yaml"), DOB)
    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "robimp", "svg.fonttype": "none", "axes.grid": True})
    figure, axes = plt.subplots(figsize=(6.4, 3.6), constrained_layout=True)
    for curve in experiment.curves:
        dashed = curve.name.startswith("desired")
        axes.plot(curve.x, curve.y, "k--" if dashed else "-", linewidth=1, label=curve.name)
    axes.set(xlabel=experiment.axes[0], ylabel=experiment.axes[1], title=experiment.title)
    axes.legend(fontsize=8)
    figure.savefig(FOLDER / f"{name}.svg", metadata={"Date": None})
    plt.close(figure)
    print(experiment.title, *experiment.observations, sep="\n  ")
    return experiment
