"""The case ``columns``: critical angles of a grain over columns of particles that give way.

They are compared with the rigid incline, the reference DEM, the limit of stiff columns, and both
readings of the source. Tolerances and their reasons are in ``case.toml``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from harness.cases.columns.system import (
    NAME,
    TEMPLATE,
    Columns,
    Inside,
    critical_angle,
    job_of,
    read,
    run_columns,
)
from harness.cases.contract import Case, LevelName, Reference
from harness.cases.display import Display
from harness.cases.grain import complete
from harness.cases.incline.angle import step_limit
from harness.cases.incline.case import CASE as INCLINE
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.searched import Search, SearchedAngle
from harness.cases.incline.system import Incline, InclineRun, Motion
from harness.cases.source_angles import READINGS, source_angles
from harness.cases.text import Words, tolerances_of
from harness.cases.verification import Part, Study, Verification, planned_in, rows_of_parts
from harness.comparison.convergence import limit
from harness.comparison.verdicts import Check, Kind, Planned, finding, judge, not_tested
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.process import cores, parallel_map
from harness.engines.reference import Reference as ReferenceDEM
from harness.engines.traits import Traits
from harness.errors import EngineOutputError
from harness.observables.row import Row
from harness.parameters.law import CONTACTS, PLASTIC, SOURCE
from harness.parameters.tower import LAWS, Law
from harness.report.sections import Section, Table
from harness.report.style import (
    BLACK,
    COLOURS,
    MARKERS,
    STYLES,
    Figure,
    label,
    legend_below,
    panels,
    power,
)
from harness.theory.chain import Reading
from harness.theory.incline import critical_angle as closed_form

_TOLD = tolerances_of(__file__)

ONE = _TOLD["ONE"]
TWO_CODES = _TOLD["TWO_CODES"]
RIGID = _TOLD["RIGID"]
FIRST_ORDER = _TOLD["FIRST_ORDER"]


STEPS = 200.0


@dataclass(frozen=True, kw_only=True)
class Angle(Row):
    """A critical angle [deg] over columns, beside the source's in both readings [deg].

    The uncertainty of elastic columns is half the range in which moving and trapped angles mix.
    """

    n: int
    law: Law
    inside: Inside
    stiffness: float  # [N/m]

    @property
    def source_deg(self) -> dict[Reading, float]:
        """Return the source's angle of each reading."""
        return source_angles(self.n, self.law)


@dataclass
class Angles:
    """The angles of a study."""

    measured: list[Angle] = field(default_factory=list)

    def of(self, **same: Any) -> list[Angle]:
        """Return the angles whose attributes have these values."""
        return [a for a in self.measured if all(getattr(a, key) == v for key, v in same.items())]

    def records(self) -> list[dict[str, Any]]:
        """Return the angles as flat JSON-ready mappings."""
        return [
            {
                **{name: getattr(angle, name) for name in ("n", "law", "inside", "stiffness")},
                "value_deg": angle.value,
                "uncertainty_deg": angle.uncertainty,
                **{f"source_{reading}_deg": v for reading, v in angle.source_deg.items()},
            }
            for angle in self.measured
        ]


HEIGHTS: dict[LevelName, tuple[int, ...]] = {
    "quick": (1, 2, 4),
    "default": (1, 2, 4, 8),
    "full": (1, 2, 4, 8, 16),
}
STIFFNESSES: dict[LevelName, tuple[float, ...]] = {
    "quick": (1e5, 1e6),
    "default": (1e4, 1e5, 1e6),
    "full": (1e5, 1e6, 1e7),
}


def damped_cases(level: LevelName) -> list[Columns]:
    """Return the columns of a level whose contacts all damp as the grain's, plastic."""
    return [
        Columns(n=n, law=law, contact=PLASTIC, stiffness=k, steps_per_contact=STEPS)
        for law in LAWS
        for k in STIFFNESSES[level]
        for n in HEIGHTS[level]
    ]


def damped_angles(cases: Sequence[Columns], engine: Engine) -> list[Angle]:
    """Return the critical angles by passage, side by side; raise the first EngineError."""

    def angle_of(case: Columns) -> Angle:
        angle = critical_angle(case, engine)
        return _angle(case, angle.value_deg, angle.uncertainty_deg)

    return parallel_map(angle_of, cases, cores())


ELASTIC: dict[LevelName, tuple[int, ...]] = {"quick": (), "default": (2, 4), "full": (2, 4, 8)}
SCAN = tuple(10.0 + 0.1 * i for i in range(11))
"""[deg] angles of elastic columns: fates mix, so that they are counted and not bisected."""


