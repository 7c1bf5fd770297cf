"""The modes of a contact set against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from harness.parameters.tower import Tower
from harness.solvers.chain.exact import decompose, modal_state
from harness.solvers.chain.forces import factorise
from harness.solvers.chain.motion import assemble
from tests.theory import closed_forms


@pytest.mark.parametrize("height", [1, 2, 7, 30])
def test_modes_of_the_overlap_tower(height):
    case = Tower(height=height, law="overlap")
    chain = assemble(case)
    n = height
    state = modal_state(chain, np.ones(n, bool))
    factorise(state.closed, chain.diagonal, chain.coupling, state.factor)
    highest = decompose(chain, state)
    expected = closed_forms.overlap_modes(height, case.omega)
    assert state.frequency[:n] == pytest.approx(expected, rel=1e-10)
    assert highest == pytest.approx(expected[-1], rel=1e-10)
