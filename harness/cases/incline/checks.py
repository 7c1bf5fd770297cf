"""Checks of the incline at single angles, of the closed forms, and of restitution.

Closed forms are held against second routes, the adaptive reference DEM against one of them, an
engine's runs against theory and against themselves, and rigid spheres by events against the
reference DEM as it stiffens.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.cases.contract import Measured
from harness.cases.grain import COLUMNS, complete, run_or_raise
from harness.cases.incline.angle import (
    CriticalAngle,
    ExtrapolatedAngle,
    critical_angle,
    critical_angle_or_error,
    critical_angles,
    step_limit,
)
from harness.cases.incline.closed_forms import PASSAGES, rebound
from harness.cases.incline.engine_checks import reference_for
from harness.cases.incline.levels import (
    ADAPTIVE_RESTITUTION,
    ALL_WELLS,
    CLOSED_FORM,
    LEVELS,
    RIGID,
    SCALES,
    SOURCE_CASE,
    TWO_WAYS,
    Level,
)
from harness.cases.incline.runs import follow, measured, run_inclines
from harness.cases.incline.system import NAME, Incline, InclineRun, Route, Start, job_of
from harness.cases.text import Words
from harness.cases.verification import Part, Study
from harness.comparison.convergence import Limit, limit
from harness.comparison.regression import BaselineRecord, made_by
from harness.comparison.series import Series
from harness.comparison.verdicts import (
    Check,
    Kind,
    Tolerance,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.engines.reference import Reference
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.observables.row import Row, by_name
from harness.parameters.law import CONTACTS, PLASTIC, Contact
from harness.report.sections import Section, Table
from harness.report.style import BLUE, GREEN, ORANGE, RED, Figure, label, legend_below
from harness.solvers.hard_sphere import MOVES_ON, passage
from harness.solvers.hard_sphere import critical_angle as rigid_angle
from harness.theory import incline
from harness.theory.chain import SHOCK_WITHOUT_REBOUND, Reading, shock_from_restitution
from harness.theory.contact import restitution_unclipped
from harness.theory.incline import STATIC_ANGLE_DEG, no_flight_bound
from harness.theory.incline import critical_angle as closed_form_angle

NOT_OF_AN_ANGLE = {"angle", "phase"}
"""What a search for the critical angle sets itself."""


@dataclass(frozen=True)
class Recursion:
    """Energy after each shock in a run, and by the recursion from the first; in m g d."""

    run: InclineRun
    measured: NDArray[np.float64]
    predicted: NDArray[np.float64]


@dataclass
class InclineEvidence:
    """What the main engine's runs of the incline gave.

    ``engine_title`` is the engine as reports write it. ``by_contact`` maps the name of a contact
    to its angles over stiffness and step.
    """

    engine_title: str
    closed_form_deg: float
    extrapolated: ExtrapolatedAngle | None = None
    by_contact: dict[str, list[CriticalAngle]] = field(default_factory=dict)
    routes: list[CriticalAngle] = field(default_factory=list)
    motions: list[InclineRun] = field(default_factory=list)
    passages: list[InclineRun] = field(default_factory=list)
    recursion: Recursion | None = None


@dataclass(frozen=True)
class Verifying:
    """An engine under verification: how much is run, and where rows, records and runs are kept."""

    engine: Engine
    study: Study
    findings: Findings
    evidence: InclineEvidence

    @property
    def level(self) -> Level:
        """Return how much is run."""
        return LEVELS[self.study.level]

    @property
    def engine_title(self) -> str:
        """Return the engine's name as reports write it."""
        return self.evidence.engine_title

    def part(
        self, name: str, run: Callable[[Verifying], Sequence[Check]], rows: Iterable[str]
    ) -> Part:
        """Return a part that leaves rows of these names at least."""
        return Part(name, partial(run, self), tuple(rows))

    def refusal(self, case: Incline, route: Route = "passage") -> str:
        """Return why the engine cannot run a case, or nothing where it can."""
        return self.engine.refuses(job_of(case, route))

    def supported(self, cases: Iterable[Incline]) -> list[Incline]:
        """Return the cases that the engine can run."""
        return [case for case in cases if not self.refusal(case)]

    def untested(
        self,
        name: str,
        case: Incline,
        route: Route = "passage",
        unit: str = "deg",
        kind: Kind = Kind.CROSS_CODE,
    ) -> list[Check]:
        """Return the row that says why the engine cannot run a case; none where it can."""
        reason = self.refusal(case, route)
        return [not_tested(name, kind, reason, unit)] if reason else []

    def angle(self, case: Incline) -> CriticalAngle | EngineError:
        """Return a critical angle by passage, measured once in a verification, or its error."""
        make = partial(critical_angle_or_error, case, engine=self.engine)
        return self.study.once((self.engine, case), make)

    def keep(
        self, cases: Sequence[Incline], angles: Sequence[CriticalAngle | EngineError], phases: int
    ) -> None:
        """Keep angles by passage as records of the baseline, and errors by their key."""
        for case, angle in zip(cases, angles, strict=True):
            if isinstance(angle, EngineError):
                name = angle_name(case, self.engine.name, "passage", in_phases(phases))
                self.findings.errors[name] = angle
            else:
                self.findings.records.append(angle_case(angle, in_phases(phases)))


