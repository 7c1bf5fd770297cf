"""Speed of the chain solvers; run with ``pytest -m benchmark -s tests/benchmarks``."""

import pytest

from harness.cases.tower.parameters import Tower
from harness.cases.tower.runs import chain_of
from harness.solvers import chain_stepped
from harness.solvers.chain import STABILITY, highest_frequency

pytestmark = pytest.mark.benchmark

STEP = 3e-6  # [s] about 1000 steps in pi sqrt(m/k)
SIZES = (1_000, 10_000, 100_000, 1_000_000)
GROWS_WITH_THE_ROW = 10.0
PARTICLE_STEPS = 4_000_000
SETUP_STEPS = 5


@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_cost_of_a_particle_is_flat(law, cpu):
    """Print what one more step costs a particle over the length of the row.

    The ratio to N = 1000 is that of the machine's caches and memory. Asserted is what no machine
    changes: a cost that grew with the row would be a thousand times as large at the end.
    """

    def step_cost(particles):
        """Return the seconds per particle of one more step: a long run's less a short one's."""
        chain = chain_of(Tower(height=particles - 1, law=law))
        step = min(STEP, 0.5 * STABILITY["rk4"] / highest_frequency(chain))
        more = max(20, PARTICLE_STEPS // particles)
        short, long = (
            cpu(lambda n=n: chain_stepped.run(chain, n * step, step * (1 + 1e-9), samples=1))[1]
            for n in (SETUP_STEPS, SETUP_STEPS + more)
        )
        return (long - short) / more / particles

    step_cost(SIZES[0])  # compiled
    costs = [min(step_cost(n) for _ in range(3)) for n in SIZES]
    for n, cost in zip(SIZES, costs, strict=True):
        print(f"\nN = {n}, {law}: {cost * 1e9:.1f} ns, ratio to N = 1000 {cost / costs[0]:.2f}")
    assert max(costs) < GROWS_WITH_THE_ROW * costs[0]
