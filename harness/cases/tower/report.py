"""Sections of a report on the tower: the laws, the engines compared, and the figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from harness.cases.display import Display
from harness.cases.text import Words
from harness.cases.tower import figures
from harness.cases.tower.comparison import DIVERGENCE, SeriesComparison
from harness.cases.tower.figures import peak_error, tower_error_against_step
from harness.cases.tower.film import tower_film
from harness.cases.tower.run import RATIO, of_ratio
from harness.cases.tower.run import tower as run_tower
from harness.cases.tower.system import TowerRunParameters
from harness.cases.tower.verification import CodeEvidence, OwnEvidence
from harness.observables.reference import PEYNEAU_ROUX
from harness.report.sections import Drawing, Section, Table
from harness.report.style import power

if TYPE_CHECKING:
    import pandas as pd

    from harness.comparison.verification import Findings
    from harness.engines.contract import Engine
    from harness.report.film import Film

WORDS = Words(__file__)


class TowerDisplay(Display):
    """Shows where the laws differ, the towers of engines, and the shock in motion."""

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return where the laws differ, the towers of engines, and the figures."""
        others = [findings.evidence for findings in engines.values()]
        return tuple(_sections(main.evidence if main else None, solvers.evidence, others))

    def film(self, engine: Engine, parameters: TowerRunParameters, frames: int) -> Film:
        """Return the film of a run."""
        run = run_tower(
            parameters.tower,
            duration=parameters.duration,
            steps_per_contact=parameters.steps_per_contact,
            profiles=True,
            engine=engine,
        )
        return tower_film(run, frames)


def drawings(main: CodeEvidence | None, solvers: OwnEvidence) -> Iterator[Drawing]:
    """Yield the figures for which there is evidence."""
    yield from _comparisons(main, solvers)
    yield from _impulses(solvers)
    yield from _towers(solvers)


def _comparisons(main: CodeEvidence | None, solvers: OwnEvidence) -> Iterator[Drawing]:
    """Yield codes against the exact propagator, and law against law."""
    codes = [evidence for evidence in (main, solvers) if evidence is not None]
    for law in solvers.same_law:
        by_law: list[SeriesComparison] = [c for code in codes for c in code.same_law.get(law, [])]
        names = " and ".join(code.title for code in codes if law in code.same_law)
        yield WORDS.drawing(
            "same-law-{law}", partial(figures.same_law, by_law), law=law, names=names
        )
    convergence = [row for code in codes for row in code.convergence]
    if convergence:
        yield WORDS.drawing(
            "error-against-step",
            lambda: figures.error_against_step(convergence),
            particles=convergence[0].reference.tower.particles,
        )
    if solvers.different_law:
        yield WORDS.drawing(
            "different-law", lambda: figures.different_law(solvers.different_law), band=DIVERGENCE
        )


def _impulses(solvers: OwnEvidence) -> Iterator[Drawing]:
    """Yield alpha(n) and the critical angle that it leads to."""
    if solvers.impulses is None or solvers.scaling is None:
        return
    frame, by_gamma, scaling = solvers.impulses, solvers.by_gamma, solvers.scaling
    yield WORDS.drawing("impulse-ratio", lambda: figures.ratio_against_height(frame, "exact"))
    yield WORDS.drawing(
        "critical-angle-against-height",
        lambda: figures.critical_angle_against_height(
            frame, solver="exact", published=PEYNEAU_ROUX
        ),
    )
    if solvers.by_state_point is not None:
        frames = solvers.by_state_point
        heights = sorted({int(n) for n in frames["height"]})
        yield WORDS.drawing(
            "collapse-on-gamma", lambda: figures.collapse_on_gamma(frames, "exact", heights)
        )
    if by_gamma is not None:
        yield WORDS.drawing(
            "impulse-map",
            lambda: figures.map_over_gamma(by_gamma, "exact", sorted(set(frame["gamma"]))),
        )
    yield WORDS.drawing("energy-scaling", lambda: figures.energy_scaling(scaling, PEYNEAU_ROUX))


def _towers(solvers: OwnEvidence) -> Iterator[Drawing]:
    """Yield single runs in time, and the errors of RK4."""
    if solvers.collisions:
        yield WORDS.drawing(
            "two-and-three-particles", lambda: figures.velocity_and_deformation(solvers.collisions)
        )
    for law, towers in solvers.by_law.items():
        case = towers[0].tower
        yield WORDS.drawing(
            "force-and-contacts-{law}",
            partial(figures.force_and_contacts, towers),
            law=law,
            stiffness=power(case.stiffness),
            speed=case.speed,
        )
    if solvers.collapse:
        yield WORDS.drawing("collapse", lambda: figures.collapse(solvers.collapse))
    if solvers.peak_by_step:
        yield WORDS.drawing(
            "peak-deformation-error",
            lambda: peak_error(solvers.peak_by_step, solvers.peak_by_stiffness),
        )
    if solvers.drifts:
        yield WORDS.drawing("energy-drift", lambda: figures.energy_drift_in_time(solvers.drifts))


