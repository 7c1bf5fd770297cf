import pytest

from harness.cases import registry
from harness.engines import registry as engines
from tests.workflows import doubles


@pytest.fixture
def registered(monkeypatch):
    """Have the cases and engines of ``doubles`` alone; ``bounce`` is the one that qualifies."""
    monkeypatch.setattr(registry, "GROUPS", doubles.GROUPS)
    monkeypatch.setattr(registry, "DEFAULT", ("bounce",))
    for module in ("harness.cases.registry", "harness.workflows.session"):
        monkeypatch.setattr(f"{module}.QUALIFYING", ("bounce",))
    monkeypatch.setattr("harness.workflows.lists.DEFAULT_CASES", ("bounce",))
    monkeypatch.setattr(engines, "ENGINES", doubles.ENGINES)
    monkeypatch.setattr("harness.workflows.lists.ENGINES", doubles.ENGINES)
    return doubles
