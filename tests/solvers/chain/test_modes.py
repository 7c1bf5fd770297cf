"""The modes of a contact set against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from harness.parameters.tower import Tower
from harness.solvers.chain.exact import decompose
from harness.solvers.chain.forces import factorise
from harness.solvers.chain.motion import assemble
from tests.theory import closed_forms


@pytest.mark.parametrize("height", [1, 2, 7, 30])
def test_modes_of_the_overlap_tower(height):
    case = Tower(height=height, law="overlap")
    chain = assemble(case)
    n = height
    closed, factor = np.ones(n, bool), np.zeros((3, n))
    factorise(closed, chain.diagonal, chain.beside, factor)
    shapes, frequency, first = np.zeros((n + 1, n + 1)), np.zeros(n + 1), np.zeros(n + 1)
    highest = decompose(chain, closed, factor, shapes, frequency, first)
    expected = closed_forms.overlap_modes(height, case.omega)
    assert frequency[:n] == pytest.approx(expected, rel=1e-10)
    assert highest == pytest.approx(expected[-1], rel=1e-10)
