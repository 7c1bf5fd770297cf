"""What the runs of a verification of the tower left, for its tables and figures."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from harness.cases.tower.comparison import SeriesComparison
from harness.cases.tower.step_convergence import StepConvergence
from harness.observables.tower import TowerRun

Curve = tuple[list[float], list[float]]
"""Abscissae and ordinates of one line of a figure."""


@dataclass(frozen=True)
class EngineTower:
    """Peak force [N] and turnaround impulse [N s] of a tower, beside the exact propagator's.

    The impulse is NaN where none was recorded.
    """

    engine: str
    height: int
    steps_per_contact: float
    peak_force: float
    exact_peak_force: float
    impulse: float = float("nan")
    exact_impulse: float = float("nan")
    recorded: bool = False

    @property
    def peak_error(self) -> float:
        """Return the relative error of the peak force."""
        return self.peak_force / self.exact_peak_force - 1.0

    @property
    def impulse_error(self) -> float:
        """Return the relative error of the impulse."""
        return self.impulse / self.exact_impulse - 1.0

    def record(self) -> dict[str, Any]:
        """Return the tower as a flat JSON-ready mapping."""
        return {
            "engine": self.engine,
            "height": self.height,
            "steps_per_contact": self.steps_per_contact,
            "peak_force_N": self.peak_force,
            "peak_force_relative_error": self.peak_error,
            "impulse_Ns": self.impulse,
            "impulse_relative_error": self.impulse_error,
            "recorded": self.recorded,
        }


@dataclass
class CodeEvidence:
    """Runs of one code held against the exact propagator.

    ``who`` is the code as reports write it. ``same_law`` maps a law to comparisons of forces;
    ``convergence`` are errors over a ladder of steps; ``towers`` are peak forces and impulses of an
    engine beside the main one.
    """

    who: str = ""
    same_law: dict[str, list[SeriesComparison]] = field(default_factory=dict)
    convergence: list[StepConvergence] = field(default_factory=list)
    towers: list[EngineTower] = field(default_factory=list)


@dataclass
class OwnEvidence(CodeEvidence):
    """What the harness's own solvers left of chain and tower.

    ``collisions`` are free chains of two and three particles, with profiles; ``by_law`` the towers
    of each law; ``collapse`` one tower over stiffnesses; ``drifts`` one tower over solvers and
    steps. The peak errors are relative, over the step [1/omega] and over the stiffness [N/m].
    ``different_law`` holds the laws against each other; ``impulses``, ``by_gamma``, ``ways`` (the
    same Gamma reached in different ways) and ``scaling`` are the tables of alpha(n) and the
    critical angle.
    """

    collisions: list[TowerRun] = field(default_factory=list)
    by_law: dict[str, list[TowerRun]] = field(default_factory=dict)
    collapse: list[TowerRun] = field(default_factory=list)
    drifts: list[TowerRun] = field(default_factory=list)
    peak_by_step: dict[str, Curve] = field(default_factory=dict)
    peak_by_stiffness: dict[str, Curve] = field(default_factory=dict)
    different_law: list[SeriesComparison] = field(default_factory=list)
    impulses: pd.DataFrame | None = None
    by_gamma: pd.DataFrame | None = None
    ways: pd.DataFrame | None = None
    scaling: pd.DataFrame | None = None
