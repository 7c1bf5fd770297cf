"""Engines that are here, open, by name."""

import os

import pytest

from harness.engines.registry import engine_class
from harness.errors import EngineMissingError, RequestError


@pytest.fixture(scope="module")
def opened():
    """Return engines that are open, or why they are not here."""
    engines = {}
    yield engines
    for engine in engines.values():
        if not isinstance(engine, str):
            engine.close()


@pytest.fixture
def code(request, opened):
    """Return the engine of a code; skip, with the reason, where there is none."""
    name = request.param
    if name not in opened:
        program = os.environ.get("DEM_HARNESS_MFIX") if name == "mfix" else None
        try:
            opened[name] = engine_class(name)(
                **({"program": program} if program else {}), workers=2
            )
            opened[name].identify()
        except (EngineMissingError, RequestError) as error:
            opened[name] = str(error)
    if isinstance(opened[name], str):
        pytest.skip(opened[name])
    return opened[name]
