"""What scripts are told of a case: with the same names for every engine, and nothing lost."""

import pytest

from harness.cases.drop.case import Drop
from harness.cases.drop.case import case_of as drop_of
from harness.cases.drop.case import values_of as drop_values
from harness.cases.incline.system import Incline
from harness.cases.incline.system import case_of as incline_of
from harness.cases.incline.system import values_of as incline_values
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


def test_numbers_are_those_of_the_case():
    drop = Drop(stiffness=3e5, gap=0.1, every=7)
    values = drop_values(drop)
    assert (values["stiffness"], values["series_every"], values["steps"]) == (3e5, 7, drop.steps)
    assert drop_of(values).gap == 0.1
    incline = Incline(angle=11.1, wells=4)
    values = incline_values(incline, "steady", 20)
    assert (values["angle"], values["wells"], values["series_every"]) == (11.1, 4, 20)
    assert incline_of(values).replace(contact=incline.contact) == incline
    tower = Tower(height=3, mass=2.0)
    told = tower_values(tower, timing_of(tower, 3.0, 500.0, None))
    assert (told["mass"], told["height"], told["duration"]) == (2.0, 3, 3.0)
    assert told["law"] == tower.law


@pytest.mark.parametrize("unequal", ["mass", "stiffness", "diameter"])
def test_towers_of_unequal_particles_are_refused(unequal):
    case = Tower(height=1, law="overlap", **{unequal: (1e6, 2e6)})
    with pytest.raises(RequestError, match="must be one number each in an engine"):
        tower_values(case, timing_of(case, 3.0, 100.0, 100))
