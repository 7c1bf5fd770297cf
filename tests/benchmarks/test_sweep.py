"""What a sweep costs beside the engine's own time.

Run with ``pytest -m benchmark -s tests/benchmarks``. CPU time is counted, this process's for the
harness and its children's for LAMMPS, which runs in workers: a busy machine changes neither.
"""

import resource
import time

import pytest
from harness.workflows.sweep_run import Runner

from harness.engines.registry import open_engine
from harness.store.cache import CachedEngine
from harness.store.entries import Entries
from harness.workflows import sweep

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

RUNS = 200
MOST = 0.05
"""Of the engine's CPU time."""


def _children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.parametrize(
    ("fixed", "most"),
    [
        ({"stiffness": "1e8", "steps_per_contact": "200"}, MOST),
        ({}, None),  # the cheapest runs that there are: printed
    ],
)
def test_the_harness_costs_little_beside_the_engine(tmp_path, lammps_here, fixed, most):  # noqa: ARG001
    entries = Entries(tmp_path)
    runs = RUNS if most is None else RUNS // 4
    # what is imported and compiled once is not what a run costs
    with open_engine("lammps") as engine:
        warm = Runner(lambda _: CachedEngine(engine, entries))
        sweep("incline", {"angle": "9,9.5"}, engines="lammps", runner=warm)
    before, own = _children(), time.process_time()
    with open_engine("lammps") as engine:
        runner = Runner(lambda _: CachedEngine(engine, entries))
        found = sweep("incline", {"angle": f"10:11:{runs}"}, fixed=fixed, runner=runner)
    own, engines = time.process_time() - own, _children() - before
    assert found.count("done") == runs
    each = f"{1e3 * own / runs:.1f} ms of {1e3 * engines / runs:.0f} ms a run"
    print(f"\nsweep of {runs} runs: harness {100 * own / engines:.2g} % of the engine ({each})")
    if most is not None:
        assert own < most * engines
