"""Speed of the chain solvers; run with ``pytest -m benchmark -s tests/benchmarks``."""

import time

import numpy as np
import pytest

from harness.cases.tower.parameters import Tower
from harness.cases.tower.runs import chain_of
from harness.solvers import chain_stepped
from harness.solvers.chain import STABILITY, highest_frequency

pytestmark = pytest.mark.benchmark

STEP = 3e-6  # [s] about 1000 steps in pi sqrt(m/k)
TURNS = 9
GROWS_WITH_THE_ROW = 10.0
PARTICLE_STEPS = 4_000_000


def seconds(particles, law, steps):
    """Return the seconds of processor time of one run, compiled."""
    chain = chain_of(Tower(height=particles - 1, law=law))
    begin = time.process_time()
    step = min(STEP, 0.5 * STABILITY["rk4"] / highest_frequency(chain))
    chain_stepped.run(chain, steps * step, step * (1 + 1e-9), samples=1)
    return time.process_time() - begin


def step_cost(particles, law):
    """Return the seconds per particle of one more step: those of a long run less a short one's."""
    steps = max(20, PARTICLE_STEPS // particles)
    less = seconds(particles, law, 5)
    return (seconds(particles, law, 5 + steps) - less) / steps / particles


@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_cost_of_a_particle_is_flat(law):
    """Print what one more step costs a particle over the length of the row.

    The ratio to N = 1000 is that of the machine's caches and memory. Asserted is what no machine
    changes: a cost that grew with the row would be a thousand times as large at the end.
    """
    sizes = (1_000, 10_000, 100_000, 1_000_000)
    turns = [[step_cost(n, law) for n in sizes] for _ in range(TURNS + 1)]
    costs = np.array(turns[1:])
    ratios = np.median(costs / costs[:, :1], axis=0)
    for n, cost, ratio in zip(sizes, costs.min(axis=0), ratios, strict=True):
        print(f"\nN = {n}, {law}: {cost * 1e9:.1f} ns, median ratio to N = 1000 {ratio:.2f}")
    assert (ratios < GROWS_WITH_THE_ROW).all()
