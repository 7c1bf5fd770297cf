import pytest

from harness.observables.reference import ReferencePoints
from harness.reproduction.claims import ClaimStatus, Ledger
from harness.reproduction.figure_data.compute import figure_data
from harness.reproduction.source import FIGURES


@pytest.fixture(scope="module")
def found():
    return figure_data(None)


def test_one_statement_a_figure_in_the_order_of_the_source(found):
    keys = [statement.source.key for statement in found.statements]
    assert keys == [f"fig-{number}" for number in range(1, 17)] == list(FIGURES)
    Ledger(found.statements)
    for statement in found.statements:
        assert statement.computed
        if statement.status is ClaimStatus.UNTESTABLE:
            assert statement.why
        else:
            assert statement.computed.startswith(("Agrees: ", "Does not agree: "))
            assert statement.evidence == FIGURES[statement.source.key].evidence


def test_the_same_statements_twice(found):
    assert figure_data(None).statements == found.statements


def test_progress_and_the_users_points():
    heard = []
    points = ReferencePoints("made-up.csv", (2.0, 12.0), (9.0, 6.5))
    found = figure_data(None, lambda *stage: heard.append(stage), recorded={}, reference=points)
    assert [done for _, done, _ in heard] == list(range(1, heard[0][2] + 1))
    assert found.motions == ()
    assert found.reference is points
    assert found.statements[0].status is ClaimStatus.REPRODUCED
    assert "made-up.csv" in found.statements[10].computed
