"""What is LAMMPS's own in running its executable; faults of runs are in ``test_faults``."""

import sys

import pytest

from harness.engines.lammps.engine import Lammps
from harness.engines.scripts import Task
from harness.errors import (
    EngineMissingError,
    RequestError,
)
from harness.observables.provenance import Provenance

GREETING = "Large-scale Atomic/Molecular Massively Parallel Simulator - {}\n"


def test_lammps_without_granular_is_refused_with_the_package_named(script_file):
    said = f"\n{GREETING.format('22 Jul 2025')}\nInstalled packages:\n\nKSPACE MC \n"
    path = script_file(f"cat <<END\n{said}\nEND\n")
    with (
        Lammps(lmp=path) as engine,
        pytest.raises(EngineMissingError, match=r"fake-lmp .* without the GRANULAR package"),
    ):
        engine.identify()


def test_launcher_alone_runs_the_lmp_on_path_and_is_checked_first():
    with pytest.raises(RequestError, match=r"--mpirun 'no-such-launcher'"):
        Lammps(lmp=sys.executable, launcher="no-such-launcher -np 4")


@pytest.mark.parametrize(
    ("version", "shares"),
    [("23 Jun 2022 - Update 4", [[0, 3], [1], [2]]), ("2 Aug 2023", [[0, 1, 2, 3]])],
)
def test_types_that_are_mixed_run_alone_where_their_models_are_what_is_in_memory(
    monkeypatch, version, shares
):
    engine = Lammps(lmp=sys.executable)
    monkeypatch.setattr(engine, "workers", 1)
    monkeypatch.setattr(engine, "identify", lambda: Provenance("lammps", version, (), "lmp", ""))
    plain, mixed = {"friction": 0.3}, {"partner_youngs_modulus": 4e8}
    tasks = [Task(None, None, values) for values in (plain, mixed, mixed, plain)]
    assert engine.shares(tasks) == shares
