import pytest

from harness.cases import registry
from harness.engines import registry as engines
from tests.workflows import doubles


@pytest.fixture
def registered(monkeypatch):
    """Have the case and the engines of ``doubles`` alone, the case as the one that qualifies."""
    monkeypatch.setattr(registry, "GROUPS", doubles.GROUPS)
    monkeypatch.setattr(registry, "DEFAULT", ("bounce",))
    for module in ("harness.cases.registry", "harness.workflows.session"):
        monkeypatch.setattr(f"{module}.QUALIFYING", ("bounce",))
    monkeypatch.setattr(engines, "ENGINES", doubles.ENGINES)
