import pytest

from harness.comparison.ledger import Ledger
from harness.verbs.reproduction.ledger import statements


@pytest.fixture(scope="session")
def ledger():
    """Return the whole ledger, without an engine."""
    return Ledger(tuple(statements()))
