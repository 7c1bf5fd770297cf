"""The tower in the main engine and in the solvers, against the exact propagator.

Law by law: force, impulse, contacts, order of the error, alpha(n). Without an engine: the chain
solvers, how far the laws lie apart, tables of impulses. Tolerances and their reasons are in
``case.toml``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from scipy.special import jn_zeros

from harness.cases.contract import LevelName
from harness.cases.grain import run_or_raise
from harness.cases.text import tolerances_of
from harness.cases.tower.comparison import (
    SeriesComparison,
    StepConvergence,
    compare,
    step_convergence,
)
from harness.cases.tower.impulse import (
    STATE_POINTS,
    energy_scaling_angles,
    impulse_angles,
    impulse_by_gamma,
)
from harness.cases.tower.run import (
    DURATION,
    LEAST_FORCE,
    NAME,
    force_comparison,
    of_ratio,
    ratio_records,
    record_name,
    run_towers,
    tower,
    tower_record,
)
from harness.cases.tower.system import job_of, timing_of
from harness.cases.verification import Part, Study, asked, planned_in, rows_of_parts
from harness.comparison.series import Comparison
from harness.comparison.verdicts import (
    Check,
    Kind,
    Planned,
    Tolerance,
    finding,
    judge,
    not_tested,
    of_divergence,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.tower import TowerRun, first_contact_end, impulse, impulse_until
from harness.parameters.tower import LAWS, Law, Tower
from harness.shown import Record
from harness.theory.chain import (
    contact_time,
    contact_time_on_fixed,
    final_velocities,
    grain_velocity,
    impulse_on_fixed,
    peak_overlap,
)

_TOLD = tolerances_of(__file__)

FINAL_VELOCITY = _TOLD["FINAL_VELOCITY"]
CLOSED_FORM = _TOLD["CLOSED_FORM"]
CONTACT_CHANGES = _TOLD["CONTACT_CHANGES"]
IMPULSE = _TOLD["IMPULSE"]
IMPULSE_RATIO = _TOLD["IMPULSE_RATIO"]
TALL_TOWER = _TOLD["TALL_TOWER"]
ORDER = _TOLD["ORDER"]
FINEST = _TOLD["FINEST"]
FORCE: dict[Law, Tolerance] = {law: _TOLD[f"FORCE_{law}"] for law in LAWS}


GAMMAS = tuple(float(gamma) for gamma in np.geomspace(1e-4, 0.3, 25))
"""From stiff and fast to soft and slow: the source's six runs lie between 0.0008 and 0.016."""

FINEST_STEPS = 10_000.0
"""Steps per contact time of the towers of engines beside the main one."""

ORDER_HEIGHT = 4
"""Height of the tower whose error is measured over a ladder of steps, in those engines."""

LADDER = tuple(250.0 * 2.0 ** (i / 2) for i in range(7))
"""Steps per contact time over which the order of an engine's error is measured."""

OWN_LADDER = tuple(125.0 * 2.0 ** (i / 4) for i in range(25))
"""Those of RK4, whose errors scatter more: of fourth order but where a contact changes."""


@dataclass(frozen=True)
class Level:
    """Heights of the towers, of those in engines beside the main one, and Gammas of alpha's map."""

    heights: tuple[int, ...]
    other_heights: tuple[int, ...]
    gammas: tuple[float, ...]
    chain_figures: bool = True


LEVELS: dict[LevelName, Level] = {
    "quick": Level((1, 2, 19), (1, 4, 19), (), chain_figures=False),
    "default": Level((1, 2, 3, 10, 19), (1, 2, 4, 9, 19), GAMMAS[::3]),
    "full": Level(tuple(range(1, 20)), (1, 2, 4, 9, 19), GAMMAS),
}


Curve = tuple[list[float], list[float]]
"""Abscissae and ordinates of one line of a figure."""


