import pytest

from harness.reproduction.claims import Ledger
from harness.reproduction.ledger import statements


@pytest.fixture(scope="session")
def ledger():
    """Return the whole ledger, without an engine."""
    return Ledger(tuple(statements()))