def short(value: float) -> str:
    """Return a number for the name of a file: ``1e6``, ``3.16e5``, ``200``."""
    text = f"{value:.3g}" if value < 1e4 else f"{value:.3g}".replace("e+0", "e").replace("e+", "e")
    return text if "e" in text or value < 1e4 else f"{value:.2e}".replace("e+0", "e")


def in_phases(phases: int) -> str:
    """Return the resolution of a passage: over how many starts within a step it is averaged."""
    return f"{phases}-phases"


def angle_name(case: Incline, engine: str, method: str, resolution: str) -> str:
    """Return the name of a critical angle; ``resolution`` as in ``8-phases`` or ``0.001-deg``."""
    contact = case.contact.name.replace(", ", "-").replace(" ", "-")
    return (
        f"{engine}/incline-{method}-{contact}-k{short(case.stiffness)}"
        f"-{case.steps_per_contact:g}-steps-{resolution}"
    )


def angle_case(angle: CriticalAngle, resolution: str) -> BaselineRecord:
    """Return a critical angle as a record."""
    provenance = angle.provenance
    parameters = angle.case.model_dump(mode="json", exclude=NOT_OF_AN_ANGLE)
    return BaselineRecord(
        name=angle_name(angle.case, provenance.engine, angle.method, resolution),
        parameters={**parameters, "method": angle.method, "resolution": resolution},
        quantities=by_name(
            Row("critical_angle_deg", angle.value_deg, angle.uncertainty_deg, "deg")
        ),
        case=NAME,
        label=(
            f"{angle.method}, {angle.case.contact.name}, k = {short(angle.case.stiffness)} N/m, "
            f"{angle.case.steps_per_contact:g} steps, {resolution.replace('-', ' ')}"
        ),
        family=(angle.case.contact.name,),
        **made_by(provenance),
    )


def extrapolated_case(
    extrapolated: ExtrapolatedAngle, angles: list[CriticalAngle]
) -> BaselineRecord:
    """Return an extrapolated critical angle as a record, with its stiffnesses and steps."""
    first = angles[0]
    contact = first.case.contact
    levels = sorted((a.case.stiffness, a.case.steps_per_contact) for a in angles)
    fixed = {*NOT_OF_AN_ANGLE, "stiffness", "steps_per_contact"}
    return BaselineRecord(
        name=f"{first.provenance.engine}/incline-extrapolated-{contact.name}-{len(angles)}-rungs",
        parameters={
            **first.case.model_dump(mode="json", exclude=fixed),
            "stiffness_and_steps_per_contact": [list(level) for level in levels],
        },
        quantities=by_name(
            Row(
                "extrapolated_angle_deg",
                extrapolated.value_deg,
                extrapolated.uncertainty_deg,
                "deg",
            )
        ),
        case=NAME,
        label=f"extrapolated, {contact.name}, {len(angles)} rungs",
        family=(contact.name,),
        **made_by(first.provenance),
    )


