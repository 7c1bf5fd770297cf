"""``dem-harness cases``, ``engines``, ``inputs``, ``defect`` and ``cache``."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from harness.cli.app import Folder, Json, Name
from harness.cli.engines import ProgramOptions
from harness.cli.output import print_columns, print_json, print_record, print_wrapped, tell
from harness.errors import RequestError


def cases(name: str | None = None, /, *, json: Json = False) -> int:
    """List the cases: what each simulates, its quantities, and the engines that run it.

    Of one case: its parameters with unit, default and what is allowed, presets with their source,
    quantities with their meaning, and why an engine cannot run it.

    For example:

        dem-harness cases oblique

    Parameters
    ----------
    name
        A case that is shown in full.
    """
    from harness.cases.registry import plugin_faults
    from harness.workflows import cases as list_cases

    for fault in plugin_faults():
        tell(fault)
    records = list_cases(name)
    if json:
        print_json({"cases": records})
        return 0
    if name is not None:
        print_record(records[0])
        return 0
    for case in records:
        print_wrapped(f"{case['name']} ({case['group']}): {case['summary']}")
        units = {**case["quantities"], **case["derived"]}
        quantities = ", ".join(f"{n} ({unit or '-'})" for n, unit in units.items())
        for title, text in (
            ("quantities", quantities),
            ("parameters", ", ".join(case["parameters"])),
            ("engines", ", ".join(case["engines"]) or "none"),
        ):
            print_wrapped(f"{title}: {text}", indent=4)
    return 0


def engines(
    programs: ProgramOptions = ProgramOptions(),
    *,
    json: Json = False,
) -> int:
    """List the engines: version, how they are run, and why one is missing.

    For example:

        dem-harness engines --program yade=/opt/yade/bin/yade
    """
    from harness.engines.registry import engine_names, named_values, refused_plugins
    from harness.workflows import engines as list_engines
    from harness.workflows.progress import progress_bars

    programs.check(engine_names(), "--engine")
    with progress_bars("engines", quiet=json) as progress:
        statuses = list_engines(
            programs=named_values(programs.program or (), "--program"),
            lmp=programs.lmp,
            launcher=programs.mpirun,
            progress=progress,
        )
    for fault in refused_plugins():
        tell(fault)
    if json:
        print_json({"engines": statuses})
        return 0
    print_columns([
        (s["engine"], s["how"], s["engine_version"] or "missing", s["reason"] or s["executable"])
        for s in statuses
    ])  # fmt: skip
    return 0


def inputs(
    *,
    check: bool = False,
    engine: Name = None,
    output: Annotated[Folder, Parameter(alias="--folder")] = None,
    json: Json = False,
) -> int:
    """Write the scripts of LAMMPS, or check that the committed ones are up to date.

    For example:

        dem-harness inputs --check

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

    folder = output or Path("inputs")
    if check:
        if engine is not None:
            raise RequestError(f"--engine {engine}: goes without --check, which is of LAMMPS")
        outdated = outdated_inputs(folder)
        if json:
            print_json({"folder": str(folder), "outdated": outdated})
        for name, difference in {} if json else outdated.items():
            print(f"{folder / name}: {difference}")
        return 1 if outdated else 0
    if engine is not None and output is None:
        raise RequestError(f"--engine {engine}: needs --output, a new folder")
    written = [str(path) for path in write_inputs(folder, engine)]
    if json:
        print_json({"folder": str(folder), "written": written})
    else:
        print("\n".join(written))
    return 0


def defect(name: str | None = None, /, *, json: Json = False) -> int:
    """Show a known defect: its cause, releases, effect, and the script that shows it.

    For example:

        dem-harness defect tsuji-restitution

    Parameters
    ----------
    name
        Name of a known defect; without one, all of them in a line each.
    """
    from harness.workflows import defects

    records = defects(name)
    if json:
        print_json({"defects": records})
    elif name is None:
        print_columns([(r["name"], f"{r['since']} to {r['until']}", r["cause"]) for r in records])
    else:
        script = records[0].pop("script", "")
        print_record(records[0])
        print(f"\n{script}" if script else "")
    return 0


def cache(
    *,
    clear: bool = False,
    older_than: Annotated[float | None, Parameter(metavar="DAYS")] = None,
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
    from harness.store.entries import clear as clear_entries
    from harness.store.entries import contents, sorts

    if older_than is not None and not older_than >= 0.0:
        raise RequestError(f"--older-than {older_than}: must be 0 days or more")
    if case is not None:
        get_case(case)
    folder = cache_place(kept).path
    if kept is not None and not kept.is_dir() and kept.exists():
        raise RequestError(f"--cache {kept}: is a file; name a folder")
    oldest = math.inf if older_than is None else time.time() - 86400.0 * older_than
    entries = [e for e in contents(folder) if e.used < oldest and case in (None, *e.label[1:])]
    record = {"cache": str(folder), "cleared": clear}
    counts = sorts(clear_entries(folder, entries) if clear else entries)
    if json:
        print_json({**record, "sorts": counts})
        return 0
    print(f"cache: {folder}")
    for sort, count in counts.items():
        state = "cleared" if clear else "kept"
        print(f"{sort}: {count['entries']} {state}, {count['bytes'] / 1e6:.3g} MB")
    return 0