@dataclass(frozen=True)
class EngineTower(Record):
    """Peak force [N] and turnaround impulse [N s] of a tower, beside the exact propagator's."""

    engine: str
    height: int
    steps_per_contact: float
    peak_force: float
    exact_peak_force: float
    impulse: float
    exact_impulse: float

    JSON: ClassVar = {
        "engine": "engine",
        "height": "height",
        "steps_per_contact": "steps_per_contact",
        "peak_force_N": "peak_force",
        "peak_force_relative_error": "peak_error",
        "impulse_Ns": "impulse",
        "impulse_relative_error": "impulse_error",
    }

    @property
    def peak_error(self) -> float:
        """Return the relative error of the peak force."""
        return self.peak_force / self.exact_peak_force - 1.0

    @property
    def impulse_error(self) -> float:
        """Return the relative error of the impulse."""
        return self.impulse / self.exact_impulse - 1.0


@dataclass
class CodeEvidence:
    """Runs of one code held against the exact propagator.

    ``title`` is the code as reports write it. ``same_law`` maps a law to comparisons of forces;
    ``convergence`` are errors over refined steps; ``towers`` are peak forces and impulses of an
    engine beside the main one.
    """

    title: str = ""
    same_law: dict[str, list[SeriesComparison]] = field(default_factory=dict)
    convergence: list[StepConvergence] = field(default_factory=list)
    towers: list[EngineTower] = field(default_factory=list)


@dataclass
class OwnEvidence(CodeEvidence):
    """Runs of chain and tower by the harness's own solvers.

    ``collisions`` are free chains of two and three particles, with profiles; ``by_law`` the towers
    of each law; ``collapse`` one tower over stiffnesses; ``drifts`` one tower over solvers and
    steps. The peak errors are relative, over the step [1/omega] and over the stiffness [N/m].
    ``different_law`` holds the laws against each other; ``impulses``, ``by_gamma``,
    ``by_state_point`` (the same Gamma at different stiffness, mass and gravity) and ``scaling``
    are the tables of alpha(n) and the critical angle.
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
    by_state_point: pd.DataFrame | None = None
    scaling: pd.DataFrame | None = None


PARTICLES = (2, 3, 10, 20)
"""The towers of the source's figure."""

STIFFNESSES = (1e5, 1e6, 1e7)
PAIR = Tower(height=1, base="free", gravity=0.0)
"""Two free particles: harmonic, so that every error is the integrator's."""

PARTED = 1.6  # [t0] by then two and three free particles have parted for good


def chain_evidence(evidence: OwnEvidence) -> list[Check]:
    """Fill in what the chain solvers alone can show; return no rows."""
    evidence.collisions = [
        tower(PAIR.replace(height=n), solver="exact", duration=PARTED, profiles=True)
        for n in (1, 2)
    ]
    evidence.by_law = {
        law: [tower(Tower(height=n - 1, law=law), solver="exact", profiles=True) for n in PARTICLES]
        for law in LAWS
    }
    evidence.collapse = [
        tower(Tower(height=9, stiffness=k), solver="exact", samples=1500) for k in STIFFNESSES
    ]
    evidence.drifts = [
        tower(Tower(height=9, law=law), solver="rk4", steps_per_contact=steps)
        for law in LAWS
        for steps in (1000.0, 4000.0)
    ] + [tower(Tower(height=9), solver="exact")]
    _peak_errors(evidence)
    return []


def _peak_errors(evidence: OwnEvidence) -> None:
    """Measure the peak deformation of two particles by RK4, at its time and off the samples."""
    counts = [20.0 * 2.0 ** (i / 2) for i in range(9)]
    evidence.peak_by_step = {
        "at the time of the peak": _transposed([_at_the_peak(PAIR, n) for n in counts]),
        "largest sample": _transposed([_largest_sample(PAIR, n) for n in counts]),
    }
    stiffnesses = [10.0**exponent for exponent in (2.0, 3.0, 4.0, 5.0, 6.0)]
    evidence.peak_by_stiffness = {
        "step in contact times (50)": error_over_stiffness(stiffnesses, lambda _: 50.0),
        "one step for all, 1e-4 s": error_over_stiffness(
            stiffnesses, lambda case: case.contact_period / 1e-4
        ),
    }


def _transposed(points: list[tuple[float, float]]) -> Curve:
    return [x for x, _ in points], [y for _, y in points]


