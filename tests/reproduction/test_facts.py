import math
from dataclasses import replace

import numpy as np
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
        ("{x:.2f} m", "1.50, -0.25 m"),
        ("off by {x[1]:bound}", "off by -2e-01"),
        ("{small:bound}", "less than 1e-12"),
        ("{names}", "one, two"),
        ("{at[19] / 2:.1f} of {len(x)}", "1.5 of 2"),
        ("it grows at 1: {x[0] > 1}, at 0: {holds}", "it grows at 1: yes, at 0: no"),
    ],
)
def test_numbers_are_put_into_sentences(sentence, said):
    numbers = {"x": [1.5, -0.25], "small": 3e-17, "names": ["one", "two"], "at": {19: 3.0}}
    numbers["holds"] = np.bool_(False)  # as numpy compares
    assert fill_in(sentence, numbers) == said


def test_a_number_that_is_missing_is_an_error():
    with pytest.raises(NameError, match="x"):
        fill_in("{x:.2f} m", {"y": math.pi})
