import pytest

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


def test_progress():
    heard = []
    found = source_figures(None, lambda *stage: heard.append(stage), paths={})
    assert [done for _, done, _ in heard] == list(range(1, heard[0][2] + 1))
    assert found[3].draw is None  # no runs