def elastic_angles(level: LevelName, engine: Engine) -> Iterator[Angle]:
    """Yield where passages over columns without dashpots turn from trapped to moving on.

    Half way between the lowest angle that moves on and the highest that is trapped, with half
    their distance and half a step of the scan.
    """
    for law in LAWS:
        for n in ELASTIC[level]:
            case = Columns(
                n=n, law=law, inside="elastic", contact=PLASTIC, stiffness=1e5,
                steps_per_contact=STEPS,
            )  # fmt: skip
            runs = complete(run_columns(engine, [case.replace(angle=a) for a in SCAN], "passage"))
            moves = [r.case.angle for r in runs if r.motion is Motion.MOVES_ON]
            trapped = [r.case.angle for r in runs if r.motion is Motion.TRAPPED]
            low, high = min(moves, default=SCAN[-1]), max(trapped, default=SCAN[0])
            step = SCAN[1] - SCAN[0]
            yield _angle(case, 0.5 * (low + high), 0.5 * (abs(high - low) + step))


def _angle(case: Columns, value: float, uncertainty: float) -> Angle:
    of = {name: getattr(case, name) for name in ("n", "law", "inside", "stiffness")}
    return Angle("critical angle", value, uncertainty, "deg", **of)


EVERY = 50
ORDERED = 1e6
"""[N/m] at which the order in the step is looked at: soft columns jitter more."""

ANGLE = 10.6
REFINED_STEPS = (100.0, 200.0, 400.0, 800.0)
RAMP: dict[LevelName, tuple[float, ...]] = {
    "quick": (),
    "default": tuple(10.0 ** (4.5 + 0.5 * i) for i in range(5)),
    "full": tuple(10.0 ** (5.0 + 0.5 * i) for i in range(5)),
}


def engine_parts(engine: Engine) -> list[Part]:
    """Return the parts that need an engine, with the names of the rows that each leaves."""
    ones = [Part("one particle", partial(_one_particle, engine), (_path_name(engine),))]
    return ones + [
        Part(
            f"{law} law",
            partial(_two_codes, engine, law),
            tuple(_margin_name(engine, law, inside) for inside in INSIDE),
        )
        for law in LAWS
    ]


INSIDE: tuple[Inside, ...] = ("damped", "elastic")


def _path_name(engine: Engine) -> str:
    return f"columns: n = 1, path over three wells as on the incline, {engine.title}"


def _margin_name(engine: Engine, law: Law, inside: Inside) -> str:
    return f"columns: n = 3, {law} law, {inside}, margin against reference DEM, {engine.title}"


def own_parts(study: Study, angles: Angles) -> list[Part]:
    """Return the parts of this package's own solvers; the angles go to ``angles``."""
    parts = [Part("angles", lambda: list(_angles(study.level, angles)))]
    if RAMP[study.level]:
        parts.append(Part("stiff columns", lambda: list(_stiff(RAMP[study.level]))))
    return parts


def _one_particle(engine: Engine) -> list[Check]:
    """Hold the path over columns of one particle against that over the incline's row."""
    case = Columns(n=1, contact=PLASTIC, steps_per_contact=100.0, stiffness=1e5, angle=ANGLE)
    row = _path_name(engine)
    reason = engine.refuses(job_of(case, "passage"))
    if reason:
        return [not_tested(row, Kind.CROSS_CODE, reason, "m")]
    case = case.replace(wells=3)
    same = {name: getattr(case, name) for name in Incline.model_fields}
    (over,) = complete(run_columns(engine, [case], "steady", every=EVERY))
    (on,) = complete(run_inclines(engine, [Incline(**same)], "steady", every=EVERY))
    return [judge(row, Kind.CROSS_CODE, _apart(over, on), 0.0, ONE)]


def _apart(run: InclineRun, other: InclineRun) -> float:
    """Return the largest distance [m] of two paths where both have samples; at least 100."""
    if run.trajectory is None or other.trajectory is None:
        raise EngineOutputError("a run left no path")
    rows = min(run.trajectory.x_m.size, other.trajectory.x_m.size)
    if rows < 100:
        raise EngineOutputError(f"the paths have {rows} samples in common: 100 are needed")
    a, b = run.trajectory, other.trajectory
    return float(np.hypot(a.x_m[:rows] - b.x_m[:rows], a.y_m[:rows] - b.y_m[:rows]).max())


def _two_codes(engine: Engine, law: Law) -> list[Check]:
    """Hold the margins of passages over three particles against the reference DEM's."""
    rows, reference = [], ReferenceDEM()
    for inside in INSIDE:
        # soft and with the source's contact: an external force costs a millisecond a step
        case = Columns(
            n=3, law=law, inside=inside, contact=SOURCE, stiffness=2e3, angle=ANGLE
        )  # fmt: skip
        row = _margin_name(engine, law, inside)
        reason = engine.refuses(job_of(case, "passage"))
        if reason:
            rows.append(not_tested(row, Kind.CROSS_CODE, reason, "m g d"))
            continue
        (theirs,) = complete(run_columns(engine, [case], "passage"))
        (ours,) = complete(run_columns(reference, [case], "passage"))
        rows.append(judge(row, Kind.CROSS_CODE, theirs.margin, ours.margin, TWO_CODES))
    return rows


