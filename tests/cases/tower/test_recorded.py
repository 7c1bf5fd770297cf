"""Towers recorded with MFiX: their cases and their tables."""

import numpy as np
import pytest

from harness.cases.tower.recorded import recorded_tower, recorded_towers
from harness.errors import RequestError


def test_towers_come_with_their_cases():
    towers = recorded_towers()
    assert [(t.factor, t.case.particles) for t in towers] == [
        (factor, particles) for factor in (50, 5000) for particles in (2, 3, 5, 10)
    ]
    for tower in towers:
        between = 1 if tower.factor == 50 else 100
        assert np.diff(tower.time) == pytest.approx(between * tower.step, abs=1e-8)
        column = f"F_top_N{tower.case.particles}"
        assert np.array_equal(tower.force, recorded_tower(tower.factor)[column])


def test_towers_of_other_steps_were_not_recorded():
    with pytest.raises(RequestError, match="f = 500: no tower was recorded"):
        recorded_tower(500)
    with pytest.raises(RequestError, match=r"must be 50 or 5000"):
        recorded_tower(500)
