import math

import pytest

from harness.cases.tower.verification import EngineTower


def test_errors_of_a_tower_are_relative():
    tower = EngineTower("yade", 4, 1e4, 101.0, 100.0, 1.98, 2.0)
    assert tower.peak_error == pytest.approx(0.01)
    assert tower.impulse_error == pytest.approx(-0.01)
    assert math.isnan(EngineTower("mfix", 4, 1e4, 101.0, 100.0).impulse_error)
