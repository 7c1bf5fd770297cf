"""What contact cases refuse: values without a meaning, in a line that names what is allowed."""

import pytest

from harness.cases.contact.parameters import ContactSystem
from harness.cases.registry import get_case
from harness.errors import RequestError
from harness.workflows.case_runs import parameters_of

STRONG = {"damping": "velocity", "damping_coefficient": "1e5"}
ROLLING = {"normal": "hooke", "normal_stiffness": "1e5"}
STICKY = {"preset": "jkr"}


@pytest.mark.parametrize(
    ("case", "told", "words"),
    [
        ("bounce", {"height": "1e9"}, "height = 1000000000.0 m: must be between "),
        ("bounce", {"height": "1e-9"}, "height = 1e-09 m: must be between "),
        ("bounce", {"gravity": "1e8"}, "gravity = 100000000.0 m/s2: must be between 0 and "),
        ("head-on", {"speed": "1e-300"}, "speed = '1e-300' m/s: must be greater than or equal to"),
        ("head-on", {"speed": "1e-8"}, "speed = 1e-08 m/s: must be between "),
        ("head-on", {"speed": "1e4"}, "speed = 10000.0 m/s: must be between "),
        ("head-on", {"radius": "1e-300"}, "radius = '1e-300' m: must be greater than or equal to"),
        ("head-on", {"density": "1e300"}, "density = '1e300' kg/m3: must be "),
        ("head-on", {"friction": "-0.1", "tangential": "mindlin"}, "friction"),
        ("head-on", {"normal": "hertz", "poisson_ratio": "0.6"}, "poisson_ratio = '0.6'"),
        ("head-on", {**STRONG, "restitution": "0.5"}, "restitution = 0.5: damping = 'velocity'"),
        ("head-on", {"partner_radius": "0.02"}, "partner = 'wall' has none"),
        ("head-on", {"interface": "old", "rolling": "sds"}, "rolling"),
        ("head-on", {"interface": "old", "tangential": "linear_history"}, "interface = 'old': sta"),
        ("head-on", {"preset": "chung-ooi-9"}, "has the presets"),
        ("head-on", {"partner": "box"}, "partner = 'box'"),
        ("head-on", {"steps_per_contact": "1"}, "steps_per_contact"),
        (
            "head-on",
            {"normal": "mdr", "yield_stress": "10"},
            r"yield_stress = 10.0 Pa: must be bet",
        ),
        ("head-on", STRONG, "damping_coefficient = 100000.0: must be between 0 and "),
        ("head-on", {"partner": "sphere", "partner_radius": "1e-9"}, "partner_radius = 1e-09 m"),
        ("oblique", {"angle": "1e-300"}, "angle = 1e-300 deg: must be between 1e-06 and 90"),
        (
            "oblique",
            {"preset": "usual", "tangential_stiffness": "1e20"},
            r"tangential_stiffness = 1e\+20: must be at most .*, or needs steps_per_contact of",
        ),
        (
            "oblique",
            {"preset": "usual", "friction": "100", **STRONG, "damping_coefficient": "1"},
            "friction = 100.0: must be at most 50 with steps_per_contact = 1000",
        ),
        ("oblique", {"preset": "usual", "friction": "-0.1"}, "friction = '-0.1': must be greater"),
        ("spin", {"spin": "1e300"}, "spin = '1e300' rad/s: must be "),
        ("slip-to-roll", {"friction": "1e-9"}, "friction = 1e-09: must be at least 1e-06"),
        ("slip-to-roll", {"partner": "sphere"}, "partner = 'sphere': must be one of wall"),
        ("slip-to-roll", {"speed": "1e9"}, "duration = 1.5: must be at most .*: 1e\\+09 steps"),
        ("incline-roll", {"gravity": "1e9"}, "gravity = 1000000000.0 m/s2: must be between "),
        ("incline-roll", {"duration": "1e8"}, "duration = 100000000.0: must be at most 1e\\+06"),
        ("rolling-resistance", {"rolling_damping": "1e9"}, "rolling_damping = 1000000000.0: must"),
        ("twist", {"twisting_friction": "0"}, "twisting_friction = 0.0: must be greater than 0"),
        ("twist", {"twisting_stiffness": "1e9"}, "twisting_stiffness = 1000000000.0: must be at"),
        ("stacked", {"partner": "wall"}, "partner = 'wall': must be one of sphere"),
        ("stacked", {"squeeze": "1e-12"}, "squeeze = 1e-12: must be between "),
        ("stacked", {"gravity": "1e9"}, "gravity = 1000000000.0 m/s2: must be between 0 and "),
        ("stacked", {"upper_density": "0.1"}, "upper_density = 0.1 kg/m3: must be between "),
        ("pull-off", {"overlap": "1e-3"}, "overlap = 0.001 m: must be between "),
        ("pull-off", {"normal": "hooke"}, "normal = 'hooke': attracts nothing"),
        ("pull-off", {"normal": "mdr", "surface_energy": "0"}, "normal = mdr needs one, above 0"),
        ("pull-off", {**STICKY, "surface_energy": "1e9"}, "surface_energy = 1000000000.0 J/m2"),
        ("prescribed-motion", {"overlap": "0.1"}, "overlap = 0.1 m: must be between "),
        ("prescribed-motion", {"partner": "sphere", "shear": "0.01"}, "shear = 0.01 m: must be"),
        (
            "prescribed-motion",
            {**STRONG, "damping_coefficient": "1e4"},
            "duration = 0.001 s: must be between ",
        ),
    ],
)
def test_what_has_no_meaning_is_one_line_that_names_value_and_limits(case, told, words):
    chosen = get_case(case)
    with pytest.raises(RequestError, match=words) as error:
        chosen.job(parameters_of(chosen, told))
    assert "\n" not in str(error.value)


NAMES = (
    "head-on", "oblique", "spin", "bounce", "stacked", "slip-to-roll", "incline-roll",
    "rolling-resistance", "twist", "pull-off", "prescribed-motion",
)  # fmt: skip


def test_presets_and_trials_are_within_their_own_limits():
    kinds = [get_case(name) for name in NAMES]
    made = [preset for case in kinds for preset in case.presets.values()]
    assert all(isinstance(one, ContactSystem) for one in made)
    assert all([*case.trials("full", (*case.submodels, *case.other_submodels))] for case in kinds)


@pytest.mark.parametrize("name", NAMES)
def test_what_a_level_runs_a_longer_one_runs_as_well(name):
    levels = [
        {(trial.submodel, trial.system) for trial in get_case(name).trials(level)}
        for level in ("quick", "default", "full")
    ]
    assert levels[0] <= levels[1] <= levels[2]
