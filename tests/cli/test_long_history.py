"""A long history is written a row at a time: memory does not grow with it."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from harness.observables.row import Row
from harness.store.history import History, RunEnd, RunStart

SHORT, LONG = 2000, 20_000
MORE = 16 * 1024**2
"""[bytes] that the long one may take beyond the short one, 0.4 kB a row. No row is kept then: as
mappings with the text of them all each took 8.6 kB, as mappings alone 2 kB. What is allowed is for
a block of rows and SQLite's sorting, which have a bound of their own."""


def _measured(path, rows):
    with History(path) as history:
        run = history.begin(RunStart("verify", ["--quick"], "0.1.0", "", "Linux"))
        some = (Row(f"incline: check {n}", 10.2 + n, 1e-4, "deg") for n in range(rows))
        history.finish(run, RunEnd(0, 9.0, "lammps", "22 Jul 2025", "in-process"), some)


PROGRAM = """
import atexit, pathlib, sys
from harness.cli import main

@atexit.register
def tell():
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    print(next(line.split()[1] for line in lines if line.startswith("VmHWM")), file=sys.stderr)

main()
"""


def _peak(words, stdout):
    """Return the largest memory [bytes] of ``history`` with these words."""
    command = [sys.executable, "-c", PROGRAM, "history", *words]
    with stdout.open("w") as stream:
        done = subprocess.run(command, stdout=stream, stderr=subprocess.PIPE, text=True, check=True)
    return 1024 * int(done.stderr.splitlines()[-1])


@pytest.fixture(scope="module")
def homes(tmp_path_factory):
    """Return a home for each number of rows, written once."""
    folders = {rows: tmp_path_factory.mktemp(str(rows)) for rows in (SHORT, LONG)}
    for rows, home in folders.items():
        _measured(home / "history.sqlite", rows)
    return folders


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--json", "--csv"])
def test_memory_does_not_grow_with_the_rows(tmp_path, monkeypatch, homes, option):
    peaks = []
    for rows, home in homes.items():
        written = tmp_path / f"{rows}.written"
        monkeypatch.setenv("DEM_HARNESS_HOME", str(home))
        as_json = option == "--json"
        words, stdout = ([], written) if as_json else ([written], Path(os.devnull))
        peaks.append(_peak([option, *words, "--quantity", "*"], stdout))
        with written.open() as stream:
            found = json.load(stream)["quantities"] if as_json else csv.DictReader(stream)
            assert [float(row["value"]) for row in found] == [10.2 + n for n in range(rows)]
    print(f"{option}: {peaks[0] / 1e6:.0f} and {peaks[1] / 1e6:.0f} MB")
    assert peaks[1] - peaks[0] < MORE
