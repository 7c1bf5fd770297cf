from dataclasses import replace

import pytest

from harness.reproduction.claims import ClaimStatus, Source, claim_of_facts, fill_in

SOURCE = Source(
    "fig-9",
    "figure 9",
    "it falls",
    facts=(("a > 1", "a is {a:.1f}"), ("b", "b")),
    finds="{facts}{more}",
)


@pytest.mark.parametrize(
    ("a", "b", "others", "more", "said"),
    [
        (2.0, False, [(True, "c")], "", "Agrees: a is 2.0; c. Does not agree: b."),
        (2.0, True, [], " More.", "Agrees: a is 2.0; b. More."),
        (0.5, False, [], "", "Does not agree: a is 0.5; b."),
    ],
)
def test_what_agrees_comes_first(a, b, others, more, said):
    row = claim_of_facts(SOURCE, others, more=more, a=a, b=b)
    assert row.computed == said
    assert (row.status is ClaimStatus.REPRODUCED) == ("not agree" not in said)


@pytest.mark.parametrize(("a", "status"), [(2.0, "reproduced"), (0.5, "not reproduced")])
def test_a_statement_may_hold_without_all_of_its_facts(a, status):
    lenient = replace(SOURCE, holds="a > 1")
    assert claim_of_facts(lenient, more="", a=a, b=False).status == status


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        (
            "{x:.2f} m, off by {x[1]:bound}, {small:bound}",
            "1.50, -0.25 m, off by -2e-01, less than 1e-12",
        ),
        ("{at[19] / 2:.1f} of {len(x)}: {x[0] > 1}", "1.5 of 2: yes"),
    ],
)
def test_numbers_are_put_into_sentences(sentence, said):
    assert fill_in(sentence, {"x": [1.5, -0.25], "small": 3e-17, "at": {19: 3.0}}) == said
