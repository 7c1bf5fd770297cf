"""Cases of single contacts beyond impacts: what they refuse, and what moves them."""

import pytest

from harness.cases.registry import get_case
from harness.errors import RequestError
from harness.workflows.case_runs import run
from tests.cases.contact_base.limits import limits


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("incline-rest", {"rolling": "none"}, r"rolling = 'none': must be sds in this case"),
        ("incline-rest", {"rolling_friction": "0"}, r"rolling_friction = 0\.0: must be greater"),
        ("collision", {"partner": "wall"}, r"partner = 'wall': must be one of sphere in this case"),
        ("collision", {"partner_share": "11"}, r"partner_share = '11': must be .*equal to 10"),
        ("collision", {"partner_radius": "1e5"}, r"partner_radius = .*: must be"),
        ("heat", {"conductance": "0"}, r"conductance = '0' .*: must be greater than 0"),
        ("heat", {"partner_temperature": "400"}, r"partner_temperature = 400\.0 K: must not be"),
        ("heat", {"normal": "jkr"}, r"normal = 'jkr': must be one of hooke, hertz in this case"),
        ("heat", {"overlap": "1"}, r"overlap = 1\.0 m: must be between"),
        ("heat", {"partner": "frozen"}, r"partner = 'frozen': must be one of wall, sphere"),
        ("drag", {"drag": "0"}, r"drag = '0' kg/s: must be greater than or equal to 1e-12"),
        ("drag", {"partner": "sphere"}, r"partner = 'sphere': must be one of wall in this case"),
        ("drag", {"duration": "1e9"}, r"duration = 1000000000\.0: must be at most"),
        ("moving-wall", {"moves": "up"}, r"moves = 'up': must be 'shear', 'along' or 'across'"),
        ("moving-wall", {"moves": "across", "normal": "hertz"}, r"normal = 'hertz': must be a lin"),
        (
            "moving-wall",
            {"moves": "along", "acceleration": "1e3"},
            r"acceleration = 1000\.0: must be",
        ),
        (
            "curved-wall",
            {"wall": "rim", "normal": "hertz"},
            r"normal = 'hertz': must be one of hooke",
        ),
        ("curved-wall", {"wall_radius": "0.01"}, r"wall_radius = 0\.01 m: must be at least 0\.011"),
        ("curved-wall", {"angle": "80"}, r"angle = '80' deg: must be .*equal to 60"),
        ("incline-rest", {"angle": "90"}, r"angle = '90' deg: must be .*less than 90"),
    ],
)
def test_values_without_a_meaning_are_refused(name, settings, message):
    with pytest.raises(RequestError, match=message):
        run(name, settings)


@pytest.mark.parametrize("fault", ["partner_density", "partner_radius", "partner_share"])
def test_another_partner_or_frame_is_seen(fault):
    """What is relative stays in every frame; masses and sizes are those that were asked for."""
    case = get_case("collision")
    systems = {one.system: one.parameters for one in case.trials("default", case.submodels[:1])}
    name = "size ratio 10" if fault == "partner_radius" else "unequal densities"
    parameters = systems[name]
    changed = parameters.replace(**{fault: 1.01 * getattr(parameters, fault)})
    before, after = (limits(case, one)["tangential_ratio"].value for one in (parameters, changed))
    assert (abs(after - before) < 1e-9) == (fault == "partner_share")
    if fault != "partner_share":
        assert abs(after - before) > 1e-5
