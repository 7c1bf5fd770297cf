"""The formulas are those that the source prints: values worked out by hand from its lines."""

import math

import numpy as np
import pytest

from harness.reproduction import as_printed

X = np.array([0.0, 0.9, 1.85, 2.8])


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (as_printed.series_stiffness(6.0, 3), 2.0),
        (as_printed.well(30.0), 0.0),
        (as_printed.gain(30.0), 0.5),
        (as_printed.energy_after_first(1.0, 0.5, 0.25), 0.375),
        # E_0 E^3 + dE E (E^2 + E^2 + 1)
        (as_printed.energy_series(3, 8.0, 1.0, 0.5), 1.0 + 0.5 * 1.5),
        (as_printed.geometric_sum(0.5, 2), 1.75),
        (as_printed.energy_closed(2, 1.0, 1.0, 0.5), 0.5 + 0.5 * 0.5 / 0.5),
        (as_printed.limiting_energy(3.0, 0.25), 1.0),
        (as_printed.steady_state_margin(30.0, 0.25, 2.0), 1 / 3),
        (as_printed.shock_of_velocities(4.0, 1.0), 0.5625),
        (as_printed.velocity_after(2.0, 1.0), 2.0),
        (as_printed.shock_of_restitution(0.0), 0.25),
        (as_printed.rigidity(1e5, 10.0), 1e4),
        (as_printed.collision_time(4.0, 1.0, 0.0, 1.0), math.pi / 2),
        (as_printed.collision_time(5.0, 1.0, 1.0, 1.0), math.pi / 2),
        (as_printed.modified_velocity(2.0, 0.5), 1.0),
        (as_printed.modified_shock(1.0, 0.5, 0.5), 0.5625),
        (as_printed.dashpot_force(3.0, 2.0), 6.0),
        (as_printed.pair_accelerations(X[:2], 0.5, 10.0, 2.0)[0], 0.5),
        (as_printed.first_boundary(X[:2], 0.5), (0.5 - 0.9) / 2),
        (as_printed.first_boundary(X[:3], 0.5), (-0.5 - 3 * 0.9 + 1.85) / 3),
        (as_printed.next_boundary(0.9, 0.45), 1.35),
        (as_printed.energy_of_two_without_stiffness(0.3), 0.09),
        (as_printed.kinetic_energy_of_springs(10.0, 3, 0.2), 3.0),
        (as_printed.last_boundary(X[:2], 0.1), -1.8 + 0.2),
        (as_printed.deformation(0.9, 0.45, 0.5), 0.1),
        (as_printed.first_deformation(np.array([0.5, 0.4, 0.1])), 0.5 - (0.4 - 0.1)),
        (as_printed.boundary_of_four(X), (-2.8 + 3 * 1.85 - 5 * 0.9) / 4),
        (as_printed.largest_compression(0.5, 0.2), 0.8),
    ],
)
def test_value(value, expected):
    assert value == pytest.approx(expected, abs=1e-15)


def test_line_of_the_example_is_right_for_one_b_0_less():
    """With - b_0 for - 2b_0 the printed line has the root that the next line prints."""
    first = as_printed.boundary_of_four(X)
    assert as_printed.imbalance_of_four(X, first, 0.5) == pytest.approx(first, abs=1e-15)


def test_printed_numbers_cannot_be_changed_in_place():
    with pytest.raises(AttributeError):
        as_printed.PRINTED.shock = 0.3