def error_over_stiffness(
    stiffnesses: list[float], steps_per_contact: Callable[[Tower], float]
) -> Curve:
    """Return the relative error [1] of the largest sample of two free particles over k [N/m]."""
    cases = [PAIR.replace(stiffness=stiffness) for stiffness in stiffnesses]
    return stiffnesses, [_largest_sample(case, steps_per_contact(case))[1] for case in cases]


def _at_the_peak(case: Tower, steps_per_contact: float) -> tuple[float, float]:
    """Return omega h and the relative error after half the contact, at the largest overlap."""
    half = contact_time(_value(case, "mass"), _value(case, "stiffness")) / 2
    run = tower(
        case, solver="rk4", duration=half / case.contact_time, steps_per_contact=steps_per_contact
    )
    return _omega_h(run), abs(float(run.compression[-1]) / _peak(case) - 1.0)


def _largest_sample(case: Tower, steps_per_contact: float) -> tuple[float, float]:
    """Return omega h and the relative error of the largest of all steps."""
    run = tower(
        case, solver="rk4", duration=1.0, steps_per_contact=steps_per_contact, samples=100_000
    )
    return _omega_h(run), abs(float(run.compression.max()) / _peak(case) - 1.0)


def _omega_h(run: TowerRun) -> float:
    """Return the step in 1/omega; it was made to divide the duration."""
    assert run.step is not None
    return run.step * run.tower.omega


def _peak(case: Tower) -> float:
    return peak_overlap(_value(case, "mass"), _value(case, "stiffness"), case.speed)


def _value(case: Tower, name: str) -> float:
    value = getattr(case, name)
    return float(value)


SHOWN = 2
"""Height whose force series the report shows: three particles, the source's example."""


HELD = (
    "force, largest difference over the peak",
    "impulse to the turnaround",
    "contact changes, largest time difference",
)
"""What is held against the exact run of a tower."""


def _law_name(code: str, law: Law) -> str:
    return f"tower: {code}, {law} law"


def _name(code: str, law: Law, height: int) -> str:
    return f"{_law_name(code, law)}, n = {height}"


def _order_name(code: str, law: Law) -> str:
    return f"{_law_name(code, law)}: order of the force error in the step, n = {SHOWN + 1}"


def _tall_name(code: str) -> str:
    return f"chain: first-contact impulse ratio of a tall tower, {code}"


def _ratio_name(code: str, height: int) -> str:
    return f"tower: impulse ratio alpha({height}), overlap law, {code}"


def against_exact(
    run: TowerRun,
    exact: TowerRun,
    evidence: CodeEvidence,
    divergences: list[Comparison],
    code: str = "",
) -> list[Check]:
    """Return the rows of a run against the exact one of the same tower, both with profiles.

    They are of a ``code``, the run's own unless given.
    A force that left its tolerance is added to ``divergences``.
    """
    comparison = compare(run, exact, least_force=LEAST_FORCE)
    if run.tower.height == SHOWN:
        evidence.same_law.setdefault(run.tower.law, []).append(comparison)
    name = _name(code or run.solver, run.tower.law, run.tower.height)
    width = FORCE[run.tower.law]
    series = force_comparison(name, comparison, width.width(0.0))
    triage = ""
    if series.divergence is not None:
        divergences.append(series)
        triage = of_divergence(series.divergence)
    return [
        judge(
            f"{name}: {HELD[0]}",
            Kind.CROSS_CODE,
            comparison.force.peak,
            0.0,
            width,
            triage=triage,
        ),
        judge(
            f"{name}: {HELD[1]}",
            Kind.CROSS_CODE,
            impulse(run),
            impulse(exact),
            IMPULSE,
            triage=triage,
        ),
        _events(name, comparison, triage),
    ]


def _events(name: str, comparison: SeriesComparison, triage: str) -> Check:
    """Hold the onsets and breaks of contacts against those of the exact run, one by one."""
    t0 = comparison.run.tower.contact_time
    alone = len(comparison.unmatched)
    return judge(
        f"{name}: {HELD[2]}",
        Kind.CROSS_CODE,
        math.inf if alone else comparison.largest_event_difference / t0,
        0.0,
        CONTACT_CHANGES,
        note=f"{alone} of {len(comparison.events)} have no counterpart" if alone else "",
        triage=triage,
    )


