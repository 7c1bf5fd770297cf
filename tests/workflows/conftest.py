import pytest

from harness.cases import registry
from harness.engines import registry as engines
from tests.workflows import doubles


@pytest.fixture
def registered(monkeypatch):
    """Have the case and the engines of ``doubles`` alone, the case as the one that qualifies."""
    monkeypatch.setattr(registry, "GROUPS", doubles.GROUPS)
    monkeypatch.setattr(registry, "DEFAULT", ("bounce",))
    for module in ("registry", "qualification"):
        monkeypatch.setattr(f"harness.workflows.{module}" if module != "registry" else
                            "harness.cases.registry", "QUALIFYING", ("bounce",), raising=False) \
            if module == "registry" else None
    monkeypatch.setattr("harness.workflows.session.QUALIFYING", ("bounce",))
    monkeypatch.setattr(engines, "ENGINES", doubles.ENGINES)
