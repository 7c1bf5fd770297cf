"""The cost of a sweep next to the engine's own time.

Run with ``pytest -m benchmark -s tests/benchmarks``. CPU time is counted, this process's for the
harness and its children's for LAMMPS: a busy machine changes neither.
"""

import resource
import time

import pytest

from harness.engines.registry import open_engine
from harness.store.cache import CachedEngine, Entries
from harness.workflows import sweep

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

RUNS = 200
LARGEST_SHARE = 0.05  # of the engine's CPU time


def _children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.parametrize(
    ("fixed", "runs", "largest"),
    [
        ({"stiffness": "1e8", "steps_per_contact": "200"}, RUNS // 4, LARGEST_SHARE),
        ({}, RUNS, None),  # the cheapest runs: printed
    ],
)
@pytest.mark.usefixtures("lammps_here")
def test_the_harness_costs_little_next_to_the_engine(tmp_path, fixed, runs, largest):
    entries = Entries(tmp_path)

    def cached(name):
        return CachedEngine(open_engine(name), entries)

    # imports and kernels are no part of the cost of a run
    sweep("incline", {"angle": "9,9.5"}, engines="lammps", open_engine=cached)
    before, own = _children(), time.process_time()
    found = sweep(
        "incline", {"angle": f"10:11:{runs}"}, fixed=fixed, engines="lammps", open_engine=cached
    )
    own, engines = time.process_time() - own, _children() - before
    assert found.count("done") == runs
    each = f"{1e3 * own / runs:.1f} ms of {1e3 * engines / runs:.0f} ms a run"
    print(f"\nsweep of {runs} runs: harness {100 * own / engines:.2g} % of the engine ({each})")
    if largest is not None:
        assert own < largest * engines