def exact_run(case: Tower, samples: int, study: Study, *, profiles: bool = True) -> TowerRun:
    """Return the exact run of a tower with so many samples, made once in a study."""
    make = partial(tower, case, solver="exact", samples=samples, profiles=profiles)
    return study.once((case, samples, profiles), make)


def order(
    law: Law,
    code: str,
    run: Callable[[Tower, float], TowerRun],
    ladder: Sequence[float],
    evidence: CodeEvidence,
    study: Study,
) -> Check:
    """Measure how the force error falls with the step, against second order across onsets.

    ``run`` makes the run of a tower at so many steps per contact, ``ladder`` are those to take.
    """
    case = Tower(height=SHOWN + 1, law=law)
    exact = exact_run(case, 12_000, study, profiles=False)
    convergence = step_convergence(lambda steps: run(case, steps), exact, ladder)
    evidence.convergence.append(convergence)
    low, high = convergence.l2_order.interval
    return judge(
        _order_name(code, law),
        Kind.CROSS_CODE,
        convergence.l2_order.value,
        2.0,
        ORDER,
        uncertainty=(high - low) / 2,
    )


FREE: tuple[tuple[int, Law], ...] = (
    (2, "overlap"),
    (3, "overlap"),
    (4, "overlap"),
    (3, "deformable"),
)
"""Particles and law of the free chains."""

COLLAPSED = (1, 2, 3, 5, 10)
"""Heights whose impulse ratio is shown to depend on Gamma alone."""

APART = (1, 2, 9, 19)
"""Heights at which the laws are held against each other."""

ANGLES = (2, 3, 19)
"""Heights whose critical angle is told under both laws."""


def own_findings(study: Study) -> Findings:
    """Return the rows, records and evidence of the harness's own solvers.

    A part that goes wrong becomes a failed row; the other parts go on.
    """
    level, findings = LEVELS[study.level], Findings(NAME, evidence=OwnEvidence("RK4"))
    parts = [Part("chain solvers", chain_checks)]
    if level.chain_figures:
        parts.append(Part("chain figures", partial(chain_evidence, findings.evidence)))
    parts += [Part(f"rk4, {law} law", partial(_same_law, law, study, findings)) for law in LAWS]
    parts += [
        Part("laws apart", partial(_laws_apart, findings.evidence)),
        Part("impulse table, exact", partial(_impulses, level, findings)),
    ]
    findings.checks += rows_of_parts(NAME, parts)
    return findings


