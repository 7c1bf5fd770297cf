"""Yade itself where it is."""

import shutil

import pytest

from harness.engines.yade.engine import Yade


@pytest.fixture(scope="session")
def yade():
    """Return Yade, ready to run; skip with the reason where there is none."""
    if shutil.which("yade") is None:
        pytest.skip("no Yade on PATH")
    with Yade(workers=2) as engine:
        yield engine
