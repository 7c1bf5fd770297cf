"""The engine of another package goes through the suite, as its own tests would have it."""

import sys
from pathlib import Path

import pytest

from harness.testing import engine_checks

HERE = Path(__file__).parent


def small_dem():
    """Open the engine of the example package, which need not be installed."""
    sys.path.insert(0, str(HERE / "small_dem"))
    try:
        from small_dem.engine import SmallDem
    finally:
        sys.path.remove(str(HERE / "small_dem"))
    return SmallDem()


@pytest.mark.parametrize("check", engine_checks(small_dem))
def test_small_dem(check):
    check()