def _angles(level: LevelName, angles: Angles) -> Iterator[Check]:
    """Measure the angles of a level and compare the highest columns' with the source's."""
    engine = ReferenceDEM()
    angles.measured += damped_angles(damped_cases(level), engine)
    angles.measured += elastic_angles(level, engine)
    for law in LAWS:
        for inside in INSIDE:
            at_law = angles.of(law=law, inside=inside)
            if not at_law:
                continue
            top = max(at_law, key=lambda angle: (angle.n, angle.stiffness))
            for reading, words in READINGS.items():
                yield finding(
                    f"columns: n = {top.n}, {law} law, {inside}, against the source ({words})",
                    top.value,
                    top.source_deg[reading],
                    "deg",
                    f"critical angle at k = {top.stiffness:g} N/m in the reference DEM",
                    top.uncertainty,
                )


def _stiff(stiffnesses: Sequence[float]) -> Iterator[Check]:
    """Yield the order in the step, and the limit of stiff damped columns against 10.2078 deg."""
    engine = ReferenceDEM()
    for law in LAWS:
        cases = [
            Columns(n=4, law=law, contact=PLASTIC, stiffness=k, steps_per_contact=steps)
            for k in reversed(stiffnesses)  # the costliest first
            for steps in reversed(REFINED_STEPS)
        ]
        angles = parallel_map(partial(critical_angle, engine=engine, phases=4), cases, cores())
        at = {k: step_limit([a for a in angles if a.case.stiffness == k]) for k in stiffnesses}
        row = f"columns: n = 4, {law} law, order in the step of the critical angle"
        yield judge(row, Kind.ANALYTIC, at[ORDERED].order, 1.0, FIRST_ORDER)
        rigid = limit(
            [1.0 / k for k in at],
            [result.value for result in at.values()],
            [result.uncertainty for result in at.values()],
            (0.5, 1.0, 1.5),
        )
        row = f"columns: n = 4, {law} law, damped, critical angle of stiff columns"
        yield judge(
            row, Kind.ANALYTIC, rigid.value, closed_form(), RIGID, uncertainty=rigid.uncertainty
        )


WORDS = Words(__file__)


def sections(angles: Angles) -> Sequence[Section]:
    """Return the section of the measured angles; none without any."""
    if not angles.measured:
        return ()
    drawing = WORDS.drawing("critical-angle-columns", lambda: figure(angles))
    paragraphs = finding_in_words(angles)
    return (
        WORDS.section(
            "columns", paragraphs=paragraphs, tables=(_table(angles),), drawings=(drawing,)
        ),
    )


def finding_in_words(angles: Angles) -> list[str]:
    """Compare the angles with the source's in a sentence for each law."""
    sentences = []
    for law in LAWS:
        high = [a for a in angles.of(law=law, inside="damped") if a.n > 1]
        if not high:
            continue
        least = min(high, key=lambda a: a.value)
        stiffest = max(a.stiffness for a in high)
        off = max(abs(a.value - closed_form()) for a in high if a.stiffness == stiffest)
        lost = min(a.source_deg["lost"] for a in high)
        words = (
            f"{law.capitalize()} law: the lowest angle over damped columns is "
            f"{least.value:.3f} deg (n = {least.n}, k = {power(least.stiffness)} N/m), "
            f"where the source expects {least.source_deg['lost']:.2f} deg; at k = "
            f"{power(stiffest)} N/m all are within {off:.2g} deg of the {closed_form():.4f} deg of "
            f"one sphere. "
        )
        elastic = angles.of(law=law, inside="elastic")
        if elastic:
            low, top = (f(a.value for a in elastic) for f in (min, max))
            words += f"Over elastic columns the angle is {low:.2f} to {top:.2f} deg. "
        every = [*high, *elastic]
        falls = any(a.value - a.uncertainty <= 0.5 * (lost + closed_form()) for a in every)
        sentences.append(
            words
            + (
                "Some angle falls as far as half way to the source's."
                if falls
                else f"No angle falls even half way to the source's {lost:.2f} deg: that "
                "impulses spread through a column does not lower the critical angle of this grain."
            )
        )
    return sentences


def _table(angles: Angles) -> Table:
    head = (
        "law",
        "columns",
        "n",
        "k (N/m)",
        "critical angle (deg)",
        *(f"source, {words} (deg)" for words in READINGS.values()),
    )
    rows = tuple(
        (
            angle.law,
            angle.inside,
            str(angle.n),
            power(angle.stiffness),
            _value(angle),
            *(f"{angle.source_deg[reading]:.3f}" for reading in READINGS),
        )
        for angle in angles.measured
    )
    caption = "Uncertainties of elastic columns: half the range in which fates change."
    return Table("columns", caption, head, rows)


