"""The whole impulse table within the time promised; run with ``pytest -m benchmark -s``."""

from __future__ import annotations

import time

import pytest

from harness.cases.tower.impulse import impulse_angles
from harness.observables.tower import WINDOWS

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("solver", ["rk4", "exact"])
def test_whole_table(solver):
    """19 heights, 6 runs, 2 laws, 3 windows; compiled already."""
    impulse_angles(heights=(1, 2), stiffnesses=(1e6,), speeds=(2.0,), solver=solver)
    begin = time.perf_counter()
    frame = impulse_angles(windows=WINDOWS, solver=solver)
    spent = time.perf_counter() - begin
    print(f"\n{solver}: {len(frame)} rows in {spent:.2f} s")
    assert len(frame) == 19 * 6 * 2 * 3
    assert spent < 10.0