def passage_name(case: Incline, engine: str) -> str:
    """Return the name of one passage at a fixed angle."""
    return f"{engine}/incline-path-{case.contact.name}-{case.angle:g}-deg"


def passage_case(run: InclineRun) -> BaselineRecord:
    """Return one passage as a case: margin, and the path as a series.

    ``step_s`` is the time over the steps at the run's end, not the step requested.
    """
    path, case = run.trajectory, run.case
    columns = {} if path is None else {name: getattr(path, name) for name in COLUMNS[1:]}
    return BaselineRecord(
        name=passage_name(case, run.provenance.engine),
        parameters=case.model_dump(mode="json"),
        quantities=by_name(
            Row("margin_over_mgd", run.margin, 0.0, ""),
            Row("step_s", run.time_s / max(run.steps, 1), 0.0, "s"),
        ),
        case=NAME,
        label=f"path, {case.contact.name}, {case.angle:g} deg",
        family=(case.contact.name,),
        series=None if path is None else Series(path.time_s, columns),
        **made_by(run.provenance),
    )


WORDS = Words(__file__)

SOLVER = "hard-sphere"
TITLE = "Restitution: rigid spheres by events"

STEPS, FINEST = (100.0, 200.0, 400.0), 400.0
STIFFNESSES = {0.1: (1e6, 1e7, 1e8, 1e9), 0.3: (1e6, 1e7, 1e8, 1e9), 0.5: (1e5, 1e6, 1e7, 1e8)}
"""[N/m] by restitution. At 0.5 the grain still hops where a passage is judged: it is measured by
steady motion, a bisection, and at the finest step, where the step is worth less than that."""

EXPONENTS = (0.5, 1.0)
"""Of 1/k: a contact lasts as k^(-1/2)."""

READING_NAMES: dict[Reading, str] = {"kept": "energy kept", "lost": "velocity lost"}


@dataclass(frozen=True)
class Stiffening:
    """Critical angles [deg] of the reference DEM at one restitution, and their limit."""

    restitution: float
    stiffnesses: tuple[float, ...]
    angles_deg: tuple[float, ...]
    rigid: Limit


def solve_rigid(case: Incline) -> Measured:
    """Return the passage of the grain over rigid spheres of the contact's restitution."""
    fate, energy, _, slid, _ = passage(case.angle, rebound(case.contact))
    moves = float(fate == MOVES_ON)
    values = {"margin_over_mgd": energy, "moves_on": moves, "touching": float(slid)}
    return Measured(values)


def rigid_checks(stiffenings: list[Stiffening]) -> Iterator[Check]:
    """Yield the reference DEM's limits against rigid spheres, and both readings of the theory.

    Append each extrapolation to the limit to ``stiffenings``.
    """
    engine = Reference()
    for e, stiffnesses in STIFFNESSES.items():
        stiffening = _stiffening(e, stiffnesses, engine)
        stiffenings.append(stiffening)
        name = f"incline: e = {e:g}, reference DEM as k goes to infinity"
        value, error, exact = stiffening.rigid.value, stiffening.rigid.uncertainty, rigid_angle(e)
        row = f"{name}, rigid spheres by events"
        yield judge(row, Kind.CROSS_CODE, value, exact, RIGID, uncertainty=error)
        for reading, words in READING_NAMES.items():
            closed = closed_form_angle(shock_from_restitution(e, reading))
            note = "the theory of one shock: the grain hops several times in a well"
            yield finding(f"{name}, one shock ({words})", value, closed, "deg", note, error)


def _stiffening(e: float, stiffnesses: Sequence[float], engine: Reference) -> Stiffening:
    contact = Contact(name=f"e = {e:g}", restitution=e)
    values, errors = [], []
    for k in stiffnesses:
        case = Incline(contact=contact, stiffness=k, steps_per_contact=FINEST)
        if e <= PASSAGES:
            cases = [case.replace(steps_per_contact=steps) for steps in STEPS]
            at = step_limit(complete(critical_angles(cases, engine)))
            values.append(at.value)
            errors.append(at.uncertainty)
        else:
            angle = critical_angle(case, method="steady", tolerance_deg=1e-3, engine=engine)
            values.append(angle.value_deg)
            errors.append(angle.uncertainty_deg)
    rigid = limit([1.0 / k for k in stiffnesses], values, errors, EXPONENTS)
    return Stiffening(e, tuple(stiffnesses), tuple(values), rigid)


