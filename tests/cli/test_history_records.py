import math

import pytest

from harness.cli.incline import angle_quantities
from harness.cli.tower import impulse_quantities, tower_quantities

ANGLE = {
    "critical_angle_deg": 10.205,
    "uncertainty_deg": 1e-3,
    "closed_form_deg": 10.208,
    "method": "passage",
    "contact": "source",
    "damping_ratio": 0.99,
    "tail": "attractive",
    "effective_mass": "full",
    "stiffness_N_per_m": 1e6,
    "steps_per_contact": 50.0,
    "diameter_m": 1.0,
    "density_kg_per_m3": 6.0 / math.pi,
    "gravity_m_per_s2": 9.81,
}
TOWER = {
    "solver": "rk4",
    "law": "overlap",
    "height": 3,
    "stiffness_N_per_m": 1e6,
    "speed_m_per_s": 2.0,
    "mass_kg": 1.0,
    "gravity_m_per_s2": 9.81,
    "base": "fixed",
    "window": "turnaround",
    "step_s": 1e-6,
    "duration_s": 0.009,
    "contact_time_s": 0.003,
    "impulse_Ns": 3.4,
    "peak_force_N": 1414.0,
    "turnaround_s": 0.0036,
    "energy_drift": 1e-9,
}
ROW = {
    "height": 2,
    "law": "overlap",
    "window": "turnaround",
    "stiffness_N_per_m": 1e6,
    "speed_m_per_s": 2.0,
    "impulse_ratio": 0.6263,
}


def test_the_critical_angle_stands_beside_the_closed_form():
    (found,) = angle_quantities(ANGLE)
    assert found.name == (
        "critical angle: passage, source contact, k = 1000000 N/m, 50 steps per contact"
    )
    assert (found.value, found.uncertainty, found.expected) == (10.205, 1e-3, 10.208)
    assert found.unit == "deg"


@pytest.mark.parametrize(
    "change",
    [
        {"method": "steady"},
        {"contact": "custom"},
        {"stiffness_N_per_m": 1e6 + 1},
        {"steps_per_contact": 51.0},
        {"diameter_m": 2.0},
        {"density_kg_per_m3": 2500.0},
        {"gravity_m_per_s2": 1.62},
        {"extrapolated": True},
    ],
)
def test_another_case_has_another_name(change):
    assert angle_quantities(ANGLE | change)[0].name != angle_quantities(ANGLE)[0].name


@pytest.mark.parametrize(
    "change",
    [{"height": 4}, {"step_s": 2e-6}, {"duration_s": 0.006}, {"base": "free"}, {"mass_kg": 2.0}],
)
def test_another_tower_has_another_name(change):
    names = [{q.name for q in tower_quantities(record)} for record in (TOWER, TOWER | change)]
    assert len(names[0]) == 4
    assert not names[0] & names[1]


def test_impulse_ratios_are_named_by_their_row_and_what_is_not_the_default():
    (usual,) = impulse_quantities([ROW], "rk4", {"mass_kg": 1.0, "gravity_m_per_s2": 9.81})
    (moon,) = impulse_quantities([ROW], "rk4", {"mass_kg": 1.0, "gravity_m_per_s2": 1.62})
    assert usual.name.startswith("impulse ratio alpha(2): rk4, overlap law, turnaround window")
    assert moon.name == usual.name + ", gravity_m_per_s2 = 1.62"
