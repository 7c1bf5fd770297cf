import pytest

from harness.observables.reference import ReferencePoints
from harness.reproduction.claims import FIGURES, ClaimStatus, Ledger
from harness.reproduction.run import source_figures


@pytest.fixture(scope="module")
def found():
    return source_figures(None)


def test_one_statement_a_figure_in_the_order_of_the_source(found):
    statements = [figure.statement for figure in found]
    keys = [statement.source.key for statement in statements]
    assert keys == list(FIGURES)
    Ledger(tuple(statements))
    for statement in statements:
        assert statement.computed
        if statement.status is ClaimStatus.UNTESTABLE:
            assert statement.why
        else:
            assert statement.computed.startswith(("Agrees: ", "Does not agree: "))
            assert statement.evidence == FIGURES[statement.source.key].evidence


def test_progress_and_the_users_points():
    heard = []
    points = ReferencePoints("made-up.csv", (2.0, 12.0), (9.0, 6.5))
    found = source_figures(None, lambda *stage: heard.append(stage), paths={}, reference=points)
    assert [done for _, done, _ in heard] == list(range(1, heard[0][2] + 1))
    assert found[3].draw is None  # no runs
    assert found[0].statement.status is ClaimStatus.REPRODUCED
    assert "made-up.csv" in found[10].statement.computed