def rigid_section(stiffenings: Sequence[Stiffening]) -> Section:
    """Return rigid spheres beside both readings of the theory, and the reference DEM if it ran."""
    dem = {stiffening.restitution: stiffening for stiffening in stiffenings}
    rows = []
    for e in (0.0, *STIFFNESSES):
        stiffening = dem.get(e)
        readings = (closed_form_angle(shock_from_restitution(e, r)) for r in READING_NAMES)
        measured = (
            f"{stiffening.rigid.value:.4f} ± {stiffening.rigid.uncertainty:.1g}"
            if stiffening
            else "-"
        )
        rows.append((f"{e:g}", f"{rigid_angle(e):.4f}", measured, *(f"{r:.4f}" for r in readings)))
    columns = (
        "e",
        "rigid spheres (deg)",
        "reference DEM, k to infinity (deg)",
        *(f"one shock, {words} (deg)" for words in READING_NAMES.values()),
    )
    table = Table("restitution", "", columns, tuple(rows))
    points = "; points: the reference DEM, extrapolated in the stiffness" if stiffenings else ""
    drawing = WORDS.drawing(
        "critical-angle-restitution", lambda: restitution_figure(stiffenings), dem=points
    )
    return WORDS.section("rigid", tables=(table,), drawings=(drawing,))


def restitution_figure(stiffenings: Sequence[Stiffening]) -> Figure:
    """Draw the critical angle over the restitution."""
    figure = Figure(figsize=(7.5, 4.2))
    axes = figure.add_subplot()
    e = np.linspace(0.0, 0.6, 61)
    axes.plot(e, [rigid_angle(x) for x in e], color=BLUE, label="rigid spheres, by events")
    for (reading, words), colour in zip(READING_NAMES.items(), (ORANGE, GREEN), strict=True):
        closed = [closed_form_angle(shock_from_restitution(x, reading)) for x in e]
        axes.plot(e, closed, "--", color=colour, label=f"one shock, {words}")
    for stiffening in stiffenings:
        axes.errorbar(
            stiffening.restitution,
            stiffening.rigid.value,
            stiffening.rigid.uncertainty,
            fmt="o",
            color=RED,
            label="reference DEM, k to infinity" if stiffening is stiffenings[0] else None,
        )
    label(axes, "restitution e", "critical angle (deg)")
    legend_below(figure)
    return figure


MANY_SHOCKS = 200

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None, tail="attractive")


def theory_checks() -> list[Check]:
    """Return the self-checks of the theory of the incline."""
    closed = closed_form_angle()
    pairs = [
        ("theory: root of E* = C", _root(_excess), closed),
        ("theory: iterated recursion", _by_iteration(), closed),
        ("theory: root of the passage margin", _root(_margin), closed),
        ("theory: shock from e = 0", closed_form_angle(shock_from_restitution(0.0)), closed),
        ("theory: no energy left is the static angle", closed_form_angle(0.0), STATIC_ANGLE_DEG),
        ("theory: no loss, no critical angle", closed_form_angle(1.0), 0.0),
        ("theory: contact force vanishes", _root(_contact_force), no_flight_bound()),
    ]
    return [
        judge(name, Kind.ANALYTIC, value, expected, CLOSED_FORM) for name, value, expected in pairs
    ]


def _root(function: Callable[[float], float]) -> float:
    """Return the angle [deg] at which a function of it vanishes."""
    return float(brentq(function, 1.0, 29.0, xtol=1e-13))


def _excess(angle: float) -> float:
    """Return the steady energy less the depth of a well."""
    return incline.steady_energy(angle, SHOCK_WITHOUT_REBOUND) - incline.well_depth(angle)


