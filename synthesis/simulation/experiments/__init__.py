"""The paper's experiments, repeated on the simulated joint: numbers that say which of its findings come out again."""

from .experiment import Curve, Experiment, Observation, demand_papers_joint, notes
from .hunting import hunting
from .loading import fig9, fig10
from .rendering import fig11, fig12

EXPERIMENTS = {"fig9": fig9, "fig10": fig10, "fig11": fig11, "fig12": fig12, "hunting": hunting}

__all__ = ["EXPERIMENTS", "Curve", "Experiment", "Observation", "demand_papers_joint", "notes"]
