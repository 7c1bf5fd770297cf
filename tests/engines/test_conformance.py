"""Every engine of this package goes through the suite that other packages' engines go through."""

import os
from functools import cache, partial

import pytest

from harness.engines.registry import ENGINES, engine_class
from harness.errors import EngineMissingError, RequestError
from harness.testing import engine_checks


def _opened(name):
    program = os.environ.get("DEM_HARNESS_MFIX") if name == "mfix" else None
    return partial(engine_class(name), **({"program": program} if program else {}))


def _marks(name, check):
    """Leave codes to the slow suite; other fast tests see what the rest of LAMMPS's do."""
    if name == "reference":
        return []
    is_fast = (name, check.__name__) == ("lammps", "refuses_what_it_does_not_state")
    return [pytest.mark.live] if is_fast else [pytest.mark.live, pytest.mark.slow]


CHECKS = [
    pytest.param(name, check, marks=_marks(name, check), id=f"{name}-{check.__name__}")
    for name in ENGINES
    for check in engine_checks(_opened(name))
]


@cache
def _missing(name):
    """Return why an engine cannot be tested here; it is asked once, not for each check."""
    try:
        with _opened(name)() as engine:
            engine.identify()
    except (EngineMissingError, RequestError) as error:
        return f"{name}: {error}"
    return ""


@pytest.mark.parametrize(("name", "check"), CHECKS)
def test_engine(name, check):
    if _missing(name):
        pytest.skip(_missing(name))
    check()
