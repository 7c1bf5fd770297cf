"""Towers recorded with MFiX: their tables."""

import numpy as np
import pytest

from harness.cases.grain import steps_of_factor
from harness.cases.tower.engine_checks import RECORDED_CASE, UNDAMPED, recorded_tower
from harness.errors import RequestError


@pytest.mark.parametrize(("factor", "between"), [(50, 1), (5000, 100)])
def test_towers_come_with_the_steps_of_their_factor(factor, between):
    table = recorded_tower(factor)
    assert table.dtype.names == ("t_s", "F_top_N2", "F_top_N3", "F_top_N5", "F_top_N10")
    step = RECORDED_CASE.contact_period / steps_of_factor(factor, UNDAMPED)
    assert np.diff(table["t_s"]) == pytest.approx(between * step, abs=1e-8)


def test_towers_of_other_steps_were_not_recorded():
    with pytest.raises(RequestError, match="f = 500: no tower was recorded"):
        recorded_tower(500)
    with pytest.raises(RequestError, match=r"must be 50 or 5000"):
        recorded_tower(500)
