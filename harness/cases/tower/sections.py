"""What a report says of the tower: the laws, engines beside one another, and the figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from harness.cases.case_text import Words
from harness.cases.tower.evidence import CodeEvidence, OwnEvidence
from harness.cases.tower.gallery import drawings
from harness.cases.tower.records import RATIO, of_ratio
from harness.report.figures.style import power
from harness.report.sections import Drawing, Section, Table

WORDS = Words(__file__)

LAWS_HEIGHTS = (1, 2, 3, 4, 9, 19)
"""Heights of the table of both laws."""


def sections(
    main: CodeEvidence | None, own: OwnEvidence, beside: Sequence[CodeEvidence]
) -> tuple[Section, ...]:
    """Return the parts of the report; those without evidence are left out."""
    return tuple(_sections(main, own, beside))


def _sections(
    main: CodeEvidence | None, own: OwnEvidence, beside: Sequence[CodeEvidence]
) -> Iterator[Section]:
    if own.impulses is not None:
        yield WORDS.section("laws", tables=(laws_table(own),))
    table = towers_table(beside)
    orders = [found for one in beside for found in one.convergence]
    if table.rows or orders:
        tables = (table,) if table.rows else ()
        yield WORDS.section("engines", tables=tables, drawings=tuple(_engines(beside)))
    yield Section(drawings=tuple(drawings(main, own)))


def laws_table(own: OwnEvidence) -> Table:
    """Return alpha and angles under both laws, and how far the force is apart, height by height."""
    assert own.impulses is not None
    frame = own.impulses
    forces = {c.run.tower.height: c.force for c in own.different_law}
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
    return WORDS.table(
        "Both laws", rows, (0, *range(2, 7)), stiffness=power(stiffness), speed=speed
    )


def towers_table(beside: Sequence[CodeEvidence]) -> Table:
    """Return the errors of engines at each height, and the order of the error in the step."""
    towers = [tower for one in beside for tower in one.towers]
    heights = sorted({tower.height for tower in towers})
    by_engine = {(t.engine, t.height): t for t in towers}
    orders = {found.solver: found.l2_order for one in beside for found in one.convergence}
    rows = []
    for engine in dict.fromkeys(tower.engine for tower in towers):
        cells, steps = [], 0.0
        for height in heights:
            tower = by_engine.get((engine, height))
            errors = () if tower is None else (tower.peak_error, tower.impulse_error)
            known = [abs(error) for error in errors if not math.isnan(error)]
            cells.append(f"{max(known):.1e}" if known else "")
            steps = tower.steps_per_contact if tower else steps
        order = orders.get(engine)
        told = "" if order is None or math.isnan(order.value) else f"{order.value:.2f}"
        rows.append((engine, f"{steps:.0f}", *cells, told))
    return Table(
        "Towers",
        "Towers under the overlap law: the larger of the relative errors of peak force and "
        "turnaround impulse (recorded: peak force alone) against the exact propagator, and the "
        "order of the force error in the step.",
        ("engine", "steps", *(f"n = {height}" for height in heights), "order"),
        tuple(rows),
        frozenset(range(1, len(heights) + 3)),
    )


def _engines(beside: Sequence[CodeEvidence]) -> Iterator[Drawing]:
    """Yield the figure of engines beside one another."""
    from harness.cases.tower.figures.engines import tower_error_against_step

    convergence = [found for one in beside for found in one.convergence]
    if convergence:
        yield WORDS.drawing("engines-tower-error", lambda: tower_error_against_step(convergence))
