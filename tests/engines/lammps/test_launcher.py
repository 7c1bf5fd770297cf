"""LAMMPS's ranks: how they wait where there are more of them than cores."""

import pytest

from harness.engines.lammps import engine
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.workers import SLEEPING


@pytest.mark.parametrize(("here", "sleep"), [(3, False), (2, True)])
def test_more_ranks_than_cores_sleep_where_they_wait(lmp, monkeypatch, tmp_path, here, sleep):
    monkeypatch.setattr(engine, "cores", lambda: here)
    with Lammps(lmp=lmp) as one, one.on_ranks(3) as there:
        told = there.environment(tmp_path) or {}
    assert (SLEEPING.items() <= told.items()) is sleep