def _margin(angle: float) -> float:
    return incline.passage_margin(angle, SHOCK_WITHOUT_REBOUND)


def _by_iteration() -> float:
    """Bisect on the fate of a grain whose energy is taken from shock to shock."""
    trapped, moving = 1.0, 29.0
    while moving - trapped > 1e-12:
        angle = (trapped + moving) / 2
        if _keeps_moving(angle):
            moving = angle
        else:
            trapped = angle
    return (trapped + moving) / 2


def _keeps_moving(angle: float) -> bool:
    depth = incline.well_depth(angle)
    energy = 1.0
    for _ in range(MANY_SHOCKS):
        energy = incline.after_next_shock(energy, angle, SHOCK_WITHOUT_REBOUND)
        if energy < depth:
            return False
    return True


def _contact_force(angle: float) -> float:
    """Return the weight along the last normal less what bends the steady path (m g = d = 1)."""
    before = incline.steady_energy(angle, SHOCK_WITHOUT_REBOUND)
    speed_squared = 2.0 * (before + incline.gain_per_crest(angle))
    return math.cos(math.radians(30.0 + angle)) - speed_squared


def restitution_checks() -> list[Check]:
    """Hold a head-on collision of the adaptive reference against the closed form."""
    name = "reference DEM: restitution head-on, adaptive"
    case = Incline(angle=0.0, contact=HEAD_ON, gravity=1e-12)
    start = Start(0.0, case.diameter * (1.0 + 1e-6), 0.0, -1.0)
    try:
        path = follow(Reference("adaptive"), case, start, 3.0 * case.contact_time, every=150)
    except EngineError as error:
        return [failed_run(name, Kind.ANALYTIC, error)]
    return [
        judge(
            name,
            Kind.ANALYTIC,
            float(path.vy_m_per_s[-1]),
            restitution_unclipped(HEAD_ON.zeta),
            ADAPTIVE_RESTITUTION,
        )
    ]


RECURSION_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=200.0, angle=10.6)

ANGLE_DEG = 10.2
"""Just below the critical angle: the margin is small, and what moves it shows."""

EVERY = 10
"""Steps between the samples of the path."""

CASES = tuple(
    Incline(
        contact=contact,
        angle=ANGLE_DEG,
        stiffness=1e6,
        steps_per_contact=100.0 if contact is PLASTIC else 50.0,
    )
    for contact in CONTACTS.values()
)


SHOCKS = "incline: energy after each shock"
WELLS_PASSED = f"incline: wells passed at {RECURSION_CASE.angle:g} deg"
WORST_SHOCK = "incline: energy after shock"
"""Names of the rows of :func:`recursion`: where it is refused, and where it is not."""


def recursion(verifying: Verifying) -> list[Check]:
    """Hold the energy after each shock against E[j+1] = (E[j] + dE) / 4 from the first one.

    All wells must be passed.
    """
    case, evidence = RECURSION_CASE, verifying.evidence
    untested = verifying.untested(SHOCKS, case, "steady", "m g d", Kind.ANALYTIC)
    if untested:
        return untested
    run = measured(verifying.engine, [case], "steady")[0]
    energies = run.crests.margin_J / case.weight_energy + incline.well_depth(case.angle)
    rows = [judge(WELLS_PASSED, Kind.ANALYTIC, float(len(energies)), float(case.wells), ALL_WELLS)]
    if len(energies) < 2:
        return rows
    later = incline.energies(
        float(energies[0]), len(energies) - 1, case.angle, SHOCK_WITHOUT_REBOUND
    )
    predicted = np.concatenate([energies[:1], later])
    evidence.recursion = Recursion(run, energies, predicted)
    worst = int(np.argmax(np.abs(energies - predicted)))
    rows.append(
        judge(
            f"{WORST_SHOCK} {worst + 1}, the worst of {len(energies)}",
            Kind.ANALYTIC,
            float(energies[worst]),
            float(predicted[worst]),
            _tolerance(verifying.engine.traits, evidence.closed_form_deg),
        )
    )
    return rows


