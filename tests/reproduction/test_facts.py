import math

import pytest

from harness.reproduction.claims import ClaimStatus, claim_of_facts
from harness.reproduction.source import Source
from harness.reproduction.wording import told

SOURCE = Source("fig-9", "figure 9", "it falls", facts=("a is {a:.1f}", "b"), finds="{facts}{more}")


@pytest.mark.parametrize(
    ("facts", "more", "said"),
    [
        ([True, False, (True, "c")], "", "Agrees: a is 2.0; c. Does not agree: b."),
        ([True], " More.", "Agrees: a is 2.0. More."),
        ([False], "", "Does not agree: a is 2.0."),
    ],
)
def test_what_agrees_comes_first(facts, more, said):
    row = claim_of_facts(SOURCE, facts, more=more, a=2.0)
    assert row.computed == said
    assert (row.status is ClaimStatus.REPRODUCED) == (False not in facts)


def test_a_statement_may_hold_without_all_of_its_facts():
    row = claim_of_facts(SOURCE, [True, False], holds=True, more="", a=2.0)
    assert row.status is ClaimStatus.REPRODUCED


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("{x:.2f} m", "1.50, -0.25 m"),
        ("off by {x[1]:bound}", "off by -2e-01"),
        ("{small:bound}", "less than 1e-12"),
        ("{names}", "one, two"),
        ("{at[19]:.1f}", "3.0"),
    ],
)
def test_numbers_are_put_into_sentences(sentence, said):
    numbers = {"x": [1.5, -0.25], "small": 3e-17, "names": ["one", "two"], "at": {19: 3.0}}
    assert told(sentence, numbers) == said


def test_a_number_that_is_missing_is_an_error():
    with pytest.raises(KeyError, match="x"):
        told("{x:.2f} m", {"y": math.pi})
