"""``study --executor slurm`` on a real SLURM, with a study of a few seconds."""

import json

import pytest

from harness.cases.layers.extents import EXTENTS, BoxExtent, Extent
from harness.workflows.sweep_plan import SweepRequest
from harness.workflows.sweep_run import held_sweep
from tests.slurm_here import slurm  # noqa: F401

pytestmark = [pytest.mark.slow, pytest.mark.live, pytest.mark.usefixtures("slurm")]

TINY = Extent({1: BoxExtent(6, 3, 20.0, 2)}, (100.0,), BoxExtent(6, 3, 20.0, 2))


@pytest.mark.usefixtures("lammps_here")
def test_a_tiny_study_runs_there_and_its_folder_is_held(command, monkeypatch, tmp_path):
    monkeypatch.setitem(EXTENTS, "quick", TINY)
    words = ["study", "layers", "--quick", "--executor", "slurm", "--output", "mine"]
    with held_sweep(tmp_path / "mine-jobs", SweepRequest("layers", {}, {"study": "quick"})):
        assert "another sweep runs in it" in command(*words, status=2).err
    done = command(*words, "--json")
    assert (
        "runs of study layers (level quick, what is kept counted as well): an estimated" in done.err
    )
    assert "jobs are submitted to SLURM" in done.err
    found = json.loads(done.out)
    assert found["failed"] == 0
    arms = {row["arm"]: row for row in found["rows"]}
    assert arms["thickness"]["seeds"] == 2
    assert 0.0 < 10.2078 - arms["single grain"]["stop_angle_deg"] < 0.026
