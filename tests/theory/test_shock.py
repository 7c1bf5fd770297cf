import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.errors import RequestError
from harness.theory.chain import (
    SHOCK_WITHOUT_REBOUND,
    shock_from_impulse_ratio,
    shock_from_restitution,
)

RESTITUTIONS = st.floats(0.0, 1.0)
RATIOS = st.floats(1e-6, 2.0 - 1e-6)


def velocity_after_collision(restitution):
    """Collide with the sphere ahead in the well, in vectors; return velocity before and after."""
    before = np.array([math.cos(math.radians(-30)), math.sin(math.radians(-30))])
    normal = np.array([-math.cos(math.radians(60)), math.sin(math.radians(60))])
    return before, before - (1 + restitution) * (before @ normal) * normal


@given(RESTITUTIONS)
def test_energy_kept_is_that_of_a_collision_in_vectors(restitution):
    before, after = velocity_after_collision(restitution)
    assert shock_from_restitution(restitution) == pytest.approx(
        (after @ after) / (before @ before), rel=1e-12
    )


def test_readings_agree_without_rebound_and_nowhere_else():
    assert shock_from_restitution(0.0, "kept") == pytest.approx(SHOCK_WITHOUT_REBOUND, rel=1e-15)
    assert shock_from_restitution(0.0, "lost") == pytest.approx(SHOCK_WITHOUT_REBOUND, rel=1e-15)
    for restitution in np.linspace(0.05, 1.0, 20):
        kept = shock_from_restitution(float(restitution), "kept")
        assert kept - shock_from_restitution(float(restitution), "lost") > 1e-3


def test_elastic_collision_keeps_everything():
    assert shock_from_restitution(1.0, "kept") == 1.0
    assert shock_from_restitution(1.0, "lost") == 0.0


@given(RESTITUTIONS, RESTITUTIONS)
def test_readings_move_in_opposite_directions_with_restitution(one, other):
    low, high = sorted((one, other))
    assert shock_from_restitution(low, "kept") <= shock_from_restitution(high, "kept")
    assert shock_from_restitution(low, "lost") >= shock_from_restitution(high, "lost")


@given(RATIOS, RATIOS)
def test_readings_move_in_opposite_directions_with_the_impulse(one, other):
    low, high = sorted((one, other))
    assert shock_from_impulse_ratio(low, "kept") <= shock_from_impulse_ratio(high, "kept")
    assert shock_from_impulse_ratio(low, "lost") >= shock_from_impulse_ratio(high, "lost")


@given(RATIOS)
def test_shock_from_impulse_is_a_fraction_and_square_roots_of_readings_add_to_one(ratio):
    kept, lost = (shock_from_impulse_ratio(ratio, r) for r in ("kept", "lost"))
    assert 0.0 < kept < 1.0
    assert 0.0 < lost < 1.0
    assert math.sqrt(kept) + math.sqrt(lost) == pytest.approx(1.0, rel=1e-12)


def test_rigid_base_has_the_impulse_ratio_one():
    assert shock_from_impulse_ratio(1.0, "kept") == SHOCK_WITHOUT_REBOUND
    assert shock_from_impulse_ratio(1.0, "lost") == SHOCK_WITHOUT_REBOUND


@pytest.mark.parametrize("value", [-1e-9, 1.0 + 1e-9, math.nan, math.inf, -math.inf])
def test_restitution_out_of_range_is_named(value):
    with pytest.raises(RequestError, match=r"^restitution = \S+ is not allowed: .* 0 to 1$"):
        shock_from_restitution(value)


@pytest.mark.parametrize("value", [0.0, 2.0, -1.0, math.nan, math.inf])
def test_impulse_ratio_out_of_range_is_named(value):
    with pytest.raises(RequestError, match=r"^impulse-ratio = \S+ is not allowed: .* than 2$"):
        shock_from_impulse_ratio(value)


@pytest.mark.parametrize("shock", [shock_from_restitution, shock_from_impulse_ratio])
def test_unknown_reading_is_named(shock):
    with pytest.raises(RequestError, match=r"'given' is not allowed: must be 'kept' or 'lost'"):
        shock(0.5, "given")
