"""Run a verification, from the cases that are asked for to verdicts."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from harness import __version__
from harness.cases.contract import Case, Study
from harness.comparison.known_defects import KnownDefect, defect_of, told_apart
from harness.comparison.moved_by_defects import moved_by_defects
from harness.comparison.regression import Baseline, Regression, explained_by_cells
from harness.comparison.verdicts import Check
from harness.comparison.verification import Verification
from harness.engines.contract import Engine
from harness.engines.registry import open_engine
from harness.store.known_defects import known_defects, script_of
from harness.workflows.baseline_rows import Measured, baseline_rows, here
from harness.workflows.engine_selection import asked_engines
from harness.workflows.engines_beside import Beside, EnginesBeside
from harness.workflows.main_engine import MainRun
from harness.workflows.progress import Progress, silent
from harness.workflows.request import checked_level, chosen_baseline, chosen_cases

Open = Callable[[str], AbstractContextManager[Engine]]
"""Opens an engine by its name, to be closed after use."""


def verify(
    level: str = "default",
    *,
    cases: str | Iterable[str] | None = None,
    engine: Engine | None = None,
    engines: str | Iterable[str] = (),
    open_one: Open = open_engine,
    baseline: Path | Baseline | Literal[False] | None = None,
    progress: Progress = silent,
    strict: bool = False,
) -> Verification:
    """Hold an engine against theory, other codes and the baseline, case by case.

    ``level`` is ``quick``, ``default`` or ``full``. ``cases`` are names, groups or ``all``: those
    that run by default unless given. ``engine`` is an open one, the default one unless given;
    ``engines`` are held beside it, opened by ``open_one``: names, or ``all``. ``baseline`` is read,
    in a folder, the committed one for None, none for False. With ``strict`` not tested fails.

    An engine that fails leaves rows that say so and status 3, as does a case asked for by name or
    group of which no engine tested anything; a case that raises is a failed row; the rest goes on.
    Raise RequestError for an unknown level, case or engine, and a damaged file.
    """
    cases = ",".join(cases) if cases is not None and not isinstance(cases, str) else cases
    chosen, asked = chosen_cases(cases), asked_engines(engines)
    study = Study(checked_level(level), progress, open_one, cases=tuple(chosen))
    known = None if baseline is False else chosen_baseline(baseline)
    begun, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    with ExitStack() as own:
        run = MainRun(chosen, study)
        run.open(engine, own)
        run.cases_side_by_side()
        beside = EnginesBeside(asked, chosen, study, run.engine).run()
        scripts, logs = run.scripts(beside), run.engine.logs() if run.engine else {}
    measured = Measured(study.level, run.who, chosen, run.findings, run.broken)
    checks, regression = _told(measured, known, beside, run)
    return Verification(
        level=study.level,
        cases=tuple(case.name for case in chosen),
        started=begun,
        seconds=time.monotonic() - clock,
        platform=f"{here()}, Python {platform.python_version()}",
        harness_version=__version__,
        provenance=run.provenance,
        checks=(*checks, *regression.checks),
        main=run.main,
        own=run.own,
        beside=beside.findings,
        engines=tuple(beside.declared),
        scripts=scripts,
        engine_errors=(*_died(checks[: len(run.checks)]), *beside.errors),
        untested_cases=_untested_cases(chosen, cases, run, beside),
        records=tuple(measured.records),
        divergences=(*run.divergences, *regression.divergences),
        baseline=known.where if known else "",
        baseline_sha256=known.digest if known else "",
        logs=logs,
        strict=strict,
        defects=_found(known_defects(), checks),
    )


def _told(
    measured: Measured, known: Baseline | None, beside: Beside, run: MainRun
) -> tuple[tuple[Check, ...], Regression]:
    """Return the checks, and the rows against the baseline, with known defects told apart.

    What the checks of a cell explain, or the defects of one release predict, is no failure.
    """
    raw, versions = (*run.checks, *beside.checks), _versions(run, beside)
    checks = told_apart(raw, known_defects(), versions)
    if known is None:
        return checks, Regression()
    found = baseline_rows(measured, known, beside.records)
    rows = explained_by_cells(found.checks, checks)
    moved = moved_by_defects(rows, raw, known.records, known_defects(), versions)
    return checks, replace(found, checks=moved)


def _died(checks: Sequence[Check]) -> list[str]:
    return [check.note for check in checks if check.engine_died]


def _untested_cases(
    chosen: Sequence[Case[Any]], wanted: str | Iterable[str] | None, run: MainRun, beside: Beside
) -> tuple[str, ...]:
    """Return the cases asked for by name or group of which no engine has a judged row.

    Own solvers do not count: they are no test of an engine.
    """
    names = () if wanted is None else wanted.split(",") if isinstance(wanted, str) else wanted
    if not names or "all" in {name.strip() for name in names}:
        return ()
    by_engine = (run.main, *beside.findings.values())
    rows = {case.name: [c for by in by_engine if case.name in by for c in by[case.name].checks]
            for case in chosen if case.name not in run.raised}  # fmt: skip
    return tuple(name for name, checks in rows.items() if not any(c.judged for c in checks))


def _found(
    defects: Sequence[KnownDefect], checks: Sequence[Check]
) -> tuple[tuple[KnownDefect, str], ...]:
    """Return the known defects that checks are marked with, each with its script."""
    named = {defect_of(check) for check in checks}
    return tuple((one, script_of(one)) for one in defects if one.name in named)


def _versions(run: MainRun, beside: Beside) -> dict[str, str]:
    """Return the versions of the engines that ran, by name."""
    found = {one.engine: one.version for one in beside.declared if one.version}
    main = run.provenance
    return {**found, **({main.engine: main.engine_version} if main else {})}
