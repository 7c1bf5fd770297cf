import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.tower.system import MOST_ROWS, timing_of
from harness.errors import RequestError
from harness.parameters.tower import Tower


@given(
    duration=st.floats(0.01, 20),
    steps=st.floats(60, 5000),
    samples=st.one_of(st.none(), st.integers(1, 5000)),
    height=st.integers(1, 30),
)
def test_steps_and_samples_end_with_the_duration(duration, steps, samples, height):
    case = Tower(height=height)
    found = timing_of(case, duration, steps, samples)
    assert found.steps * found.step == pytest.approx(duration * case.contact_time, rel=1e-12)
    assert found.steps % found.every == 0
    assert found.steps_per_contact >= steps * (1 - 1e-9)
    # what the script makes of it
    assert round(duration * case.contact_time / found.step) == found.steps


def test_tall_towers_write_fewer_samples():
    found = timing_of(Tower(height=10_000, law="overlap"), 100.0, None, None)
    assert found.steps / found.every * 10_001 <= 1.1 * MOST_ROWS
    asked = timing_of(Tower(height=10_000, law="overlap"), 100.0, None, 50_000)
    assert asked.steps / asked.every == pytest.approx(50_000, rel=0.1)


def _highest_frequency(case):
    """Return omega_max of all contacts closed, from the stiffness matrix of the law."""
    n = case.height
    difference = np.eye(n, n + 1) - np.eye(n, n + 1, k=1)
    inverse = np.eye(n)
    if case.law == "deformable":
        inverse = np.linalg.inv(np.eye(n) + 0.5 * np.eye(n, k=1) + 0.5 * np.eye(n, k=-1))
    mobile = slice(0, n if case.base == "fixed" else n + 1)
    matrix = (difference.T @ inverse @ difference)[mobile, mobile]
    return math.sqrt(case.stiffness / case.mass * np.linalg.eigvalsh(matrix).max())


@pytest.mark.parametrize("law", ["overlap", "deformable"])
@pytest.mark.parametrize("height", [1, 2, 5, 19, 60])
@pytest.mark.parametrize("base", ["fixed", "free"])
def test_no_step_is_taken_that_verlet_cannot(law, height, base):
    case = Tower(height=height, law=law, base=base)
    bound = _highest_frequency(case) * case.contact_period / 2
    with pytest.raises(RequestError, match="steps_per_contact"):
        timing_of(case, 3.0, 0.999 * bound, None)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, 1.0])
def test_bad_steps_name_the_value(bad):
    with pytest.raises(RequestError, match=r"steps_per_contact = .*greater than"):
        timing_of(Tower(), 3.0, bad, None)
