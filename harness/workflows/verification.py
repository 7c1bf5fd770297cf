"""Verify engines: from level, cases and engines to a run.

Every engine is treated alike: it is opened, qualifies, and runs the checks of each case; the
solvers of this package are one more bench. Then engines are held against one another, and all rows
against the accepted run. Whatever fails is a row, and the rest goes on.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from harness import __version__
from harness.cases.base import Case
from harness.cases.defects import known_defects as load_defects
from harness.cases.registry import (
    ALL,
    case_names,
    get_case,
    selected_names,
    usable_cases,
)
from harness.engines.registry import DEFAULT, engine_names
from harness.errors import (
    RequestError,
)
from harness.report.content import Section
from harness.results.defects import KnownDefect
from harness.results.rows import (
    LEVELS,
    Level,
    table,
)
from harness.store.cache import opened
from harness.store.committed import accepted_folder, accepted_rows
from harness.store.runs import Meta, Run, write_run
from harness.workflows.executors import opened_on
from harness.workflows.progress import Progress, silent
from harness.workflows.selection import selected_engines, words_in
from harness.workflows.session import OpenEngine, Session


def verify(  # noqa: PLR0913 - the options of a user
    level: Level = "default",
    *,
    cases: str | Iterable[str] | None = None,
    engines: str | Iterable[str] = DEFAULT,
    only: str = "",
    strict: bool = False,
    known_defects: Path | None = None,
    output: Path | None = None,
    png: bool = False,
    open_engine: OpenEngine = opened,
    executor: Executor | None = None,
    check_duration: Callable[[float], None] = lambda _: None,
    progress: Progress = silent,
) -> Run:
    """Hold engines against theory, one another and the accepted run; return the rows.

    ``cases`` are names, groups or ``all``; ``engines`` are names or ``all``, every engine that is
    here. ``only`` is a pattern of ``case/setup/quantity``, in all cases unless some are named.
    ``known_defects`` is a file of defects beside the committed ones; a ``strict`` run fails also
    where a row was not tested. ``output`` is a new folder for the report, with figures as PNG too
    for ``png``. With an ``executor`` its workers run the engines, in place of ``open_engine``.
    ``check_duration`` is called with the expected time on one core [s], and may raise.

    An engine that is missing, dies or does not qualify, and a case that raises, are rows. Raise
    RequestError, before anything runs, for an unknown level, case, engine or pattern.
    """
    if level not in LEVELS:
        raise RequestError(f"level = {level!r} is not known: must be one of {', '.join(LEVELS)}")
    chosen, names = selected_cases(cases, only), selected_engines(engines)
    started, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    with ExitStack() as stack:
        session = Session(level, only or "*", chosen, load_defects(known_defects), progress)
        opening = open_engine if executor is None else partial(opened_on, executor)
        session.open(names, opening, stack)
        session.plan()
        check_duration(session.seconds())
        session.run()
        everything = ALL in words_in(engines)
        here = {n: v for n, v in session.versions.items() if v or not everything}
        meta = Meta(
            level=level,
            cases=tuple(case.name for case in chosen),
            engines=here,
            left_out=tuple(name for name in engine_names() if name not in here),
            named=tuple(word for word in words_in(cases or ()) if word in case_names()),
            only=session.only,
            strict=strict,
            started=started,
            seconds=time.monotonic() - clock,
            platform=_platform(),
            harness_version=__version__,
        )
        run = Run(
            table(session.ordered_rows()), meta, scripts=session.scripts(), logs=session.logs()
        )
        run = run.against(accepted_rows(accepted_folder(), here))
        if output is not None:
            progress("figures and report", 0, 1)
            write_run(run, output, _pages(run, session.sections(), session.defects, png=png))
            progress("figures and report", 1, 1)
    return run


def selected_cases(cases: str | Iterable[str] | None, only: str = "") -> list[Case[Any]]:
    """Return the cases of names, groups or ``all``; all for a pattern without names."""
    if only and cases is None:
        return list(usable_cases().values())
    return [get_case(name) for name in selected_names(cases)]


def _platform() -> str:
    return f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"


def _pages(
    run: Run, sections: Sequence[Section], defects: Sequence[KnownDefect], *, png: bool
) -> dict[str, str | bytes]:
    from harness.report.page import report_files

    by_name = {defect.name: dict(defect) for defect in defects}
    return report_files(run, sections, defects=by_name, png=png)
