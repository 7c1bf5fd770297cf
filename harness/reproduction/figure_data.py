"""What the figures of the source are drawn from again: positions, runs and tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.comparison.evidence import Curve
from harness.observables.reference import ReferencePoints
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.reproduction.claims import Statement

Points = NDArray[np.float64]


@dataclass(frozen=True)
class QuartierSystem:
    """The row and the grain on it, to scale with gravity straight down [d].

    ``grains`` maps the source's letters to centres (2,), ``path`` (P, 2) is that
    of the grain's centre.
    """

    angle_deg: float
    spheres: Points  # (S, 2)
    grains: Mapping[str, Points]
    path: Points


@dataclass(frozen=True)
class ForceDiagram:
    """The grain in the well, on one of the two spheres; gravity straight down.

    Centres in d, forces in m g, velocities in sqrt(g d), each (2,).
    ``velocity_before`` is None before the shock.
    """

    name: str
    touched: Points
    other: Points
    grain: Points
    weight: Points
    contact_force: Points
    velocity: Points
    velocity_before: Points | None = None


@dataclass(frozen=True)
class Layers:
    """A substrate of several layers with a grain in a well of the top one, to scale [d].

    ``chain`` (L, 2) are the spheres that touch in a straight line below the
    grain's contact; ``height`` is that of the layers above the fixed row.
    """

    name: str
    layers: int
    fixed: Points
    mobile: Points
    grain: Points
    chain: Points
    height: float


@dataclass(frozen=True)
class VelocitySeries:
    """The speed of one grain near the critical angle, and whether it kept moving."""

    code: str
    angle_deg: float
    moving: bool
    path: Trajectory


@dataclass(frozen=True)
class WindowChoice:
    """A tower with the time of its largest compression and, where it exists, the structure window.

    Times in t0; ``structure`` is NaN where the window does not exist.
    """

    run: TowerRun
    largest_compression: float
    structure: float


@dataclass(frozen=True)
class TowersInTime:
    """Towers of several heights over time, and the largest force on the grain of all [N].

    ``shown`` and ``separated`` are those of the two figures.
    """

    shown: tuple[TowerRun, ...]
    largest_force: float
    separated: tuple[TowerRun, ...]
    base_felt: tuple[float, ...]  # [t0], for each of ``separated``; infinite if not in the run


@dataclass(frozen=True)
class AgainstHeight:
    """The tables of alpha(n) and the critical angle, and a user's points of others."""

    impulses: pd.DataFrame
    scaling: pd.DataFrame
    structure: pd.DataFrame
    reference: ReferencePoints | None


@dataclass(frozen=True)
class Exhibits:
    """What the source's figures are drawn from, and one statement a figure in their order."""

    quartier: QuartierSystem
    shock: tuple[ForceDiagram, ...]
    layers: tuple[Layers, ...]
    motions: tuple[VelocitySeries, ...]
    collisions: tuple[TowerRun, ...]
    peak_errors: Mapping[str, Curve]
    towers: TowersInTime
    collapsed: tuple[TowerRun, ...]
    heights: AgainstHeight
    windows: tuple[WindowChoice, ...]
    statements: tuple[Statement, ...]
