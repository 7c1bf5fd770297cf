from __future__ import annotations

import numpy as np
import pytest

from harness.cases.tower.comparison import step_convergence
from harness.errors import RequestError
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4

STEPS = np.geomspace(50, 3200, 13)


def study(tower, duration, steps=STEPS, solve=rk4.run):
    """Return the convergence of RK4 to the exact solution; ``duration`` in t0."""
    seconds = duration * tower.contact_time
    reference = exact.run(tower, seconds, samples=8000)
    return step_convergence(
        lambda n: solve(tower, seconds, steps_per_contact=n), reference, steps
    )  # fmt: skip


@pytest.mark.parametrize(
    ("law", "height", "duration"),
    # in the overlap law all contacts are closed until the grain leaves, at 0.8 to 0.9 t0;
    # in the deformable law one contact alone until 0.42 t0
    [("overlap", n, 0.8) for n in (1, 2, 3, 5, 9)] + [("deformable", n, 0.4) for n in (1, 2, 9)],
)
def test_fourth_order_while_contacts_stay(law, height, duration):
    found = study(Tower(height=height, law=law), duration)
    assert found.peak_order.value == pytest.approx(4, abs=0.05)
    assert found.l2_order.value == pytest.approx(4, abs=0.05)
    low, high = found.peak_order.interval
    assert high - low < 0.1


@pytest.mark.parametrize(("law", "height"), [("overlap", 2), ("deformable", 2), ("deformable", 4)])
def test_second_order_across_onsets(law, height):
    found = study(Tower(height=height, law=law), 1.6)
    for order in (found.peak_order, found.l2_order, found.velocity_order):
        low, high = order.interval
        assert low <= 2 <= high < 3


def test_rounding_enters_no_order():
    found = study(Tower(height=1, law="overlap"), 0.8, np.geomspace(100, 25600, 9))
    told = found.peak_error > found.floor
    assert 3 <= told.sum() < told.size
    assert found.peak_order.value == pytest.approx(4, abs=0.05)
    only = study(Tower(height=1, law="overlap"), 0.8, [12800, 25600, 51200])
    assert np.isnan(only.peak_order.value)
    assert only.to_json()["peak_force_order"] is None


def test_what_has_no_order_is_refused():
    tower = Tower(height=2)
    with pytest.raises(RequestError, match="at least 3"):
        study(tower, 1.6, [100, 200, 200])
    with pytest.raises(RequestError, match="no step"):
        study(tower, 1.6, [1, 2, 3], lambda case, end, steps_per_contact: exact.run(case, end))  # noqa: ARG005
