import math

import pytest
from harness.comparison.engine_evidence import Declared, EngineAngle, EngineTower, Rules

RULES = Rules("clipped", "half", "linear")


def angle(**changes):
    values = {
        "engine": "yade",
        "contact": "plastic",
        "rules": RULES,
        "stiffness": 1e6,
        "steps_per_contact": 100.0,
        "value_deg": 10.25,
        "uncertainty_deg": 0.001,
        "closed_form_deg": 10.2,
        "integrator": "velocity-verlet",
    }
    return EngineAngle(**{**values, **changes})


def test_a_class_is_said_in_words():
    assert RULES.text == "clipped tail, m_eff m/2, linear spring"
    assert Rules("attractive", "full", "Hertz").text == "attractive tail, m_eff m, Hertz spring"


def test_differences_are_in_full_and_missing_ones_are_nan():
    assert angle().off_theory_deg == pytest.approx(0.05)
    assert math.isnan(angle().off_reference_deg)
    assert angle(reference_deg=10.24).off_reference_deg == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "independent"),
        ({"lineage": "LAMMPS"}, "regression partner"),
        ({"recorded": True}, "recorded"),
        ({"engine": "reference"}, "the harness's own"),
    ],
)
def test_what_kind_of_evidence_it_is(changes, said):
    assert angle(**changes).evidence == said
    assert angle(**changes).record()["evidence"] == said


def test_errors_of_a_tower_are_relative():
    tower = EngineTower("yade", 4, 1e4, 101.0, 100.0, 1.98, 2.0)
    assert tower.peak_error == pytest.approx(0.01)
    assert tower.impulse_error == pytest.approx(-0.01)
    assert math.isnan(EngineTower("mfix", 4, 1e4, 101.0, 100.0).impulse_error)


@pytest.mark.parametrize(
    ("changes", "standing"),
    [
        ({}, "qualified"),
        ({"missing": "not installed"}, "missing"),
        ({"unqualified": "free fall"}, "did not qualify"),
    ],
)
def test_the_standing_of_an_engine(changes, standing):
    declared = Declared(
        "yade", "1", "executable", "apt install yade", ("1",), "velocity-verlet", ("clipped",),
        ("full",), "linear", 15, "", (), **changes,
    )  # fmt: skip
    assert declared.standing == standing
