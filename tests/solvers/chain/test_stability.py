"""The bound on the step of RK4: it holds, it is close, it is needed."""

from __future__ import annotations

import numpy as np
import pytest

from harness.errors import RequestError
from harness.parameters.tower import Tower
from harness.solvers.chain import motion, rk4
from harness.solvers.chain.exact import decompose, modal_state
from harness.solvers.chain.forces import factorise
from harness.solvers.chain.motion import assemble

LAWS = ("overlap", "deformable")


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("height", [1, 2, 5, 40])
def test_stability_bound_holds_and_is_close(law, base, height):
    rng = np.random.default_rng(height)
    equal = Tower(height=height, law=law, base=base, gravity=0.0)
    unequal = equal.replace(
        mass=tuple(rng.uniform(0.5, 2, height + 1)),
        stiffness=tuple(rng.uniform(5e5, 2e6, height + 1)),
    )
    for case in (equal, unequal):
        chain = assemble(case)
        state = modal_state(chain, np.ones(height, bool))
        factorise(state.closed, chain.diagonal, chain.coupling, state.factor)
        highest = decompose(chain, state)
        bound = motion.highest_frequency(case)
        assert highest <= bound * (1 + 1e-12)
        if case is equal and height == 40:
            assert highest > 0.97 * bound


def test_rk4_is_unstable_beyond_the_bound():
    """A tower that stays touching, just below the bound and 3 % above the true one."""
    case = Tower(height=40, law="overlap", start="preloaded", speed=1e-6)
    bound = motion.largest_step(case)
    run = rk4.run(case, 400 * bound, step=0.99 * bound)
    assert run.energy.max() - run.energy[0] < 1e-12
    with pytest.raises(RequestError, match=r"step = .*must be .*less than 0\.00141421"):
        rk4.run(case, 400 * bound, step=1.03 * bound)
