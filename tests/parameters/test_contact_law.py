"""The law of a contact: its submodels take what is theirs, and nothing else."""

import math

import pytest
from pydantic import Field

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.submodels import COEFFICIENTS, DAMPING, SUBMODELS
from harness.solvers.pair import normal as solver

NEEDED = {
    "damping_coefficient": 1.0,
    **dict.fromkeys(("rolling_stiffness", "rolling_damping", "rolling_friction"), 1.0),
    **dict.fromkeys(("twisting_stiffness", "twisting_damping", "twisting_friction"), 1.0),
}
"""Coefficients without a default."""


MDR_SLOWED = {"normal": "mdr", "damping": "velocity", "damping_coefficient": 1.0}


class Case(ContactLaw):
    """What a case does: parameters of its own beside the law's, and other defaults."""

    normal_stiffness: float | None = Field(5e4, gt=0.0, description="[N/m]")
    speed: float = Field(2.0, description="[m/s]")


def test_defaults_are_those_of_the_submodels_alone():
    law = ContactLaw(tangential="linear_history")
    assert law.normal_stiffness == 1e6
    assert law.tangential_stiffness == pytest.approx(2e6 / 7)
    assert law.youngs_modulus is None
    assert law.restitution is None


def test_the_tangential_stiffness_follows_the_normal_one():
    law = ContactLaw(tangential="linear_history", normal_stiffness=7.0)
    assert law.tangential_stiffness == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("part", "model"), [(part, model) for part in SUBMODELS for model in SUBMODELS[part]]
)
def test_every_submodel_can_be_chosen_and_left_again(part, model):
    settings = {part: model}
    if "mindlin" in model or model == "tsuji":
        settings["normal"] = "hertz"
    if model == "mdr":
        settings["normal"] = "mdr"
    if model == "linear_nohistory":
        settings["damping"] = "coeff_restitution"
    if model == "marshall":
        settings["tangential"] = "linear_history"
    mine = SUBMODELS[part][model].takes
    settings |= {name: value for name, value in NEEDED.items() if name in mine}
    law = ContactLaw(**settings)
    assert all(getattr(law, name) is not None for name in mine)
    others = COEFFICIENTS - law.taken({p: getattr(law, p) for p in SUBMODELS})
    assert all(getattr(law, name) is None for name in others)
    assert law.replace(**dict.fromkeys(SUBMODELS, "none") | {"normal": "hooke"}) == ContactLaw()


def test_a_case_changes_a_submodel_and_its_default_goes_with_it():
    hertz = Case().replace(normal="hertz", speed=3.0)
    assert (hertz.normal_stiffness, hertz.youngs_modulus, hertz.speed) == (None, 70e9, 3.0)
    assert Case(normal="hertz") == hertz.replace(speed=2.0)
    assert hertz.replace(normal="hooke").normal_stiffness == 5e4
    assert hertz.law == ContactLaw(normal="hertz")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"friction": 0.3}, "friction = 0.3: tangential = 'none' takes none (tangential = lin"),
        (
            {"damping": "velocity", "damping_coefficient": 1.0, "restitution": 0.5},
            "restitution = 0.5: damping = 'velocity' takes none",
        ),
        ({"damping": "velocity"}, "damping = 'velocity': needs damping_coefficient"),
        ({"rolling": "sds"}, "rolling = 'sds': needs rolling_stiffness"),
        ({"youngs_modulus": 1e9}, "youngs_modulus = 1000000000.0: normal = 'hooke' takes none"),
        ({"tangential": "linear_nohistory"}, "tangential = 'linear_nohistory': needs a damping"),
        ({"tangential": "mindlin"}, "tangential = 'mindlin': needs a material"),
        ({"twisting": "marshall"}, "twisting = 'marshall': takes its coefficients from a tang"),
        ({"damping": "tsuji"}, "damping = 'tsuji': needs normal = hertz, not 'hooke'"),
        ({"bulk_response": True}, "bulk_response = True: normal = 'hooke' has none"),
        ({"normal": "mdr", "yield_stress": 0.0}, "yield_stress = 0.0 Pa: must be"),
        (
            {"normal": "mdr", "yield_stress": 1e6, "surface_energy": 1.0},
            "surface_energy = 1.0: normal = mdr is stated with it alone, not beside yield_stress",
        ),
        (
            {**MDR_SLOWED, "damping": "mdr", "bulk_response": True},
            "damping = 'mdr': must be none or velocity beside bulk_response = True",
        ),
        (
            {"normal": "mdr", "bulk_response": True, "poisson_ratio": 0.5},
            "poisson_ratio = 0.5: must be from 0 to below 0.5 beside bulk_response = True",
        ),
        ({"normal": "jkr", "clipped": True}, "clipped = True: normal = 'jkr' attracts"),
        (
            {"normal": "dmt", "damping": "coeff_restitution"},
            "damping = 'coeff_restitution': needs normal = hooke or hertz, not 'dmt'",
        ),
        ({"tangential": "linear_history", "friction": 1e308}, "friction = 1e+308: must be greater"),
        ({"normal": "hertz", "poisson_ratio": 0.51}, "poisson_ratio = 0.51: must be greater than"),
        ({"damping": "tsuji", "normal": "hertz", "restitution": 1.5}, "restitution = 1.5: must be"),
        ({"normal": "soft"}, "normal = 'soft': must be 'hooke', 'hertz', 'dmt', 'jkr' or 'mdr'"),
        ({"normal": ["hooke"]}, "normal = ['hooke']: must be 'hooke'"),
    ],
)
def test_what_does_not_fit_is_named(settings, message):
    with pytest.raises(RequestError) as caught:
        ContactLaw(**settings)
    assert str(caught.value).startswith(message)


def test_what_mdr_may_take_is_kept_by_changes_and_dropped_with_it():
    law = ContactLaw(normal="mdr", youngs_modulus=1e8, yield_stress=1e6)
    assert law.surface_energy is None
    assert law.lags
    assert law.replace(poisson_ratio=0.2).yield_stress == 1e6
    assert law.replace(normal="hertz").yield_stress is None
    assert law.replace(normal="jkr").surface_energy == 0.1
    assert not ContactLaw(normal="mdr", surface_energy=0.5).lags
    assert ContactLaw(normal="mdr", bulk_response=True).lags


@pytest.mark.parametrize(
    ("name", "normal"),
    [
        (name, normal)
        for name, row in DAMPING.items()
        for normal in ("hooke", "hertz")
        if name != "none" and normal in row.normals
    ],
)
def test_a_dashpot_grows_as_its_row_says(name, normal):
    """Held against the integration's own dashpot, which shares nothing with the row."""
    row, law = DAMPING[name], {"hooke": solver.HOOKE, "hertz": solver.HERTZ}[normal]
    mass, coefficient, overlaps = 0.3, 0.7, (1e-9, 1e-11)
    elastic = [solver.elastic(law, 1e6, 0.0, 0.01, x) for x in overlaps]
    eta = [
        solver.dashpot(solver.KINDS[name], coefficient, mass, x, force, 0.5e6)[0]
        for x, force in zip(overlaps, elastic, strict=True)
    ]
    quantities = {
        "mass": mass,
        "radius": elastic[0].radius,
        "stiffness": elastic[0].force / overlaps[0],
    }
    assert eta[0] == pytest.approx(row.eta(coefficient, **quantities), rel=1e-12)
    assert math.log(eta[0] / eta[1], 100) == pytest.approx(row.growth(normal), abs=1e-9)
