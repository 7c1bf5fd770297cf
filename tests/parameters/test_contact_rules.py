"""The rules in which codes differ have one name and one default each."""

import pytest

from harness.errors import RequestError
from harness.parameters.rules import Rules


@pytest.mark.parametrize("name", list(Rules.model_fields))
def test_a_rule_that_is_not_known_is_named_with_those_that_are(name):
    default = getattr(Rules(), name)
    allowed = "a valid number" if isinstance(default, float) else f".*{default}"
    with pytest.raises(RequestError, match=rf"^{name} = 'other': must be {allowed}"):
        Rules(**{name: "other"})
