"""The committed reproduction is what the code makes, statement by statement."""

from pathlib import Path

import pytest

from harness.reproduction.run import reproduce
from harness.workflows import diff

COMMITTED = Path(__file__).parents[2] / "reports" / "reproduction"


@pytest.mark.slow
@pytest.mark.live
def test_the_committed_reproduction_is_what_the_code_makes_now():
    assert diff(COMMITTED, reproduce()).changes.empty
