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


def test_a_wait_that_the_user_chose_is_kept(lmp, monkeypatch, tmp_path):
    monkeypatch.setattr(engine, "cores", lambda: 1)
    chosen, *_ = SLEEPING
    monkeypatch.setenv(chosen, "0")
    with Lammps(lmp=lmp) as one, one.on_ranks(2) as there:
        told = there.environment(tmp_path)
    assert told[chosen] == "0"
