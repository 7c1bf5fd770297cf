"""The same cases against several releases of an engine, each in an installation of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Protocol, cast

from harness.comparison.regression import BaselineRecord
from harness.comparison.releases import Column, ReleaseMatrix, release_matrix
from harness.comparison.verification import Verification
from harness.engines.contract import Engine
from harness.engines.registry import DEFAULT, engine_class
from harness.errors import EngineError, RequestError
from harness.store.cache import keeping
from harness.workflows.progress import Progress, silent
from harness.workflows.verification import checked_level, chosen_cases, here, verify

Remember = Callable[[Engine], Engine]
"""Takes an open engine and returns the one to use."""


class Releases(Protocol):
    """The part of an engine's class that opens its releases."""

    @classmethod
    def check_release(cls, name: str) -> None:
        """Raise RequestError for a name that is neither of a release nor of a program."""

    @classmethod
    def release(cls, name: str, folder: Path | None = None) -> Engine:
        """Return the engine of a release, installed in a folder if need be.

        Raise EngineMissingError when it cannot be installed.
        """


def releases(
    names: Sequence[str],
    *,
    level: str = "quick",
    cases: str | Iterable[str] | None = None,
    engine: str = DEFAULT,
    folder: Path | None = None,
    remember: Remember | None = None,
    fresh: bool = False,
    progress: Progress = silent,
) -> ReleaseMatrix:
    """Run the cases of a level of ``verify`` in each release of an engine and return the matrix.

    ``names`` are releases, which are installed under the user's cache folder (or ``folder``), or
    paths of executables. The first that runs is the reference. A release that cannot be installed
    or run is a column that says so. Runs are kept, unless ``remember`` wraps the engines otherwise;
    ``fresh`` runs them again. Raise RequestError for a name that is neither, or given twice, and
    for an engine without releases.
    """
    checked_level(level)
    chosen = chosen_cases(cases)
    opens = _releases_of(engine)
    _check(names, opens)
    keep = remember or partial(keeping, fresh=fresh)
    columns, title = [], engine.upper()
    for number, name in enumerate(names):
        progress("releases", number, len(names))

        def report(stage: str, done: int, total: int, name: str = name) -> None:
            progress(f"{name}: {stage}", done, total)

        try:
            with opens.release(name, folder) as installed:
                title = installed.title
                verification = verify(
                    level, cases=cases, engine=keep(installed), progress=report, baseline=False
                )
        except EngineError as error:
            columns.append(Column(name, None, error=f"{error.kind}: {error}"))
        else:
            columns.append(_column(name, verification))
    progress("releases", len(names), len(names))
    tolerances = {case.name: case.verification.regression for case in chosen}
    requested = cases if isinstance(cases, str) else ",".join(cases or ())
    return release_matrix(level, here(), columns, tolerances, title, requested)


def _releases_of(engine: str) -> Releases:
    kind = engine_class(engine)
    if not (hasattr(kind, "release") and hasattr(kind, "check_release")):
        raise RequestError(f"--engine {engine!r}: has no releases that can be installed")
    return cast(Releases, kind)


def _check(names: Sequence[str], opens: Releases) -> None:
    """Raise RequestError, before anything runs, for a request that cannot be met."""
    if not names:
        raise RequestError("releases: name at least one, or an executable")
    twice = sorted({name for name in names if list(names).count(name) > 1})
    if twice:
        raise RequestError(f"release {twice[0]!r}: is named twice")
    for name in names:
        opens.check_release(name)


def _column(name: str, verification: Verification) -> Column:
    """Return what a release measured itself; own solvers are the same in each."""
    records: tuple[BaselineRecord, ...] = tuple(
        record for findings in verification.main.values() for record in findings.records
    )
    errors = {
        record: f"{error.kind}: {error}"
        for findings in verification.main.values()
        for record, error in findings.errors.items()
    }
    died = verification.engine_errors[0] if verification.engine_errors and not records else ""
    checks = tuple(check for check in verification.checks if check.cell is not None)
    return Column(name, verification.provenance, records, died, errors, checks)
