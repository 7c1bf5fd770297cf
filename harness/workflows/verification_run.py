"""Run a verification, from the cases that are asked for to verdicts."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from harness import __version__
from harness.cases.contract import Study
from harness.comparison.known_defects import KnownDefect, defect_of, told_apart
from harness.comparison.regression import Baseline, Regression
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
    ``engines`` are held beside it: names, or ``all``; ``open_one`` opens one by its name. The
    results are held against a ``baseline``: read, in a folder, the committed one for None, none
    for False. With ``strict`` what is not tested counts as a failure.

    An engine that fails leaves rows that say so and status 3, a case that raises a failed row;
    the rest goes on. Raise RequestError for an unknown level, case or engine, and a damaged file.
    """
    chosen, asked = chosen_cases(cases), asked_engines(engines)
    study = Study(checked_level(level), progress, open_one, cases=tuple(chosen))
    known = None if baseline is False else chosen_baseline(baseline)
    defects = known_defects()
    started, clock = datetime.now(UTC), time.monotonic()
    with ExitStack() as own:
        run = MainRun(chosen, study)
        run.open(engine, own)
        run.cases_side_by_side()
        beside = EnginesBeside(asked, chosen, study, run.engine).run()
        scripts, logs = run.scripts(beside), run.engine.logs() if run.engine else {}
    measured = Measured(study.level, run.who, chosen, run.findings, run.broken)
    regression = Regression() if known is None else baseline_rows(measured, known, beside.records)
    checks = told_apart((*run.checks, *beside.checks), defects, _versions(run, beside))
    died = [check.note for check in checks[: len(run.checks)] if check.engine_died]
    return Verification(
        level=study.level,
        cases=tuple(case.name for case in chosen),
        started=started.isoformat(timespec="seconds"),
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
        engine_errors=(*died, *beside.errors),
        records=tuple(measured.records),
        divergences=(*run.divergences, *regression.divergences),
        baseline=known.where if known else "",
        baseline_sha256=known.digest if known else "",
        logs=logs,
        strict=strict,
        defects=_found(defects, checks),
    )


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