def _value(angle: Angle) -> str:
    digits = max(1, 1 - math.floor(math.log10(max(angle.uncertainty, 1e-9))))
    return f"{angle.value:.{digits}f} ± {angle.uncertainty:.1g}"


def figure(angles: Angles) -> Figure:
    """Draw the angles over n, a panel a law."""
    drawing = panels(1, 2)
    for axes, law in zip(drawing.axes, LAWS, strict=True):
        axes.set_title(f"{law} law")
        groups = sorted({(a.inside, a.stiffness) for a in angles.of(law=law)})
        for i, (inside, k) in enumerate(groups):
            group = angles.of(law=law, inside=inside, stiffness=k)
            axes.errorbar(
                [a.n for a in group],
                [a.value for a in group],
                [a.uncertainty for a in group],
                color=COLOURS[1 + i % 6],
                marker=MARKERS[i % 6],
                linestyle="none" if inside == "elastic" else "-",
                label=f"{inside}, k = {power(k)} N/m",
            )
        heights = sorted({a.n: a for a in angles.of(law=law)}.items())
        for (reading, words), style in zip(READINGS.items(), STYLES[1:], strict=False):
            theory = [a.source_deg[reading] for _, a in heights]
            axes.plot(
                [n for n, _ in heights], theory, color=BLACK, ls=style, label=f"source, {words}"
            )
        axes.axhline(closed_form(), color="0.6", lw=0.8, label="one fixed sphere, 10.2078 deg")
        axes.set_xscale("log", base=2)
        axes.set_xticks([n for n, _ in heights], [str(n) for n, _ in heights])
        label(axes, "particles of a column, n", "critical angle (deg)")
    legend_below(drawing)
    return drawing


class ColumnsSearch(Columns, Search):
    """Columns, the angle searched for."""


class ColumnsCase(Case[Columns]):
    """The incline's grain on columns of n particles, the last one fixed: critical angle.

    The impulse between grain and column, and the waves below, are what the source explains the
    lower angle of thick layers by. Without friction every impulse on the grain stands normal to
    the sphere ahead: the half of the velocity along it survives the shock whatever the column
    does. Stiff columns that damp as the grain's contact does give nothing back, and leave the
    angle of one sphere; elastic ones give part of it back, which can only raise the angle.
    """

    name = NAME
    group = "incline"
    quantities = INCLINE.quantities
    template = TEMPLATE
    verified_by = "harness.cases.columns.case:ColumnsVerification"
    shown_by = "harness.cases.columns.case:ColumnsDisplay"

    @property
    def presets(self) -> Mapping[str, Columns]:
        """Return columns of four particles under each named contact and both laws."""
        presets = {
            f"{name}, {law}": Columns(contact=contact, law=law, steps_per_contact=100.0)
            for law in ("overlap", "deformable")
            for name, contact in CONTACTS.items()
        }
        return {"plastic": presets.pop("plastic, overlap"), **presets}

    def derived(self) -> Sequence[Case[Any]]:
        """Return the critical angle."""
        return (_ANGLE,)

    def job(self, parameters: Columns) -> Job:
        """Return the job of one passage."""
        return job_of(parameters, "passage")

    def read(self, parameters: Columns, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return what became of one passage; raise EngineOutputError for a bad output."""
        return read(parameters, "passage", output).quantities

    def references(self, parameters: Columns, traits: Traits) -> Mapping[str, Reference]:
        """Return the margin of rigid spheres; none for what rebounds."""
        rebounds = parameters.n > 1 and parameters.inside == "elastic"
        return {} if rebounds else INCLINE.references(parameters, traits)


class ColumnsVerification(Verification):
    """Holds an engine against the incline, and the reference DEM against stiff columns."""

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of the parts that need an engine."""
        return planned_in(engine_parts(engine))

    def run(self, engine: Engine, study: Study) -> Findings:
        """Hold an engine against the incline for one particle, and against the reference DEM."""
        rows = rows_of_parts(NAME, engine_parts(engine))
        return Findings(NAME, engine.name, rows)

    def run_solvers(self, study: Study) -> Findings:
        """Hold the reference DEM against the limit of stiff columns; find the angles."""
        angles = Angles()
        rows = rows_of_parts(NAME, own_parts(study, angles), "deg")
        records = {"columns": angles.records()}
        return Findings(NAME, checks=rows, evidence=angles, published=records)


class ColumnsDisplay(Display):
    """Shows the critical angle against the height of the columns."""

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the critical angle against the height of the columns."""
        return sections(solvers.evidence)


CASE = ColumnsCase()
_ANGLE = SearchedAngle(CASE, ColumnsSearch, job_of, critical_angle)
