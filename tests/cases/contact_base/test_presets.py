"""Sets of parameters of the literature: all can be stated, and give what MFiX's archive holds."""

import math

import pytest

from harness.cases.registry import get_case
from harness.errors import RequestError
from harness.parameters.contact_rules import Rules
from harness.workflows.case_run import run

CASES = ("head-on", "oblique", "spin", "bounce", "stacked", "slip-to-roll")
SETS = [(name, preset) for name in CASES for preset in get_case(name).presets]


@pytest.mark.parametrize(("name", "preset"), SETS)
def test_each_can_be_stated(name, preset):
    case = get_case(name)
    expected = case.expected(case.presets[preset], Rules())
    assert all(math.isfinite(one.value) for one in expected.values())


@pytest.mark.parametrize(
    ("angle", "rebound", "spin", "width"),
    [
        # MFiX 21.3.2, tests/dem/DEM05/AUTOTEST, linear spring, sphere on wall: POST_ALPHA.dat [deg]
        # and POST_OMEGA.dat [rad/s]; where it sticks in between, its first-order scheme at a
        # fiftieth of the contact is off by more than where it slides throughout
        (10.0, 6.5953, 231.9435, 0.03),
        (20.0, 12.2112, 538.0793, 0.012),
        (30.0, 21.4755, 618.8437, 2e-4),
        (45.0, 39.2091, 505.7470, 2e-4),
        (60.0, 57.1372, 357.9511, 2e-4),
    ],
)
def test_oblique_impacts_are_those_of_the_archive_of_mfix(angle, rebound, spin, width):
    case = get_case("oblique")
    parameters = case.presets["mfix-dem05"].replace(angle=angle)
    # MFiX takes the lever down to the wall
    found = case.expected(parameters, Rules(wall_lever="height"))
    tangent = math.tan(math.radians(angle)) * found["tangential_ratio"].value
    measured = math.degrees(math.atan(tangent / found["normal_restitution"].value))
    along = parameters.velocity[0]
    turned = found["spin_ratio"].value * along / parameters.radius
    assert measured == pytest.approx(rebound, rel=width)
    assert turned == pytest.approx(spin, rel=width)


@pytest.mark.parametrize(
    ("restitution", "height"), [(0.9, 0.41930671), (0.8, 0.34806323), (0.5, 0.18685958)]
)
def test_heights_of_the_first_bounce_are_those_of_the_archive_of_mfix(restitution, height):
    # DEM02/AUTOTEST/POST_HEIGHT.dat, heights of the centre: a first-order scheme at a fiftieth of
    # the contact is off by up to that part of what is lost
    case = get_case("bounce")
    parameters = case.presets["mfix-dem02"].replace(restitution=restitution)
    ratio = case.expected(parameters, Rules())["rebound_ratio"].value
    reached = parameters.radius + parameters.height * ratio
    lost = parameters.height * (1.0 - restitution**2)
    assert reached == pytest.approx(height, abs=lost / 50.0)


def test_opposite_spins_do_not_slip():
    case = get_case("spin")
    found = case.expected(case.presets["chung-ooi-7"], Rules())
    assert found["spin_ratio"].value == pytest.approx(1.0, abs=1e-12)
    assert found["velocity_ratio"].value == pytest.approx(0.0, abs=1e-12)


def test_a_wall_has_no_spin():
    with pytest.raises(RequestError, match=r"partner_spin = 3\.0: partner = 'wall' has none"):
        run("spin", {"partner_spin": "3"})
