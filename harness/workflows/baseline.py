"""Compare a run with the baseline, with another run, or with runs of other releases."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, cast

from pydantic import ValidationError

from harness.comparison.regression import Baseline, BaselineRecord
from harness.comparison.releases import Column, ReleaseMatrix, release_matrix
from harness.comparison.run_diff import RunDiff, diff_runs
from harness.comparison.verdicts import Check, Kind, Triage
from harness.comparison.verification import (
    SCHEMA,
    Results,
    Verification,
    beside_tolerances,
    counted,
    read_published,
)
from harness.engines.contract import Engine
from harness.engines.registry import DEFAULT, engine_class
from harness.errors import EngineError, RequestError
from harness.shown import Result
from harness.store.acceptance import RecordChange, changes, check_target, write
from harness.store.baseline import bounded_text, checkout_baseline, committed
from harness.store.cache import EngineChoice, keeping
from harness.workflows.progress import Progress, silent
from harness.workflows.verification import (
    checked_level,
    chosen_baseline,
    chosen_cases,
    here,
    verify,
)

if TYPE_CHECKING:
    from harness.shown.figure import Figure


@dataclass(frozen=True, repr=False)
class BaselineComparison(Result):
    """A run against the baseline: the rows of kind regression, and what accepting would change."""

    verification: Verification
    changes: tuple[RecordChange, ...]

    JSON: ClassVar = {
        "baseline": "verification.baseline",
        "level": "verification.level",
        "status": "status",
        "engine": "verification.provenance",
        "engine_errors": "verification.engine_errors",
        "checks": "checks",
        "divergences": "verification.divergences",
        "changes": "changes",
    }
    ROWS: ClassVar = "checks"

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the rows against the baseline."""
        return tuple(check for check in self.verification.checks if check.kind is Kind.REGRESSION)

    @property
    def status(self) -> int:
        """Return the exit status: 3 when an engine died, 1 when a row failed, else 0."""
        if self.verification.engine_errors:
            return 3
        return 1 if any(check.verdict == "fail" for check in self.checks) else 0

    def summary(self) -> dict[str, str]:
        """Return the verdicts, what accepting would change, and who ran."""
        return {
            "verdicts": counted(self.checks) or "none",
            "accepting would write": f"{len(self.changes)} records",
            "baseline": self.verification.baseline,
            "engine": self.verification.provenance.label
            if self.verification.provenance
            else "none",
        }

    def draw(self) -> Figure:
        """Draw how much of its tolerance each row takes."""
        return beside_tolerances(self.checks)


def compare_with_baseline(
    level: str = "default",
    *,
    cases: str | Iterable[str] | None = None,
    baseline: Path | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = silent,
) -> BaselineComparison:
    """Run the cases of a level of ``verify`` and hold them against a baseline.

    The committed baseline unless a folder is given; a folder that is not there yet is
    empty. Raise RequestError for a damaged file, which is named.
    """
    new = baseline is not None and not baseline.exists()
    accepted = Baseline({}, str(baseline)) if new else chosen_baseline(baseline)
    verification = verify(
        level, cases=cases, engine=engine, fresh=fresh, progress=progress, baseline=accepted
    )
    return BaselineComparison(verification, tuple(changes(verification.records, accepted)))


def accept_baseline(compared: BaselineComparison, folder: Path | None = None) -> Path:
    """Write what a comparison found into a baseline's folder, all of it or nothing.

    Into the project's own unless a ``folder`` is given. Raise RequestError for
    the baseline of an installed package, which is not written, and EngineError
    after a run in which an engine died.
    """
    if compared.verification.engine_errors:
        first = compared.verification.engine_errors[0]
        raise EngineError(f"baseline: nothing is accepted from a run that died: {first}")
    for record in (change.measured for change in compared.changes):
        if not record.quantities:
            raise EngineError(f"baseline: {record.name}: has no quantity and is not accepted")
        for name, quantity in record.quantities.items():
            for value in (quantity.value, quantity.uncertainty):
                if not math.isfinite(value):
                    raise EngineError(f"baseline: {record.name}: {name} = {value} is not accepted")
    target = where_to_accept(folder)
    write(compared.changes, target)
    return target


def where_to_accept(folder: Path | None = None) -> Path:
    """Return the folder to write; raise RequestError, before any work, if it may not be."""
    target = folder or checkout_baseline() or committed()
    if target is None:
        raise RequestError("--baseline: this installation has no baseline; name a folder to write")
    check_target(target)
    return target


FILE = "results.json"


def diff(before: str | Path, after: str | Path) -> RunDiff:
    """Return what is not the same in two runs, each a report's folder or its results.json.

    Raise RequestError as :func:`read_results` does.
    """
    return diff_runs(read_results(before), read_results(after))


def read_results(run: str | Path) -> Results:
    """Return the results of a run, from its folder or its results.json.

    Raise RequestError, naming the file, for what is not there, is no JSON or no
    run, or is of another form.
    """
    path = Path(run)
    path = path / FILE if path.is_dir() else path
    record = _json(path)
    version = record.get("schema", SCHEMA) if isinstance(record, dict) else SCHEMA
    if version != SCHEMA:
        raise RequestError(f"{path}: is of schema {version!r}, this dem-harness reads {SCHEMA}")
    try:
        return read_published(record)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        message = str(first["msg"])[:1].lower() + str(first["msg"])[1:]
        raise RequestError(f"{path}: is not a run of dem-harness ({where}: {message})") from None


def _json(path: Path) -> Any:
    if path.parent.is_dir() and not path.exists() and path.name == FILE:
        raise RequestError(f"{path.parent}: is not a run: it holds no {FILE}")
    try:
        return json.loads(bounded_text(path))
    except OSError as error:
        raise RequestError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise RequestError(f"{path}: is no UTF-8 text, a {FILE} is expected") from None
    except (json.JSONDecodeError, RecursionError) as error:
        raise RequestError(f"{path}: is damaged, no JSON ({error})") from None


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
    lost = (Triage.HARNESS, Triage.MISSING)  # rows of whole cases, which have no cell
    checks = tuple(c for c in verification.checks if c.cell is not None or c.triage in lost)
    return Column(name, verification.provenance, records, died, errors, checks)
