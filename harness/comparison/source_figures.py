"""The figures of the source: what each of them says, and the runs to draw it again from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.comparison.evidence import Curve
from harness.comparison.ledger import Source, Statement
from harness.observables.incline import Trajectory
from harness.observables.reference import ReferencePoints
from harness.observables.tower import TowerRun

Points = NDArray[np.float64]


@dataclass(frozen=True)
class SourceFigure:
    """A figure of the source: its number, a short name, a title, and what it says."""

    number: int
    name: str
    title: str
    says: str

    @property
    def picture(self) -> str:
        """Return the name of the picture that answers it: ``fig-04-velocity-series``."""
        return f"fig-{self.number:02d}-{self.name}"

    @property
    def source(self) -> Source:
        """Return its place in the source, for the ledger."""
        return Source(f"fig-{self.number}", f"figure {self.number}", self.says)

    @property
    def evidence(self) -> tuple[str, ...]:
        """Return the link to the picture, relative to the report's folder."""
        return (f"figures/{self.picture}.svg",)


_LISTED = (
    ("thin-layers", "Thin-layer stability", "the critical angle falls with height (Perrin et al.)"),
    ("quartier", "The Quartier system", "a grain slides from crest A into well B and to crest C"),
    (
        "force-diagrams",
        "Forces before and after the shock",
        "the shock turns the velocity from one contact to the next, and the contact force is "
        "never larger than the normal component of gravity",
    ),
    (
        "velocity-series",
        "Velocity near the critical angle",
        "the smallest angle of steady motion in MFiX is the closed form's to 0.01 deg",
    ),
    (
        "modified-quartier",
        "The modified Quartier system",
        "the substrate may be n layers of grains high, and the shock runs down them",
    ),
    (
        "two-and-three-particles",
        "Velocity and deformation of two and three particles",
        "two particles exchange their momentum; with three, the grain rebounds and the total "
        "deformation, and so the energy stored, is larger",
    ),
    (
        "error-against-stiffness",
        "Error of the peak deformation against stiffness",
        "the error decreases with the stiffness and is below 0.5 % by k = 1e4 N/m",
    ),
    (
        "force-and-contacts",
        "Force and contacts of 2, 3, 10 and 20 particles",
        "three particles: the third joins at 0.5 t0, the grain is alone, comes back at 1 and "
        "leaves at 1.5; 10 and 20 particles are alike",
    ),
    ("collapse", "Collapse across rigidity", "t/t0 collapses runs an order of rigidity apart"),
    (
        "impulse-ratio",
        "Impulse ratio against height",
        "alpha(n) of six runs falls and levels off at about ten contacts, nearly halved",
    ),
    (
        "critical-angle-against-height",
        "Critical angle against height",
        "theta_c(n) falls with height and levels off, as measured by Perrin et al.",
    ),
    (
        "contact-network",
        "Contact network of disks",
        "the contact network of a two-dimensional packing (Papadopoulos et al. 2018)",
    ),
    (
        "energy-scaling",
        "Energy scaling",
        "alpha = 1/sqrt(n) makes theta_c fall up to about ten particles, without an asymptote",
    ),
    (
        "contact-separation",
        "Separation of the contacts with neighbour and chain",
        "a separation develops with the length of the chain: none for 2 particles, overlap for 3 "
        "and 4, and for 20 the contacts up to 1.5 t0 are the neighbour's",
    ),
    (
        "structure-window",
        "Critical angle of the structure window",
        "the first swing of the chain from its total length to one after t0 gives the critical "
        "angles of two to seven particles",
    ),
    (
        "window-selection",
        "Selection of the window",
        "the chain is compressed most at one time within 3 t0, half the window",
    ),
)

FIGURES = {
    f"fig-{number}": SourceFigure(number, *listed) for number, listed in enumerate(_LISTED, 1)
}
"""By key, in the order of the source."""


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
    """Towers over time: those of the figure, the largest force of all heights [N], the collapse."""

    shown: tuple[TowerRun, ...]
    largest_force: float
    collapsed: tuple[TowerRun, ...]
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
    heights: AgainstHeight
    windows: tuple[WindowChoice, ...]
    statements: tuple[Statement, ...]
