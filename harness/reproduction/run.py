"""Recompute the source, its ledger and figures, with tables of findings beyond it."""

from __future__ import annotations

import math
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import pandas as pd
from matplotlib import figure as mpl_figure

from harness import __version__
from harness.cases.incline.angle import CriticalAngle, critical_angle
from harness.cases.incline.system import Incline
from harness.cases.tower import figures as impulse
from harness.cases.tower.figures import velocity_and_deformation
from harness.cases.tower.impulse import impulse_angles
from harness.engines.contract import Engine
from harness.engines.reference import Reference
from harness.observables.provenance import Provenance
from harness.observables.reference import PEYNEAU_ROUX, Trajectory
from harness.observables.tower import WINDOWS
from harness.parameters.law import Contact
from harness.parameters.tower import Tower
from harness.reproduction import figure_data, schematics
from harness.reproduction import figures as drawn
from harness.reproduction.claims import ClaimStatus, Ledger, Statement
from harness.reproduction.figure_data import (
    error_against_stiffness,
    structure_window,
    two_and_three_particles,
    velocity_series,
    window_selection,
)
from harness.reproduction.ledger import in_order, statements
from harness.reproduction.mfix import (
    ADAMS_BASHFORTH,
    EULER,
    STIFFNESSES,
    angle_in_scheme,
    case_at,
    scheme_paths,
)
from harness.reproduction.schematics import collapse, force_and_contacts, separated
from harness.shown import Result
from harness.store.cache import EngineChoice, opened
from harness.theory.chain import shock_from_restitution
from harness.theory.incline import critical_angle as closed_form
from harness.workflows.progress import Progress, silent

if TYPE_CHECKING:
    from harness.shown.figure import Figure

SOLVER = "exact"
"""What made the tables over height."""


Compute = Callable[[], tuple[Any, Statement]]
"""Return what a figure is drawn from, empty where there is nothing, and its statement."""

Draw = Callable[[Any], mpl_figure.Figure]


class SourceFigure(NamedTuple):
    """A figure of the source: its statement, and how to draw it; None where it cannot be."""

    statement: Statement
    draw: Callable[[], mpl_figure.Figure] | None


def source_figures(
    engine: Engine | None,
    progress: Progress = silent,
    *,
    paths: Mapping[tuple[int, float], Trajectory] | None = None,
) -> tuple[SourceFigure, ...]:
    """Recompute the source's figures, in their order.

    ``engine`` runs the incline; without it, or if it fails, that figure cannot be
    tested and keeps those in MFiX's scheme: ``paths`` by (steps per contact time, angle [deg]),
    computed if not given. ``reference`` are measured angles of the user's, for what the source
    compares with others.
    """
    runs = cache(lambda: impulse_angles(solver=SOLVER, laws=(Tower().law,)))
    paths = scheme_paths() if paths is None else paths
    # of each what it is drawn from with its statement, and how it is drawn from that
    figures: tuple[tuple[Compute, Draw], ...] = (
        (lambda: (True, figure_data.thin_layers()),
         lambda _: drawn.thin_layers(PEYNEAU_ROUX)),
        (schematics.quartier, drawn.quartier_system),
        (schematics.force_diagrams, drawn.force_diagrams),
        (lambda: velocity_series(engine, paths), drawn.velocity_series),
        (schematics.layers, drawn.layers),
        (two_and_three_particles, velocity_and_deformation),
        (error_against_stiffness, drawn.error_against_stiffness),
        (force_and_contacts, drawn.of_all_heights),
        (collapse, drawn.collapse),
        (lambda: (True, figure_data.impulse_ratio(runs())),
         lambda _: impulse.ratio_against_height(runs(), SOLVER)),
        (lambda: (True, figure_data.critical_angles(runs())),
         lambda _: impulse.critical_angle_against_height(
            runs(), solver=SOLVER, published=PEYNEAU_ROUX)),
        (figure_data.energy_scaling,
         lambda data: impulse.energy_scaling(data, PEYNEAU_ROUX)),
        (separated, drawn.separation),
        (structure_window, lambda data: drawn.structure_window(data, PEYNEAU_ROUX)),
        (window_selection, drawn.window_selection),
    )  # fmt: skip
    recomputed = []
    for done, (compute, draw) in enumerate(figures, 1):
        data, statement = compute()
        nothing = isinstance(data, tuple) and not data  # no runs
        drawing = None if nothing else partial(draw, data)
        recomputed.append(SourceFigure(statement, drawing))
        progress("figures of the source", done, len(figures))
    return tuple(recomputed)


@dataclass(frozen=True, repr=False)
class Reproduction(Result):
    """All that a reproduction found; the same code and engine give the same."""

    ledger: Ledger
    figures: tuple[SourceFigure, ...]
    findings: FindingTables
    provenance: Provenance
    platform: str
    harness_version: str

    def to_frame(self) -> pd.DataFrame:
        """Return the ledger as a table, a row for each statement."""
        return self.ledger.to_frame()

    def summary(self) -> dict[str, str]:
        """Return how many statements have each status, and who ran what it took."""
        counts = {str(status): str(self.ledger.count(status)) for status in ClaimStatus}
        return {**counts, "engine": self.provenance.label}

    def draw(self) -> Figure:
        """Draw how many statements have each status."""
        from harness.shown.figure import Figure, label

        figure = Figure(figsize=(7.0, 2.6), layout="constrained")
        axes = figure.add_subplot()
        axes.barh([*map(str, ClaimStatus)], [self.ledger.count(status) for status in ClaimStatus])
        axes.invert_yaxis()
        label(axes, "statements of the source", "status")
        return figure


