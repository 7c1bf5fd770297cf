"""Open engines by name."""

import pytest

from harness.engines.registry import engine_class
from harness.errors import EngineMissingError


@pytest.fixture(scope="module")
def code(request):
    """Yield the engine of a code; skip, with the reason, where it is not installed."""
    try:
        with engine_class(request.param)(workers=2) as engine:
            engine.identify()
            yield engine
    except EngineMissingError as reason:
        pytest.skip(str(reason))