LAWS_HEIGHTS = (1, 2, 3, 4, 9, 19)
"""Heights of the table of both laws."""


def _sections(
    main: CodeEvidence | None, solvers: OwnEvidence, engines: Sequence[CodeEvidence]
) -> Iterator[Section]:
    if solvers.impulses is not None:
        yield opening_section(solvers.impulses)
        yield WORDS.section("laws", tables=(laws_table(solvers),))
    table = towers_table(engines)
    orders = [convergence for evidence in engines for convergence in evidence.convergence]
    if table.rows or orders:
        tables = (table,) if table.rows else ()
        yield WORDS.section("engines", tables=tables, drawings=tuple(_engines(engines)))
    yield Section(drawings=tuple(drawings(main, solvers)))


def opening_section(frame: pd.DataFrame) -> Section:
    """Return what the tower answers: the angle of one contact and of the most, by both laws."""
    one_run = of_ratio(frame)
    ends = (
        one_run.sort_values("height")
        .groupby("law")["critical_angle_lost_deg"]
        .agg(["first", "last"])
    )
    last = " and ".join(f"{angle:.2f} deg ({law} law)" for law, angle in ends["last"].items())
    figure = WORDS.drawing(
        "critical-angle-over-contacts",
        lambda: figures.angle_over_contacts(one_run, PEYNEAU_ROUX),
        stiffness=power(RATIO.each("stiffness")[0]),
        speed=RATIO.speed,
    )
    first, height = float(ends["first"].iloc[0]), int(one_run["height"].max())
    return Section(
        drawings=(figure,),
        opening=WORDS.opening(figure.name, first=first, last=last, height=height),
    )


def laws_table(solvers: OwnEvidence) -> Table:
    """Return alpha and angles under both laws, and how far the force is apart, height by height."""
    assert solvers.impulses is not None
    frame = solvers.impulses
    forces = {c.run.tower.height: c.force for c in solvers.different_law}
    stiffness, speed, one_run = RATIO.each("stiffness")[0], RATIO.speed, of_ratio(frame)
    rows = []
    for row in (
        one_run[one_run["height"].isin(LAWS_HEIGHTS)]
        .sort_values(["height", "law"])
        .to_dict(orient="records")
    ):
        force = forces.get(row["height"]) if row["law"] == "deformable" else None
        rows.append(
            (
                str(row["height"]),
                str(row["law"]),
                f"{row['impulse_ratio']:.4f}",
                f"{row['critical_angle_lost_deg']:.3f}",
                f"{row['critical_angle_kept_deg']:.3f}",
                f"{force.peak:.3f}" if force else "",
                f"{force.l2:.3f}" if force else "",
            )
        )
    return WORDS.table("Both laws", rows, stiffness=power(stiffness), speed=speed)


def towers_table(engines: Sequence[CodeEvidence]) -> Table:
    """Return the errors of engines at each height, and the order of the error in the step."""
    towers = [tower for evidence in engines for tower in evidence.towers]
    heights = sorted({tower.height for tower in towers})
    by_engine = {(t.engine, t.height): t for t in towers}
    orders = {
        convergence.solver: convergence.l2_order
        for evidence in engines
        for convergence in evidence.convergence
    }
    rows = []
    for engine in dict.fromkeys(tower.engine for tower in towers):
        cells, steps = [], 0.0
        for height in heights:
            tower = by_engine.get((engine, height))
            errors = () if tower is None else (tower.peak_error, tower.impulse_error)
            finite = [abs(error) for error in errors if not math.isnan(error)]
            cells.append(f"{max(finite):.1e}" if finite else "")
            steps = tower.steps_per_contact if tower else steps
        order = orders.get(engine)
        slope = f"{order.value:.2f}" if order and order.interval[0] > 0.0 else ""
        rows.append((engine, f"{steps:.0f}", *cells, slope))
    return Table(
        "Towers",
        "Towers under the overlap law: the larger of the relative errors of peak force and "
        "turnaround impulse against the exact propagator, and the "
        "order of the force error in the step.",
        ("engine", "steps", *(f"n = {height}" for height in heights), "order"),
        tuple(rows),
    )


def _engines(engines: Sequence[CodeEvidence]) -> Iterator[Drawing]:
    """Yield the figure that compares engines."""
    convergence = [row for evidence in engines for row in evidence.convergence]
    if convergence:
        yield WORDS.drawing("engines-tower-error", lambda: tower_error_against_step(convergence))
