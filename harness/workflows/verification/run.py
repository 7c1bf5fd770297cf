"""Run a verification from theory to verdicts."""

from __future__ import annotations

import platform
import time
from collections.abc import Iterable
from contextlib import ExitStack
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from harness import __version__
from harness.cases.incline.checks import incline_checks
from harness.cases.incline.reference_checks import reference_checks
from harness.cases.incline.theory_checks import theory_checks
from harness.cases.tower.chain_checks import chain_checks
from harness.cases.tower.checks import tower_checks
from harness.comparison.evidence import InclineEvidence, TowerEvidence
from harness.comparison.regression import Baseline, Regression
from harness.comparison.verdicts import Check, Kind, failed_run
from harness.comparison.verification import Verification
from harness.engines.contract import Engine
from harness.engines.lammps.scripts import drop_script
from harness.engines.parallel import parallel_map
from harness.engines.registry import input_files, open_engine
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.store.baseline import committed, read_baseline
from harness.theory.critical_angle import critical_angle
from harness.workflows.progress import Progress, silent
from harness.workflows.verification.baseline_rows import baseline_rows, measured_cases
from harness.workflows.verification.levels import Level
from harness.workflows.verification.levels import level as level_by_name
from harness.workflows.verification.other_engines import (
    Found,
    Open,
    asked_engines,
    engine_checks,
)

ENGINE = "lammps"
"""Whose baseline it is when the engine does not even say who it is."""


def chosen_baseline(given: Path | Baseline | None, tolerances: Path | None) -> Baseline:
    """Return the baseline of a folder, or the committed one; empty where there is none."""
    if isinstance(given, Baseline):
        return given
    where = given or committed()
    if where is None:
        return Baseline({}, "none")
    return read_baseline(where, tolerances)


def _both(
    engine: Engine,
    level: Level,
    inclines: InclineEvidence,
    towers: TowerEvidence,
    progress: Progress,
) -> list[Check]:
    """Run incline and tower side by side: what one core computes, the other need not wait for."""
    parts = (
        partial(incline_checks, engine, level, inclines, progress),
        partial(tower_checks, engine, level, towers, progress),
    )
    return [check for checks in parallel_map(lambda part: part(), parts, 2) for check in checks]


def _scripts(beside: Found | None) -> dict[str, str]:
    """Return the inputs that ran, by name: LAMMPS's, and with other engines theirs."""
    if beside is None:
        drop = drop_script().name
        return {name: text for name, text in input_files("lammps").items() if name != drop}
    here = [told.engine for told in beside.evidence.declared if not told.missing]
    return {name: text for engine in here for name, text in input_files(engine).items()}


def verify(
    level: str = "default",
    *,
    engine: Engine | None = None,
    progress: Progress = silent,
    baseline: Path | Baseline | None = None,
    tolerances: Path | None = None,
    compare: bool = True,
    engines: str | Iterable[str] = (),
    open_one: Open = open_engine,
) -> Verification:
    """Hold LAMMPS against theory on the incline and return checks and evidence.

    ``level`` is ``quick``, ``default`` or ``full``. An engine that fails leaves
    rows that say so and status 3; the theory is checked all the same. The results
    are held against a ``baseline``, read or in a folder (the committed one), within the
    table of tolerances and the overrides of the file ``tolerances``, unless
    ``compare`` is false. ``engines`` are held against one another as well: names, or
    ``all``; ``open_one`` opens one by its name. Raise RequestError for an unknown level or
    engine and a damaged baseline. Write the report with :func:`harness.report.write`.
    """
    chosen, asked = level_by_name(level), asked_engines(engines)
    known = chosen_baseline(baseline, tolerances) if compare else None
    started, clock = datetime.now(UTC), time.monotonic()
    evidence = InclineEvidence(closed_form_deg=critical_angle())
    towers = TowerEvidence()
    checks: list[Check] = []
    provenance: Provenance | None = None
    beside: Found | None = None
    with ExitStack() as own:
        try:
            engine = engine or own.enter_context(open_engine())
            provenance = engine.identify()
            checks += _both(engine, chosen, evidence, towers, progress)
            checks += reference_checks(engine, chosen, evidence)
        except EngineError as error:
            checks.append(failed_run("incline: LAMMPS", Kind.CROSS_CODE, error))
        if asked.engines:
            beside = engine_checks(asked, chosen.name, open_one, progress, engine)
    own_checks = chain_checks(chosen, towers)
    of_engines = beside.checks if beside else []
    died = [check.note for check in checks if check.engine_died]
    measured = measured_cases(chosen, evidence, towers)
    regression = Regression()
    if known is not None:
        name, how = (provenance.engine, provenance.how) if provenance else (ENGINE, "in-process")
        regression = baseline_rows(measured, known, chosen, name, evidence, towers, how)
    return Verification(
        level=chosen.name,
        started=started.isoformat(timespec="seconds"),
        seconds=time.monotonic() - clock,
        platform=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        harness_version=__version__,
        provenance=provenance,
        checks=(*checks, *theory_checks(), *own_checks, *of_engines, *regression.checks),
        incline=evidence,
        tower=towers,
        scripts=_scripts(beside),
        engine_errors=(*died, *(beside.errors if beside else ())),
        measured=tuple(measured),
        parted=(*towers.parted, *regression.parted),
        baseline=known.where if known else "",
        logs=engine.logs() if engine is not None else {},
        engines=beside.evidence if beside else None,
    )
