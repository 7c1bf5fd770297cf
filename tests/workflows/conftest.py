import pytest

from harness.cases import registry
from harness.engines import registry as engines
from tests.workflows import doubles


@pytest.fixture
def registered(monkeypatch):
    """Have the cases and engines of ``doubles`` alone; ``bounce`` is the one that qualifies."""
    register(monkeypatch)
    return doubles


def register(patch):
    patch.setattr(registry, "GROUPS", doubles.GROUPS)
    patch.setattr(registry, "DEFAULT", ("bounce",))
    for module in ("cases.registry", "workflows.session", "workflows.verification"):
        patch.setattr(f"harness.{module}.QUALIFYING", ("bounce",))
    patch.setattr("harness.workflows.lists.DEFAULT_CASES", ("bounce",))
    patch.setattr(engines, "ENGINES", doubles.ENGINES)
    patch.setattr("harness.workflows.lists.ENGINES", doubles.ENGINES)
