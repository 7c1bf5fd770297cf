"""Closed forms of rows of grains: the source's digits, and the deformable law by its compliance.

The second route of those that move is the exact propagator: ``tests/solvers/chain/test_exact.py``.
"""

import pytest

from harness.theory import chain
from tests.theory import closed_forms


@pytest.mark.parametrize(
    ("deformable", "expected"),
    [
        (False, [-0.130262, 0.150230, 0.980032]),
        (False, [-0.132275, -0.064975, 0.236978, 0.960272]),
        (True, [-0.185761, 0.230611, 0.955150]),
    ],
)
def test_free_chain_table(deformable, expected):
    velocity = chain.final_velocities(len(expected), deformable)
    assert velocity == pytest.approx(expected, abs=1e-6)
    assert (velocity.sum(), velocity @ velocity) == pytest.approx((1.0, 1.0), abs=1e-12)


def test_digits_of_the_tall_tower():
    assert pytest.approx(5.135622, abs=1e-6) == chain.DETACHMENT_TAU
    assert chain.grain_velocity(chain.DETACHMENT_TAU) == pytest.approx(-0.1322795, abs=1e-7)


@pytest.mark.parametrize("deformable", [False, True])
@pytest.mark.parametrize("contacts", [1, 2, 3, 9])
def test_static_tower_and_series_stiffness(contacts, deformable):
    law = chain.compliance(contacts, deformable)
    force = chain.static_forces(contacts, 2.0, 9.81)
    overlap = closed_forms.static_overlaps(contacts, 2.0, 9.81, 1e5, deformable)
    assert overlap == pytest.approx(law @ force / 1e5)
    approach = law.sum() / 1e5  # under a force of 1 N
    assert 1 / approach == pytest.approx(chain.series_stiffness(contacts, 1e5, deformable))
