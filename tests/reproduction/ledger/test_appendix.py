import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.reproduction.claims import SOURCES
from harness.reproduction.ledger.samples import (
    OpenPair,
    ParticleRow,
    openings,
    touching_chains,
)
from harness.solvers.chain.forces import contact_forces


def row_of(distances):
    centres = np.concatenate(([0.0], np.cumsum(distances)))
    return ParticleRow(centres, contact_forces(centres, 1.0, 1.0))


def test_the_smaller_deformation_does_not_keep_the_inequality():
    """Particles 1 and 2 press, 3 stands open by 0.02 m and is closer to 2 than a diameter."""
    (pair,) = openings([row_of([0.9, 0.97])])
    assert pair == OpenPair(pytest.approx(0.97), (pytest.approx(0.1), 0.0), (0.9, np.inf))
    assert pair.distance < 1 - min(pair.deformations)
    assert pair.distance > 1 - max(pair.deformations)
    assert pair.distance > pair.beyond[0]


@settings(max_examples=200, deadline=None)
@given(st.lists(st.floats(0.9, 1.1), min_size=2, max_size=9))
def test_the_larger_deformation_does(distances):
    for pair in openings([row_of(distances)]):
        larger = int(np.argmax(pair.deformations))
        assert pair.distance >= 1 - pair.deformations[larger] - 1e-12
        if pair.deformations[larger] > 1e-12:
            assert pair.distance >= pair.beyond[larger] - 1e-12


def test_chains_are_built_as_they_say():
    for chain in touching_chains(20):
        widths = np.diff(chain.boundaries)
        assert chain.centres == pytest.approx(chain.boundaries[:-1] + widths / 2)
        assert chain.deformations == pytest.approx(np.convolve(chain.compressions, [1, 1]))
        again = contact_forces(chain.centres, 1.0, 1.0)
        assert again == pytest.approx(chain.compressions, abs=1e-13)


def test_line_of_the_example_takes_b_0_twice():
    symbols = touching_chains(1, (4,))[0].symbols
    one, none = (SOURCES["eq-four-inserted"].printed(**symbols | {"b_0": b}) for b in (1.0, 0.0))
    assert one - none == pytest.approx(5)  # four in the line after it
