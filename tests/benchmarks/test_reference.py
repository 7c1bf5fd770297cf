"""What a step of the incline costs in the reference DEM, against LAMMPS in the same run."""

import time

import pytest

from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.engines.lammps.engine import Lammps
from harness.engines.reference import Reference

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

CASE = Incline(angle=10.6, wells=20)
TIMES_FASTER = 10.0


def _best(engine):
    """Return the seconds of wall time per step, the best of three runs."""
    best = float("inf")
    for _ in range(3):
        started = time.perf_counter()
        (run,) = run_inclines(engine, [CASE], "steady")
        best = min(best, (time.perf_counter() - started) / run.steps)
    return best


def test_a_step_of_the_reference_dem_costs_a_tenth_of_lammps_s():
    reference = Reference()
    run_inclines(reference, [CASE.replace(wells=1)], "steady")  # compiled at the first call
    with Lammps(workers=1) as lammps:
        lammps.identify()
        theirs = _best(lammps)
    own = _best(reference)
    print(f"\nLAMMPS {theirs * 1e9:.0f} ns, reference {own * 1e9:.0f} ns: {theirs / own:.0f} times")
    assert theirs > TIMES_FASTER * own
