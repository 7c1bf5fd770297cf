import math

import pytest

from harness.cases.drop.parameters import Drop
from harness.errors import RequestError


def test_the_steps_cover_the_duration_in_whole_samples():
    case = Drop(steps_per_contact=50.0, duration=2.5, every=40)
    assert case.steps == 160
    assert case.step * 50.0 == case.contact_time == math.pi * math.sqrt(case.mass / 1e6)
    assert Drop(steps_per_contact=50.0, duration=2.0).steps == 100


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"gap": -0.3}, "gap = -0.3 m"),
        ({"every": 0}, "every = 0"),
        ({"duration": 0.0}, "duration = 0.0"),
        ({"gravity": -1.0}, "gravity = -1.0 m/s2"),
    ],
)
def test_what_is_not_allowed_is_named(values, words):
    with pytest.raises(RequestError, match=words):
        Drop(**values)