def _same_law(law: Law, study: Study, findings: Findings) -> list[Check]:
    """Hold RK4 against the exact propagator, and keep the records of both."""
    rows: list[Check] = []
    for height in LEVELS[study.level].heights:
        case = Tower(height=height, law=law)
        timing = timing_of(case, DURATION, None, None)
        # samples where an engine has them by default
        exact = exact_run(case, timing.steps // timing.every, study)
        rk4 = tower(case, solver="rk4", profiles=True)
        findings.records += [tower_record(exact), tower_record(rk4)]
        rows += against_exact(rk4, exact, findings.evidence, findings.divergences)

    def stepped(case: Tower, steps: float) -> TowerRun:
        return tower(case, solver="rk4", steps_per_contact=steps)

    return [*rows, order(law, "rk4", stepped, OWN_LADDER, findings.evidence, study)]


def _laws_apart(evidence: OwnEvidence) -> list[Check]:
    """Report how far the laws are apart, both by the exact propagator."""
    rows = []
    for height in APART:
        deformable, overlap = (
            tower(Tower(height=height, law=law), solver="exact", profiles=True)
            for law in ("deformable", "overlap")
        )
        comparison = compare(deformable, overlap, across_laws=True)
        evidence.different_law.append(comparison)
        alone = "; equal for one contact by construction" if height == 1 else ""
        rows.append(
            finding(
                f"laws: largest difference of the force over the peak, n = {height}",
                comparison.force.peak,
                0.0,
                "",
                f"deformable against overlap law, exact{alone}",
            )
        )
    return rows


def _impulses(level: Level, findings: Findings) -> list[Check]:
    """Make the tables of alpha(n), and report what the law does to the critical angle."""
    evidence: OwnEvidence = findings.evidence
    evidence.impulses = impulse_angles(solver="exact")
    evidence.scaling = energy_scaling_angles()
    if level.gammas:
        evidence.by_gamma = impulse_by_gamma(level.gammas, solver="exact")
        evidence.by_state_point = impulse_by_gamma(
            level.gammas[::2], heights=COLLAPSED, ways=STATE_POINTS, solver="exact"
        )
    findings.records += ratio_records(evidence.impulses, None, level.heights)
    return [_law_and_angle(evidence.impulses, height) for height in ANGLES]


def _law_and_angle(frame: Any, height: int) -> Check:
    """Report the critical angle of both laws at one height, k = 1e6 N/m and 2 m/s."""
    chosen = of_ratio(frame[frame["height"] == height]).set_index("law")
    angles, ratios = chosen["critical_angle_deg"], chosen["impulse_ratio"]
    return finding(
        f"laws: critical angle at height {height}, deformable against overlap",
        float(angles["deformable"]),
        float(angles["overlap"]),
        "deg",
        f"alpha = {ratios['deformable']:.4f} (deformable), {ratios['overlap']:.4f} (overlap); "
        "turnaround window, velocity lost rescaled",
    )


def chain_checks() -> list[Check]:
    """Return the checks of the exact propagator against closed forms."""
    free = (_free_chain(n, law) for n, law in FREE)
    return [*_grain_on_one(), *free, bessel(CLOSED_FORM)]


def _grain_on_one() -> list[Check]:
    case = Tower(height=1)
    impact = (1.0, 1e6, case.speed, case.gravity)
    run = tower(case, solver="exact")
    end = first_contact_end(run)
    rows = [
        ("contact time of a grain on one particle, s", end, contact_time_on_fixed(*impact)),
        ("its impulse, N s", impulse_until(run, end), impulse_on_fixed(*impact)),
    ]
    width = CLOSED_FORM
    return [
        judge(f"chain: {name}", Kind.ANALYTIC, value, expected, width)
        for name, value, expected in rows
    ]


def _free_chain(particles: int, law: Law) -> Check:
    """Hold final velocities against matrix exponentials; report the one that is furthest off."""
    case = Tower(height=particles - 1, law=law, base="free", gravity=0.0, speed=1.0)
    run = tower(case, solver="exact", duration=float(4 * particles))
    expected = final_velocities(particles, deformable=law == "deformable")
    worst = int(np.argmax(np.abs(run.final_velocity - expected)))
    return judge(
        f"chain: {particles} free particles, {law} law, final velocity of particle {worst + 1}",
        Kind.ANALYTIC,
        float(run.final_velocity[worst]),
        float(expected[worst]),
        FINAL_VELOCITY,
    )


def bessel(width: Tolerance, engine: Engine | None = None) -> Check:
    """Hold the first-contact impulse ratio of a tall tower against the semi-infinite chain.

    By the exact propagator unless an engine is given. The wave takes about a contact to pass one
    particle, so that a base forty particles away is not felt before the grain leaves.
    """
    case = Tower(height=40, law="overlap", gravity=0.0)
    solver = "exact" if engine is None else engine.name
    run = tower(case, solver=solver, samples=6000, engine=engine)
    ratio = impulse_until(run, first_contact_end(run)) / (2.0 * case.speed)
    leaves = float(jn_zeros(2, 1)[0])
    expected = (1.0 - float(grain_velocity(leaves))) / 2.0
    return judge(
        _tall_name(solver),
        Kind.ANALYTIC,
        ratio,
        expected,
        width,
    )


def engine_findings(engine: Engine, study: Study) -> Findings:
    """Run the towers in an engine and return their rows, records and evidence.

    A part that goes wrong becomes a failed row; the other parts go on. A law that the engine
    refuses is not tested, with its reason.
    """
    findings = Findings(NAME, engine.name, evidence=CodeEvidence(engine.title))
    for part in _parts(engine, study, findings):
        findings.checks += rows_of_parts(NAME, [asked(part)])
    return findings


def planned(level: LevelName, engine: Engine) -> list[Planned]:
    """Return the checks of a level for an engine; one for each law that it refuses."""
    return planned_in(_parts(engine, Study(level), Findings(NAME)))


def _parts(engine: Engine, study: Study, findings: Findings) -> Iterator[Part]:
    """Yield three rows for each height and an order for a law; one where it is refused.

    The overlap law has an impulse ratio for each height too, and the tall tower.
    """
    heights, code = LEVELS[study.level].heights, engine.name
    reasons = {law: refusal(engine, Tower(height=2, law=law)) for law in LAWS}
    for law in sorted(LAWS, key=lambda law: not reasons[law]):
        reason = reasons[law]
        run = partial(_refused if reason else _engine_under_same_law, law, engine, study, findings)
        rows = [f"{_name(code, law, n)}: {held}" for n in heights for held in HELD]
        names = (_law_name(code, law),) if reason else (*rows, _order_name(code, law))
        yield Part(f"{law} law", run, names)
    if not reasons["overlap"]:
        tall = partial(_engine_impulses, engine, study, findings)
        yield Part("tall tower", lambda: [bessel(TALL_TOWER, engine)], (_tall_name(code),))
        yield Part("impulse table", tall, tuple(_ratio_name(code, n) for n in heights))


def _refused(law: Law, engine: Engine, _: Study, findings: Findings) -> list[Check]:
    reason, name = refusal(engine, Tower(height=2, law=law)), _law_name(engine.name, law)
    findings.untested[f"{engine.name}/*-{law}-*"] = reason
    return [not_tested(name, Kind.CROSS_CODE, reason)]


def refusal(engine: Engine, case: Tower) -> str:
    """Return why an engine cannot run a tower, or nothing where it can."""
    return engine.refuses(job_of(case, timing_of(case, DURATION, None, None)))


def _engine_under_same_law(
    law: Law, engine: Engine, study: Study, findings: Findings
) -> list[Check]:
    """Hold force series and impulse against the exact ones, and measure the order of the error."""
    stage, heights = f"tower, {law} law", LEVELS[study.level].heights
    cases = [Tower(height=height, law=law) for height in heights]
    rows: list[Check] = []
    runs = run_towers(engine, cases, DURATION, profiles=True)
    for number, (case, run) in enumerate(zip(cases, runs, strict=True), 1):
        name = f"{engine.name}, {law} law, n = {case.height}"
        rows += rows_of_parts(
            NAME, [asked(Part(name, partial(_run_rows, case, run, study, findings)))]
        )
        if isinstance(run, EngineError):
            findings.errors[record_name(case, engine.name)] = run
        study.progress(stage, number, len(heights) + 1)

    def stepped(case: Tower, steps: float) -> TowerRun:
        return tower(case, steps_per_contact=steps, engine=engine)

    rows.append(order(law, engine.name, stepped, LADDER, findings.evidence, study))
    study.progress(stage, len(heights) + 1, len(heights) + 1)
    return rows


def _run_rows(
    case: Tower, run: TowerRun | EngineError, study: Study, findings: Findings
) -> list[Check]:
    """Keep the record of a run and return its rows."""
    run = run_or_raise(run)
    # samples at the same times: nothing needs to be interpolated
    exact = exact_run(case, run.time.size - 1, study)
    findings.records.append(tower_record(run))
    return against_exact(run, exact, findings.evidence, findings.divergences, findings.engine)


def _engine_impulses(engine: Engine, study: Study, findings: Findings) -> list[Check]:
    """Compare alpha(n) of the overlap law with that of the exact propagator."""
    heights = LEVELS[study.level].heights
    table = partial(
        impulse_angles, heights=heights, stiffnesses=(1e6,), speeds=(2.0,), laws=("overlap",)
    )
    ours, exact = table(engine=engine), table(solver="exact")
    findings.records += ratio_records(ours, engine.identify(), heights)
    return [
        judge(
            _ratio_name(engine.name, height),
            Kind.CROSS_CODE,
            float(here),
            float(there),
            IMPULSE_RATIO,
        )
        for height, here, there in zip(
            heights, ours["impulse_ratio"], exact["impulse_ratio"], strict=True
        )
    ]
