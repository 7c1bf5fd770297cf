"""The tower in the main engine: against the exact propagator law by law, and alpha(n)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from harness.cases.contract import LevelName, Study
from harness.cases.parts import Part, asked, rows_of_parts
from harness.cases.runs import whole
from harness.cases.tower import tolerances
from harness.cases.tower.against_exact import against_exact, exact_run, order
from harness.cases.tower.engine_runs import run_towers
from harness.cases.tower.evidence import CodeEvidence
from harness.cases.tower.impulse_angles import impulse_angles
from harness.cases.tower.levels import LADDER, LEVELS
from harness.cases.tower.own_checks import bessel
from harness.cases.tower.records import NAME, ratio_records, record_name, tower_record
from harness.cases.tower.run import DURATION, tower
from harness.cases.tower.template import job_of
from harness.cases.tower.timing import timing_of
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, Kind, judge, not_tested
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.tower import TowerRun
from harness.parameters.tower import LAWS, Law, Tower


def engine_findings(engine: Engine, study: Study) -> Findings:
    """Run the towers in an engine and return their rows, records and evidence.

    A part that goes wrong becomes a failed row; the other parts go on. A law that the engine
    refuses is not tested, with its reason.
    """
    found = Findings(NAME, engine.name, evidence=CodeEvidence(engine.title))
    for part in _parts(engine, study, found):
        found.checks += rows_of_parts(NAME, [asked(part)])
    return found


def expected_rows(level: LevelName, engine: Engine) -> int:
    """Return how many rows a level leaves for an engine; one for each law that it refuses."""
    return sum(part.rows for part in _parts(engine, Study(level), Findings(NAME)))


def _parts(engine: Engine, study: Study, found: Findings) -> Iterator[Part]:
    """Yield three rows for each height and an order for a law; one where it is refused.

    The overlap law has an impulse ratio for each height too, and the tall tower.
    """
    heights = len(LEVELS[study.level].heights)
    reasons = {law: refusal(engine, Tower(height=2, law=law)) for law in LAWS}
    for law in sorted(LAWS, key=lambda law: not reasons[law]):
        reason = reasons[law]
        run = partial(_refused if reason else _same_law, law, engine, study, found)
        yield Part(f"{law} law", run, 1 if reason else 3 * heights + 1)
    if not reasons["overlap"]:
        yield Part("tall tower", lambda: [bessel(tolerances.TALL_TOWER, engine)], 1)
        yield Part("impulse table", partial(_impulses, engine, study, found), heights)


def _refused(law: Law, engine: Engine, _: Study, found: Findings) -> list[Check]:
    reason, name = refusal(engine, Tower(height=2, law=law)), f"tower: {engine.name}, {law} law"
    found.untested[f"{engine.name}/*-{law}-*"] = reason
    return [not_tested(name, Kind.CROSS_CODE, reason)]


def refusal(engine: Engine, case: Tower) -> str:
    """Return why an engine cannot run a tower, or nothing where it can."""
    return engine.refuses(job_of(case, timing_of(case, DURATION, None, None)))


def _same_law(law: Law, engine: Engine, study: Study, found: Findings) -> list[Check]:
    """Hold force series and impulse against the exact ones, and measure the order of the error."""
    stage, heights = f"tower, {law} law", LEVELS[study.level].heights
    cases = [Tower(height=height, law=law) for height in heights]
    rows: list[Check] = []
    runs = run_towers(engine, cases, DURATION, profiles=True)
    for number, (case, run) in enumerate(zip(cases, runs, strict=True), 1):
        name = f"{engine.name}, {law} law, n = {case.height}"
        rows += rows_of_parts(NAME, [asked(Part(name, partial(_one, case, run, study, found)))])
        if isinstance(run, EngineError):
            found.errors[record_name(case, engine.name)] = run
        study.progress(stage, number, len(heights) + 1)

    def stepped(case: Tower, steps: float) -> TowerRun:
        return tower(case, steps_per_contact=steps, engine=engine)

    rows.append(order(law, engine.name, stepped, LADDER, found.evidence, study))
    study.progress(stage, len(heights) + 1, len(heights) + 1)
    return rows


def _one(case: Tower, run: TowerRun | EngineError, study: Study, found: Findings) -> list[Check]:
    """Keep the record of a run and return its rows."""
    run = whole(run)
    # samples at the same times: nothing needs to be interpolated
    exact = exact_run(case, run.time.size - 1, study)
    found.records.append(tower_record(run))
    return against_exact(run, exact, found.evidence, found.divergences)


def _impulses(engine: Engine, study: Study, found: Findings) -> list[Check]:
    """Compare alpha(n) of the overlap law with that of the exact propagator."""
    heights = LEVELS[study.level].heights
    table = partial(
        impulse_angles, heights=heights, stiffnesses=(1e6,), speeds=(2.0,), laws=("overlap",)
    )
    ours, exact = table(engine=engine), table(solver="exact")
    found.records += ratio_records(ours, engine.identify(), heights)
    return [
        judge(
            f"tower: impulse ratio alpha({height}), overlap law, {engine.name}",
            Kind.CROSS_CODE,
            float(here),
            float(there),
            tolerances.IMPULSE_RATIO,
        )
        for height, here, there in zip(
            heights, ours["impulse_ratio"], exact["impulse_ratio"], strict=True
        )
    ]
