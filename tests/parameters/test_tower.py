from __future__ import annotations

import math

import pytest

from harness.errors import RequestError
from harness.parameters.tower import Tower


def test_defaults_are_the_source():
    tower = Tower()
    assert (tower.mass, tower.diameter, tower.stiffness) == (1.0, 1.0, 1e6)
    assert (tower.speed, tower.gravity, tower.base) == (2.0, 9.81, "fixed")
    assert tower.omega == 1000.0
    assert tower.particles == 2


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"height": 0}, "height = 0"),
        ({"height": 1.5}, "height = 1.5"),
        ({"height": True}, "height = True"),
        ({"mass": 0.0}, "mass = 0.0"),
        ({"mass": math.nan}, "mass = nan"),
        ({"stiffness": -1.0}, "stiffness = -1.0"),
        ({"stiffness": math.inf}, "stiffness = inf"),
        ({"diameter": 0.0}, "diameter = 0.0"),
        ({"speed": -2.0}, "speed = -2.0"),
        ({"gravity": math.nan}, "gravity = nan"),
        ({"law": "hertz"}, "law = 'hertz'"),
        ({"height": 3, "mass": (1.0, 2.0)}, "mass: 2 values"),
        ({"height": 1, "mass": (1.0, -2.0)}, "mass"),
        ({"start": "gapped"}, "gap = 0.0"),
        ({"gap": 0.1}, "gap = 0.1"),
        ({"start": "preloaded", "base": "free"}, "preloaded"),
        ({"colour": 1}, "colour"),
    ],
)
def test_bad_values_are_named(values, said):
    with pytest.raises(RequestError, match=said) as error:
        Tower(**values)
    assert "\n" not in str(error.value)


def test_contact_time_needs_speed_or_gravity():
    with pytest.raises(RequestError, match="speed"):
        _ = Tower(speed=0.0, gravity=0.0).contact_time
    assert Tower(speed=0.0).contact_time == pytest.approx(2 * math.pi / 1000)
    assert Tower(gravity=0.0).contact_time == pytest.approx(math.pi / 1000)


def test_unequal_particles():
    tower = Tower(height=2, mass=(1.0, 2.0, 3.0))
    assert tower.each("mass") == (1.0, 2.0, 3.0)
    assert Tower(height=2).each("diameter") == (1.0, 1.0, 1.0)


def test_gamma():
    assert Tower().gamma == pytest.approx(9.81 / (2 * 1000))
    assert Tower(speed=0.0).gamma == math.inf


@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_a_tower_that_its_own_weight_crushes_is_refused(law):
    with pytest.raises(RequestError, match=r"lowest contact by 98.1 % of a diameter: must be at"):
        Tower(height=100_000, start="preloaded", law=law)
    assert Tower(height=25_000, start="preloaded", law=law).particles == 25_001


def test_a_stiffness_whose_inverse_overflows_is_refused():
    with pytest.raises(RequestError, match="stiffness = 1e-308 N/m: is too small"):
        _ = Tower(stiffness=1e-308).contact_time
    assert Tower(stiffness=1e-307).contact_time > 0


def test_a_mass_whose_frequency_overflows_is_named():
    with pytest.raises(
        RequestError, match=r"mass = 1e-308 kg: cannot go with stiffness = 10000000000.0 N"
    ):
        _ = Tower(mass=1e-308, stiffness=1e10).contact_time
    assert Tower(mass=1e-300).contact_time > 0
