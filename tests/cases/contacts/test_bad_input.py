"""What contact cases refuse: values without a meaning, in a line that names what is allowed."""

import pytest

from harness.errors import RequestError
from tests.cases.contacts.common import CASES, case_named

STRONG = {"damping": "velocity", "damping_coefficient": 1e5}
OLD = {"interface": "old"}
MDR = {"normal": "mdr", "youngs_modulus": 1e8}
USUAL = {  # presets of this package
    "bowl", "cools", "dmt", "elastic", "falls", "jkr", "mdr, adhesion", "rests", "rolls", "shear",
    "spins", "usual",
}  # fmt: skip
REFUSED = [
    ("bounce", {"height": 1e9}, "height = 1000000000.0 m: must be between "),
    ("bounce", {"height": 1e-9}, "height = 1e-09 m: must be between "),
    ("bounce", {"gravity": 1e8}, "gravity = 100000000.0 m/s2: must be between 0 and "),
    ("bounce", {"partner": "sphere"}, "partner = 'sphere': must be one of wall, frozen"),
    ("head-on", {"speed": "1e-300"}, "speed = '1e-300' m/s: must be greater than or equal to"),
    ("head-on", {"speed": 1e-8}, "speed = 1e-08 m/s: must be between "),
    ("head-on", {"speed": 1e4}, "speed = 10000.0 m/s: must be between "),
    ("head-on", {"radius": "1e-300"}, "radius = '1e-300' m: must be greater than or equal to"),
    ("head-on", {"density": "1e300"}, "density = '1e300' kg/m3: must be "),
    ("head-on", {"normal": "hertz", "poisson_ratio": "0.6"}, "poisson_ratio = '0.6'"),
    ("head-on", {**STRONG, "restitution": 0.5}, "restitution = 0.5: belongs to damping"),
    ("head-on", {"partner_radius": 0.02}, "partner = 'wall' has none"),
    ("head-on", {"partner_density": 5e3}, "partner_density = 5000.0: partner = 'wall' has none"),
    ("head-on", {"materials_as": "mixed"}, "materials_as = 'mixed': needs two materials"),
    ("head-on", {"partner_youngs_modulus": 1e8}, "partner_youngs_modulus = 100000000.0: belongs"),
    ("head-on", {**OLD, "rolling": "sds", "rolling_stiffness": 1.0, "rolling_damping": 0.0,
                 "rolling_friction": 0.1}, "interface = 'old': states"),
    ("head-on", {**OLD, "tangential": "linear_history"}, "interface = 'old': states"),
    ("head-on", {"partner": "box"}, "partner = 'box'"),
    ("head-on", {"steps_per_contact": 1}, "steps_per_contact"),
    ("head-on", {**MDR, "yield_stress": 10.0}, "yield_stress = 10.0 Pa: must be between"),
    ("head-on", {**MDR, "bulk_response": True, "damping": "mdr", "damping_coefficient": 0.1},
     "damping = 'mdr': must be none or velocity"),
    ("head-on", {**MDR, "surface_energy": 0.5, **STRONG, "damping_coefficient": 1.0},
     "surface_energy = 0.5: normal = mdr is stated with it alone"),
    ("head-on", {**MDR, "yield_stress": 1e7, "partner": "sphere", "partner_radius": 0.02},
     "partner_radius = 0.02: normal = mdr with yield"),
    ("head-on", {"bulk_response": True}, "bulk_response = True"),
    ("head-on", {"heat": "radius", "conductance": 1.0}, "heat = 'radius': must be none"),
    ("head-on", STRONG, "damping_coefficient = 100000.0: must be between 0 and .* clipped"),
    ("head-on", {"partner": "sphere", "partner_radius": 1e-9}, "partner_radius = 1e-09 m"),
    ("oblique", {"angle": 1e-300}, "angle = 1e-300 deg: must be between 1e-06 and 90"),
    ("oblique", {"tangential_stiffness": 1e20},
     r"tangential_stiffness = 1e\+20: must be at most .*, or needs steps_per_contact of"),
    ("oblique", {"friction": 100.0, **STRONG, "damping_coefficient": 1.0},
     "friction = 100.0: must be at most 50 with steps_per_contact = 1000"),
    ("oblique", {"friction": "-0.1"}, "friction = '-0.1': must be greater"),
    ("spin", {"spin": "1e300"}, "spin = '1e300' rad/s: must be "),
    ("spin", {"partner_spin": 3.0}, r"partner_spin = 3\.0: partner = 'wall' has none"),
    ("slip-to-roll", {"friction": 1e-9}, "friction = 1e-09: must be at least 1e-06"),
    ("slip-to-roll", {"partner": "sphere"}, "partner = 'sphere': must be one of wall"),
    ("slip-to-roll", {"speed": 1e9}, "duration = 1.5: must be at most .*: 1e\\+09 steps"),
    ("incline-roll", {"gravity": 1e9}, "gravity = 1000000000.0 m/s2: must be between "),
    ("incline-roll", {"duration": 1e8}, "duration = 100000000.0: must be at most 1e\\+06"),
    ("incline-rest", {"rolling": "none"}, "rolling = 'none': must be sds in this case"),
    ("incline-rest", {"rolling_friction": 0.0}, r"rolling_friction = 0\.0: must be greater"),
    ("incline-rest", {"angle": "90"}, "angle = '90' deg: must be .*less than 90"),
    ("rolling-resistance", {"rolling_damping": 1e9}, "rolling_damping = 1000000000.0: must"),
    ("twist", {"twisting_friction": 0.0}, "twisting_friction = 0.0: must be greater than 0"),
    ("twist", {"twisting_stiffness": 1e9}, "twisting_stiffness = 1000000000.0: must be at"),
    ("stacked", {"partner": "wall"}, "partner = 'wall': must be one of sphere"),
    ("stacked", {"squeeze": 1e-12}, "squeeze = 1e-12: must be between "),
    ("stacked", {"gravity": 1e9}, "gravity = 1000000000.0 m/s2: must be between 0 and "),
    ("stacked", {"upper_density": 0.1}, "upper_density = 0.1 kg/m3: must be between "),
    ("stacked", {"partner_density": 1e4}, "upper_density is that of this case"),
    ("pull-off", {"overlap": 1e-3}, "overlap = 0.001 m: must be between "),
    ("pull-off", {"normal": "hooke"}, "normal = 'hooke': must be one of dmt, jkr, mdr"),
    ("pull-off", {"normal": "mdr", "surface_energy": 0.0}, "normal = mdr needs one, above 0"),
    ("pull-off", {"surface_energy": 1e9}, "surface_energy = 1000000000.0 J/m2"),
    ("prescribed-motion", {"overlap": 0.1}, "overlap = 0.1 m: must be between "),
    ("prescribed-motion", {"partner": "sphere", "shear": 0.01}, "shear = 0.01 m: must be"),
    ("prescribed-motion", {"turned": 0.1}, "turned = 0.1: needs two spheres"),
    ("prescribed-motion", {**STRONG, "damping_coefficient": 1e4}, "duration = 0.001 s: must be"),
    ("collision", {"partner": "wall"}, "partner = 'wall': must be one of sphere in this case"),
    ("collision", {"partner_share": "11"}, "partner_share = '11': must be .*equal to 10"),
    ("collision", {"partner_radius": "1e5"}, "partner_radius = .*: must be"),
    ("lj-units", {"normal": "mdr"}, "normal = 'mdr': must be one of hooke, hertz, dmt, jkr"),
    ("heat", {"conductance": "0"}, "conductance = '0' .*: must be greater than 0"),
    ("heat", {"partner_temperature": 400.0}, r"partner_temperature = 400\.0 K: must not be"),
    ("heat", {"normal": "jkr"}, "normal = 'jkr': must be one of hooke, hertz in this case"),
    ("heat", {"overlap": 1.0}, r"overlap = 1\.0 m: must be between"),
    ("heat", {"partner": "frozen"}, "partner = 'frozen': must be one of wall, sphere"),
    ("drag", {"drag": "0"}, "drag = '0' kg/s: must be greater than or equal to 0.0000"),
    ("drag", {"partner": "sphere"}, "partner = 'sphere': must be one of wall in this case"),
    ("drag", {"duration": 1e9}, r"duration = 1000000000\.0: must be at most"),
    ("moving-wall", {"moves": "up"}, "moves = 'up': must be 'shear', 'along' or 'across'"),
    ("moving-wall", {"moves": "across", "normal": "hertz"}, "normal = 'hertz': must be a lin"),
    ("moving-wall", {"moves": "along", "tangential": "none"}, "tangential = 'none': must have"),
    ("curved-wall", {"wall": "rim", "normal": "hertz"}, "normal = 'hertz': must be one of hooke"),
    ("curved-wall", {"wall_radius": 0.01}, r"wall_radius = 0\.01 m: must be at least 0\.011"),
    ("curved-wall", {"angle": "80"}, "angle = '80' deg: must be .*equal to 60"),
]  # fmt: skip


@pytest.mark.parametrize(("case", "changes", "words"), REFUSED)
def test_values_without_a_meaning_are_refused_in_one_line(case, changes, words):
    chosen = case_named(case)
    with pytest.raises(RequestError, match=words) as error:
        chosen.job(chosen.default.replace(**changes))
    assert "\n" not in str(error.value)


def test_a_plane_that_shakes_the_sphere_off_has_no_closed_form():
    case = case_named("moving-wall")
    with pytest.raises(RequestError, match=r"acceleration = 1000\.0: must be below"):
        case.exact(case.default.replace(moves="along", acceleration=1e3))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_presets_can_be_run_and_published_ones_have_a_source(case):
    for name, parameters in case.presets.items():
        assert case.scene(parameters).steps > 0
        assert (name in case.sources) != (name in USUAL)
