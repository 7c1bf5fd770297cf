import math

import pytest

from harness.cases.incline.engine_checks import EngineAngle
from harness.parameters.law import PLASTIC, SOURCE


def angle(**changes):
    values = {
        "name": "critical angle",
        "unit": "deg",
        "who": "yade",
        "role": "plastic",
        "contact": PLASTIC.replace(effective_mass="half"),
        "stiffness": 1e6,
        "steps_per_contact": 100.0,
        "value": 10.25,
        "uncertainty": 0.001,
        "expected": 10.2,
        "integrator": "velocity-verlet",
    }
    return EngineAngle(**{**values, **changes})


def test_a_class_is_said_in_words():
    assert angle().rules_text == "clipped tail, m_eff m/2"
    assert angle(contact=SOURCE).rules_text == "attractive tail, m_eff m"


def test_differences_are_in_full_and_missing_ones_are_nan():
    assert angle().difference == pytest.approx(0.05)
    assert math.isnan(angle().off_reference_deg)
    assert angle(reference_deg=10.24).off_reference_deg == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "independent"),
        ({"lineage": "LAMMPS"}, "regression partner"),
        ({"recorded": True}, "recorded"),
        ({"who": "reference"}, "the harness's own"),
    ],
)
def test_what_kind_of_evidence_it_is(changes, said):
    assert angle(**changes).evidence == said
    assert angle(**changes).to_json()["evidence"] == said
