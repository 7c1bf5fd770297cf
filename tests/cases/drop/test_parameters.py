import math

import pytest

from harness.cases.drop.case import Drop
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
        ({"diameter": 1e-15, "speed": 1.0}, "press itself 3.16e-11 diameters in"),
        ({"speed": 1e300}, "press itself 1e\\+297 diameters in"),
        ({"gravity": 1e300}, "gravity = 1e\\+300 m/s2: must be from 2.2e-10 to 0.5"),
        ({"stiffness": 5e-324}, "stiffness = 4.94066e-324 N/m: .* beyond floating point"),
        ({"diameter": 1e300}, "diameter = 1e\\+300 m, .* beyond floating point"),
        ({"diameter": 0.1, "gap": -0.03}, "gap = -0.03 m: must be greater than -0.025 m"),
    ],
)
def test_what_is_not_allowed_is_named(values, words):
    with pytest.raises(RequestError, match=words):
        Drop(**values)
