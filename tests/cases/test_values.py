"""What scripts are told of a case: with the same names for every engine, and nothing lost."""

import pytest

from harness.cases.tower.system import timing_of
from harness.cases.tower.system import values_of as tower_values
from harness.errors import RequestError
from harness.parameters.law import PLASTIC, SOURCE, Contact, contact_of, contact_values
from harness.parameters.tower import Tower


@pytest.mark.parametrize(
    ("contact", "told"),
    [
        (SOURCE, ("restitution", 1e-20, 1.0, "full", "attractive")),
        (PLASTIC, ("ratio", 0.0, 5.0, "full", "clipped")),
        (Contact(restitution=0.0, damping_ratio=None, effective_mass="half"),
         ("restitution", 0.0, 1.0, "half", "attractive")),
        (Contact(restitution=0.5, damping_ratio=0.2), ("ratio", 0.5, 0.2, "full", "attractive")),
    ],
)  # fmt: skip
def test_the_dashpot_is_told_by_the_word_that_decides(contact, told):
    assert tuple(contact_values(contact).values()) == told
    assert contact_values(contact_of(contact_values(contact)))["damping"] == told[0]


@pytest.mark.parametrize("unequal", ["mass", "stiffness", "diameter"])
def test_towers_of_unequal_particles_are_refused(unequal):
    case = Tower(height=1, law="overlap", **{unequal: (1e6, 2e6)})
    with pytest.raises(RequestError, match="must be one number each in an engine"):
        tower_values(case, timing_of(case, 3.0, 100.0, 100))
