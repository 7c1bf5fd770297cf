"""What contact cases refuse: values without a meaning, in a line that names what is allowed."""

import pytest

from tests.cases.common import assert_refused
from tests.cases.contacts.common import CASES, case_named, limits

STRONG = {"damping": "velocity", "damping_coefficient": 1e5}
ROLLS = {"rolling": "sds", "rolling_stiffness": 1.0, "rolling_damping": 0.0,
         "rolling_friction": 0.1}  # fmt: skip
MDR = {"normal": "mdr", "youngs_modulus": 1e8}
USUAL = {  # presets of this package
    "bowl", "cools", "dmt", "elastic", "falls", "jkr", "mdr, adhesion", "rests", "rolls", "shear",
    "spins", "usual",
}  # fmt: skip
REFUSED = [
    ("bounce", {"height": 1e9}, "height = 1000000000.0 m: must be between .* overlap"),
    ("bounce", {"height": 1e-9}, "height = 1e-09 m: must be between .* weight"),
    ("incline-roll", {"gravity": 1e9}, "gravity = 1000000000.0 m/s2: must be between "),
    ("bounce", {"partner": "sphere"}, "partner = 'sphere': must be wall or frozen in this case"),
    ("head-on", {"speed": "1e-300"}, "speed = '1e-300' m/s: must be greater than or equal to"),
    ("head-on", {"speed": 1e-8}, "speed = 1e-08 m/s: must be between "),
    ("head-on", {"speed": 1e4}, "speed = 10000.0 m/s: must be between "),
    ("head-on", {"partner_radius": 0.02}, "partner = 'wall' has none"),
    ("head-on", {"materials_as": "mixed"}, "materials_as = 'mixed': needs two materials"),
    ("head-on", {"interface": "old", **ROLLS}, "interface = 'old': has these submodels only"),
    ("head-on", {**MDR, "yield_stress": 10.0}, "yield_stress = 10.0 Pa: must be between"),
    ("head-on", {**MDR, "yield_stress": 1e7, **ROLLS}, "rolling = 'sds': must be none"),
    ("head-on", {**MDR, "yield_stress": 1e7, "poisson_ratio": -0.5}, "must be from 0 to below"),
    ("head-on", {**MDR, "bulk_response": True, "damping": "mdr", "damping_coefficient": 0.1},
     "damping = 'mdr': must be none or velocity"),
    ("head-on", {**MDR, "surface_energy": 0.5, **STRONG, "damping_coefficient": 1.0},
     "surface_energy = 0.5 J/m2: normal = mdr has it alone, not with damping"),
    ("head-on", {**MDR, "yield_stress": 1e7, "partner": "sphere", "partner_radius": 0.02},
     "partner_radius = 0.02 m: must be the radius: normal = mdr with yield"),
    ("head-on", {"bulk_response": True}, "bulk_response = True"),
    ("head-on", {"heat": "radius", "conductance": 1.0}, "heat = 'radius': must be none"),
    ("head-on", STRONG, "damping_coefficient = 100000.0: must be below .* clipped"),
    ("head-on", {**STRONG, "normal": "hertz"}, "damping_coefficient = .*: the contact does not"),
    ("head-on", {"partner": "sphere", "partner_radius": 1e-9}, "partner_radius = 1e-09 m"),
    ("oblique", {"angle": 1e-300}, "angle = 1e-300 deg: must be between 1e-06 and 90"),
    ("oblique", {"tangential_stiffness": 1e20}, "do not resolve tangential_stiffness = 1e"),
    ("spin", {"partner_spin": 3.0}, r"partner_spin = 3\.0 rad/s: partner = 'wall' has none"),
    ("slip-to-roll", {"friction": 1e-9}, "friction = 1e-09: must be at least 1e-06"),
    ("slip-to-roll", {"speed": 1e9}, "duration = 1.5: must be at most .*: 1e\\+09 steps"),
    ("incline-rest", {"rolling": "none"}, "rolling = 'none': must be sds in this case"),
    ("incline-rest", {"rolling_friction": 0.0}, r"rolling_friction = 0\.0: must be greater"),
    ("twist", {"twisting_friction": 0.0}, r"twisting_friction = 0\.0 m: must be greater than 0"),
    ("twist", {"twisting": "none"}, "twisting = 'none': must be sds or marshall in this case"),
    ("stacked", {"squeeze": 1e-12}, "squeeze = 1e-12: must be between "),
    ("stacked", {"offset": 0.1, "squeeze": 0.1, "partner_radius": 1e-3},
     r"offset = 0\.1: must be between"),
    ("stacked", {"partner_density": 1e4}, "upper_density is that of this case"),
    ("pull-off", {"normal": "mdr", "surface_energy": 0.0}, "normal = mdr needs one, above 0"),
    ("pull-off", {"surface_energy": 1e9}, "surface_energy = 1000000000.0 J/m2"),
    ("prescribed-motion", {"partner": "sphere", "shear": 0.01}, "shear = 0.01 m: must be"),
    ("prescribed-motion", {"turned": 0.1}, r"turned = 0\.1 rad: needs two spheres"),
    ("prescribed-motion", {**STRONG, "damping_coefficient": 1e4}, "duration = 0.001 s: must be"),
    ("heat", {"partner_temperature": 400.0}, r"partner_temperature = 400\.0 K: must not be"),
    ("moving-wall", {"moves": "across", "normal": "hertz"}, "normal = 'hertz': must be a lin"),
    ("moving-wall", {"moves": "along", "tangential": "none"}, "tangential = 'none': must have"),
    ("curved-wall", {"wall": "rim", "normal": "hertz"}, "normal = 'hertz': must be hooke on a rim"),
    ("curved-wall", {"wall_radius": 0.01}, r"wall_radius = 0\.01 m: must be between 0\.011"),
]  # fmt: skip


def job_of(case, **changes):
    return case.job(case.default.replace(**changes))


@pytest.mark.parametrize("name", dict.fromkeys(row[0] for row in REFUSED))
def test_values_without_a_meaning_are_refused_in_one_line(name):
    case = case_named(name)
    for changes, words in (row[1:] for row in REFUSED if row[0] == name):
        assert_refused(words, job_of, case, **changes)


def test_a_plane_that_shakes_the_sphere_off_has_no_closed_form():
    case = case_named("moving-wall")
    p = case.default.replace(moves="along", acceleration=1e3)
    assert_refused(r"acceleration = 1000\.0: must be below", case.exact, p)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_presets_have_finite_values_and_published_ones_a_source(case):
    for name, parameters in case.presets.items():
        p = parameters.replace(steps_per_contact=200)
        values = limits(case, p, steps=200).values()
        assert all(abs(value) < 1e9 for value in values), name
        assert (name in case.sources) != (name in USUAL)
