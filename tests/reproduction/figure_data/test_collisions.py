import math

import numpy as np
import pytest

from harness.reproduction import figure_data
from harness.reproduction.claims import ClaimStatus
from harness.theory.chain import final_velocities, peak_force_on_fixed, peak_overlap


@pytest.fixture(scope="module")
def two_and_three():
    return figure_data.two_and_three_particles()


def test_the_runs_last_until_all_have_parted(two_and_three):
    runs, statement = two_and_three
    assert statement.status is ClaimStatus.REPRODUCED
    for run in runs:
        assert run.contacts[-1] == 0
        expected = run.tower.speed * final_velocities(run.tower.particles, deformable=True)
        assert run.final_velocity == pytest.approx(expected, abs=1e-6)


def test_another_mass_does_not_exchange(monkeypatch):
    """A perturbed constant changes the verdict."""
    monkeypatch.setattr(figure_data, "PAIR", figure_data.PAIR.replace(gravity=9.81, base="fixed"))
    statement = figure_data.two_and_three_particles()[1]
    assert statement.status is ClaimStatus.NOT_REPRODUCED


def test_error_against_stiffness():
    curves, statement = figure_data.error_against_stiffness()
    assert statement.status is ClaimStatus.NOT_REPRODUCED
    # a sample is half a step off the top at most; RK4 itself errs by less than 1e-6 here
    bound = 1 - math.cos(math.pi / 50 / math.sqrt(2))
    assert max(curves[figure_data.SCALED_STEP][1]) <= bound + 1e-6


@pytest.mark.parametrize("stiffness", [1e3, 1e6])
def test_gravity_left_out_against_the_closed_form(stiffness):
    """The same by another route: the peak force over the stiffness."""
    deep = peak_force_on_fixed(1.0, stiffness, 2.0, 9.81) / stiffness
    bare = math.sqrt(2) * peak_overlap(1.0, stiffness, 2.0)
    curves, _ = figure_data.error_against_stiffness()
    stiffnesses, errors = curves[figure_data.GRAVITY]
    assert np.interp(stiffness, stiffnesses, errors) == pytest.approx(deep / bare - 1, rel=1e-6)


@pytest.mark.parametrize(
    ("size", "status"), [(10.0, ClaimStatus.REPRODUCED), (100.0, ClaimStatus.NOT_REPRODUCED)]
)
def test_an_error_must_fall_below_half_a_per_cent(monkeypatch, size, status):
    def falling(stiffnesses, _):
        return stiffnesses, [size / k for k in stiffnesses]

    monkeypatch.setattr(figure_data, "error_over_stiffness", falling)
    assert figure_data.error_against_stiffness()[1].status is status