def reproduce(
    *,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = silent,
) -> Reproduction:
    """Recompute every equation, number and figure of the source and return what was found.

    ``engine`` is an open one, or a name; LAMMPS in-process unless given, its runs kept.
    ``reference`` are measured angles [deg] against height, for what the source compares with
    others. Raise EngineError when the engine fails: a reproduction with holes is none. Write the
    report with :func:`harness.reproduction.page.write`.
    """
    if isinstance(engine, str | None):
        with opened(engine, fresh=fresh) as running:
            return reproduce(engine=running, progress=progress)
    figures = source_figures(engine, progress)
    rows = statements(engine=engine, progress=progress)
    return Reproduction(
        ledger=Ledger(tuple(in_order([*rows, *(figure.statement for figure in figures)]))),
        figures=figures,
        findings=findings(engine, progress),
        provenance=engine.identify(),
        platform=f"{platform.system()} {platform.machine()}",
        harness_version=__version__,
    )


FACTORS = (50, 100, 200, 500, 1000, 2000, 5000)
RESTITUTIONS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
IN_THE_ENGINE = (0.1, 0.5)
STEPS_PER_CONTACT = 100.0
TOLERANCE_DEG = 5e-3
STIFFNESS, SPEED = 1e6, 2.0
"""[N/m], [m/s]: the run of the source's figures of force and contacts."""


@dataclass(frozen=True)
class FindingTables:
    """Tables behind the page of findings; angles in deg.

    ``restitution`` (a row for each e): the angle of both readings of the shock,
    and what the reference DEM and the engine measure; ``heights`` (height, law,
    window): impulse ratio and angle of both readings; ``mfix`` (stiffness, step
    factor, scheme): critical angle of our integrator in MFiX's scheme; ``limits``
    (stiffness): the angle of the same contact without a step.
    """

    restitution: pd.DataFrame
    heights: pd.DataFrame
    mfix: pd.DataFrame
    limits: pd.DataFrame
    closed_form_deg: float

    def at_height(self, height: int, law: str, window: str = "turnaround") -> pd.Series:
        """Return the row of a tower; raise IndexError if it was not run."""
        frame = self.heights
        selected = (frame["height"] == height) & (frame["law"] == law) & (frame["window"] == window)
        return frame[selected].iloc[0]


def findings(engine: Engine, progress: Progress = silent) -> FindingTables:
    """Return the tables; the first compares ``engine`` with the reference DEM."""
    frames: list[pd.DataFrame] = []
    tables = (lambda: restitution_table(engine), _heights, mfix_table, angles_without_step)
    for done, table in enumerate(tables):
        progress("findings", done, len(tables))
        frames.append(table())
    progress("findings", len(tables), len(tables))
    restitution, heights, mfix, limits = frames
    return FindingTables(restitution, heights, mfix, limits, closed_form())


def restitution_table(engine: Engine) -> pd.DataFrame:
    """Return a row for each restitution: both readings, the reference DEM, the engine (some).

    Measured by steady motion: a grain that rebounds may fly over the crest, where
    a passage means nothing. Angles and uncertainties in deg, NaN where not measured.
    """

    def measured(restitution: float, by: Engine) -> CriticalAngle:
        contact = Contact(name="rebound", restitution=restitution, damping_ratio=None)
        case = Incline(contact=contact, stiffness=STIFFNESS, steps_per_contact=STEPS_PER_CONTACT)
        return critical_angle(case, method="steady", tolerance_deg=TOLERANCE_DEG, engine=by)

    with Reference() as reference:
        rows = [
            {
                "restitution": e,
                "kept_deg": closed_form(shock_from_restitution(e, "kept")),
                "lost_deg": closed_form(shock_from_restitution(e, "lost")),
                **_columns("reference", measured(e, reference)),
                **_columns("engine", measured(e, engine) if e in IN_THE_ENGINE else None),
                "steps_per_contact": STEPS_PER_CONTACT,
            }
            for e in RESTITUTIONS
        ]
    return pd.DataFrame(rows)


def _heights() -> pd.DataFrame:
    return impulse_angles(
        stiffnesses=(STIFFNESS,), speeds=(SPEED,), windows=WINDOWS, solver="exact"
    )


def mfix_table() -> pd.DataFrame:
    """Return the critical angle of MFiX's contact over stiffness and ``DTSOLID_FACTOR``.

    Columns for each integrator: value and uncertainty in deg, NaN where its step is unstable.
    """
    rows = [
        {
            "stiffness_N_per_m": k,
            "factor": factor,
            **_columns("euler", angle_in_scheme(k, factor, EULER)),
            **_columns("adams_bashforth", angle_in_scheme(k, factor, ADAMS_BASHFORTH)),
        }
        for k in STIFFNESSES
        for factor in FACTORS
    ]
    return pd.DataFrame(rows)


def angles_without_step() -> pd.DataFrame:
    """Return the critical angle of the same contact by the adaptive integrator, for each k."""
    with Reference("adaptive") as engine:
        # no step: where in one a contact begins does not matter
        rows = [
            {
                "stiffness_N_per_m": k,
                "critical_angle_deg": critical_angle(
                    case_at(10.2, k, 50), phases=1, engine=engine
                ).value_deg,
            }
            for k in STIFFNESSES
        ]
    return pd.DataFrame(rows)


def _columns(name: str, angle: CriticalAngle | None) -> dict[str, float]:
    return {
        f"{name}_deg": angle.value_deg if angle else math.nan,
        f"{name}_uncertainty_deg": angle.uncertainty_deg if angle else math.nan,
    }
