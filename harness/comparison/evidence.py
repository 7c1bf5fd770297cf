"""The runs behind a verification, kept for tables and figures. What could not be run is missing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.extrapolation import ExtrapolatedAngle
from harness.cases.incline.result import InclineRun
from harness.cases.tower.comparison import SeriesComparison
from harness.cases.tower.step_convergence import StepConvergence
from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Comparison
from harness.errors import EngineError
from harness.observables.tower import TowerRun

Curve = tuple[list[float], list[float]]
"""Abscissae and ordinates of one line of a figure."""


@dataclass(frozen=True)
class Recursion:
    """Energy after each shock in a run, and by the recursion from the first; in m g d."""

    run: InclineRun
    measured: NDArray[np.float64]
    predicted: NDArray[np.float64]


@dataclass
class InclineEvidence:
    """What the engine's runs of the incline left.

    ``by_contact`` maps the name of a contact to its angles over stiffness and
    step. ``measured`` are cases for the baseline that nothing else keeps,
    ``errors`` those of its cases whose run died, by name.
    """

    closed_form_deg: float
    extrapolated: ExtrapolatedAngle | None = None
    by_contact: dict[str, list[CriticalAngle]] = field(default_factory=dict)
    routes: list[CriticalAngle] = field(default_factory=list)
    motions: list[InclineRun] = field(default_factory=list)
    recursion: Recursion | None = None
    measured: list[BaselineRecord] = field(default_factory=list)
    errors: dict[str, EngineError] = field(default_factory=dict)


@dataclass
class TowerEvidence:
    """What solvers and engine left of chain and tower.

    ``collisions`` are free chains of two and three particles, with profiles;
    ``by_law`` the towers of each law; ``collapse`` one tower over stiffnesses;
    ``drifts`` one tower over solvers and steps. The peak errors are relative,
    over the step [1/omega] and over the stiffness [N/m]. ``same_law`` maps a law
    to comparisons of codes with the exact propagator, ``different_law`` holds
    the laws against each other; ``impulses``, ``by_gamma``, ``ways``
    (the same Gamma reached in different ways) and ``scaling`` are the tables of
    alpha(n) and the critical angle. ``measured`` are the runs as cases for the
    baseline, ``errors`` those of cases whose run died, ``parted`` the series
    that left the band about their reference.
    """

    collisions: list[TowerRun] = field(default_factory=list)
    by_law: dict[str, list[TowerRun]] = field(default_factory=dict)
    collapse: list[TowerRun] = field(default_factory=list)
    drifts: list[TowerRun] = field(default_factory=list)
    peak_by_step: dict[str, Curve] = field(default_factory=dict)
    peak_by_stiffness: dict[str, Curve] = field(default_factory=dict)
    same_law: dict[str, list[SeriesComparison]] = field(default_factory=dict)
    different_law: list[SeriesComparison] = field(default_factory=list)
    convergence: list[StepConvergence] = field(default_factory=list)
    impulses: pd.DataFrame | None = None
    by_gamma: pd.DataFrame | None = None
    ways: pd.DataFrame | None = None
    scaling: pd.DataFrame | None = None
    measured: list[BaselineRecord] = field(default_factory=list)
    errors: dict[str, EngineError] = field(default_factory=dict)
    parted: list[Comparison] = field(default_factory=list)
