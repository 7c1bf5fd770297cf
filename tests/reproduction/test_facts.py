import pytest

from harness.reproduction.facts import agreement, all_hold


@pytest.mark.parametrize(
    ("facts", "remark", "said"),
    [
        ([(True, "a"), (False, "b"), (True, "c")], "", "Agrees: a; c. Does not agree: b."),
        ([(True, "a")], "More.", "Agrees: a. More."),
        ([(False, "a")], "", "Does not agree: a."),
    ],
)
def test_what_agrees_comes_first(facts, remark, said):
    assert agreement(facts, remark) == said
    assert all_hold(facts) == all(holds for holds, _ in facts)
