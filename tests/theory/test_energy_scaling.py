import math

import numpy as np
import pytest

from harness.errors import RequestError
from harness.theory.incline import LARGEST_HEIGHT, impulse_ratio


def speed_taken_up(springs, force=3.0, stiffness=70.0, mass=2.0):
    """Return the speed that n springs in series take up under a force, their energies added up.

    Static equilibrium of a row of nodes: K x = f, then the energy spring by spring.
    """
    stiff = stiffness * (2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1))
    stiff[-1, -1] = stiffness  # the far end is free and pulled, the near one held
    load = np.zeros(springs)
    load[-1] = force
    stretch = np.diff(np.linalg.solve(stiff, load), prepend=0.0)
    return math.sqrt(2 * float(np.sum(0.5 * stiffness * stretch**2)) / mass)


@pytest.mark.parametrize("height", range(1, LARGEST_HEIGHT + 1))
def test_it_is_the_inverse_of_the_speed_that_a_row_of_springs_takes_up(height):
    ratio = speed_taken_up(1) / speed_taken_up(height)
    assert impulse_ratio(height) == pytest.approx(ratio, rel=1e-12)


def test_one_particle_is_the_rigid_base():
    assert impulse_ratio(1) == 1.0


@pytest.mark.parametrize("height", [0, -3])
def test_heights_below_one_are_named(height):
    with pytest.raises(RequestError, match=rf"^height = {height} is not allowed: .* at least 1$"):
        impulse_ratio(height)