def _tolerance(traits: Traits, closed_form: float) -> Tolerance:
    """Return what stiffness and step are worth in energy: by the reference DEM at the same ones.

    Not by the engine that is judged, whose fault would widen it.
    """
    reference = reference_for(traits) or Reference()
    angle = critical_angle(RECURSION_CASE, engine=reference)
    off = abs(angle.value_deg - closed_form) + angle.uncertainty_deg
    slope = incline.passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    # a geometric sum of such errors, each passed on with 1/4, is 4/3 of one; the shock
    # at this angle is up to half as strong again as at the critical one
    return Tolerance(
        "m g d",
        2.0 * off * slope,
        0.0,
        "bias and jitter of the passage route at this stiffness and step in the reference DEM, "
        "as an energy, times 2",
    )


SCALED = (
    "incline: scale invariance, 3 mm glass",
    "incline: scale invariance, lunar gravity",
)


def scales(verifying: Verifying) -> list[Check]:
    """Hold critical angles at the same k d/(m g) in other units against one another."""
    base, rows = SOURCE_CASE, []
    glass = base.replace(diameter=3e-3, density=2500.0, stiffness=1.0e6)
    others = [_same_rigidity(scaled, base) for scaled in (glass, base.replace(gravity=1.62))]
    for number, (row, case) in enumerate(zip(SCALED, others, strict=True), 1):
        rows += verifying.untested(row, base) or [_scaled(verifying, row, case, base)]
        verifying.study.progress("scale invariance", number, len(others))
    return rows


def _scaled(verifying: Verifying, row: str, case: Incline, base: Incline) -> Check:
    reference = run_or_raise(verifying.angle(base))
    angle = critical_angle(case, engine=verifying.engine)
    value, uncertainty = angle.value_deg, angle.uncertainty_deg
    return judge(row, Kind.CROSS_CODE, value, reference.value_deg, SCALES, uncertainty=uncertainty)


def _same_rigidity(case: Incline, base: Incline) -> Incline:
    """Return a case with the stiffness that keeps k d / (m g) of the base."""
    return case.replace(stiffness=case.mass * case.gravity / (base.static_overlap * case.diameter))


WAYS_TO_RUN = "incline: in-process against executable, energy margin"


def two_ways(verifying: Verifying) -> list[Check]:
    """Compare an in-process run with one of the executable of the same installation."""
    name = WAYS_TO_RUN
    case = SOURCE_CASE.replace(angle=10.0)
    refused = verifying.refusal(case)
    try:
        twin = None if refused else verifying.engine.twin()
        if twin is None:
            reason = refused or f"{verifying.engine_title} has no other way to be run here"
            return [not_tested(name, Kind.CROSS_CODE, reason, "J")]
        with twin:
            other = measured(twin, [case], "passage")[0]
    except (EngineMissingError, RequestError) as error:
        return [not_tested(name, Kind.CROSS_CODE, str(error), "J")]
    run = measured(verifying.engine, [case], "passage")[0]
    return [judge(name, Kind.CROSS_CODE, run.margin_J, other.margin_J, TWO_WAYS)]


def passages(verifying: Verifying) -> list[Check]:
    """Run the passages for the baseline; return a row for each that failed or is not supported.

    They are the most sensitive runs: a critical angle is a root and hides small changes, the
    energy margin and the path of one run are the same to the last bit every time.
    """
    engine, cases = verifying.engine, verifying.supported(CASES)
    rows = [row for case in CASES for row in verifying.untested(passage_row(case), case, unit="")]
    for case, run in zip(cases, run_inclines(engine, cases, "passage", every=EVERY), strict=True):
        if isinstance(run, EngineError):
            verifying.findings.errors[passage_name(case, engine.name)] = run
            rows.append(failed_run(passage_row(case), Kind.CROSS_CODE, run))
        else:
            verifying.findings.records.append(passage_case(run))
            verifying.evidence.passages.append(run)
    return rows


def passage_row(case: Incline) -> str:
    """Return what rows call the passage of a contact."""
    return f"incline: {case.contact.name} contact, passage at {case.angle:g} deg"
