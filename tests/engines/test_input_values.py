"""What engines are told of a case: with the same names, and nothing that they cannot state."""

import pytest

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.engines.input_values import (
    check_overlap_law,
    contact_values,
    drop_values,
    incline_values,
    tower_values,
)
from harness.errors import RequestError
from harness.parameters.contact import PLASTIC, SOURCE, Contact
from harness.parameters.tower import Tower


@pytest.mark.parametrize(
    ("contact", "told"),
    [
        (SOURCE, ("restitution", 1e-20, 1.0, "full")),
        (PLASTIC, ("ratio", 0.0, 5.0, "full")),
        (Contact(restitution=0.0, damping_ratio=None, effective_mass="half"),
         ("restitution", 0.0, 1.0, "half")),
        (Contact(restitution=0.5, damping_ratio=0.2), ("ratio", 0.5, 0.2, "full")),
    ],
)  # fmt: skip
def test_the_dashpot_is_told_by_the_word_that_decides(contact, told):
    assert tuple(contact_values(contact).values()) == told


def test_numbers_are_those_of_the_case():
    drop = Drop(stiffness=3e5, gap=0.1, every=7)
    assert drop_values(drop)["stiffness"] == 3e5
    assert drop_values(drop)["series_every"] == 7
    assert drop_values(drop)["steps"] == drop.steps
    incline = Incline(angle=11.1, wells=4)
    assert incline_values(incline)["angle"] == 11.1
    assert incline_values(incline)["wells"] == 4
    tower = tower_values(Tower(height=3, mass=2.0), 3.0, 500.0, "a code")
    assert (tower["mass"], tower["height"], tower["duration"]) == (2.0, 3, 3.0)


@pytest.mark.parametrize("unequal", ["mass", "stiffness", "diameter"])
def test_towers_of_unequal_particles_are_refused(unequal):
    case = Tower(height=1, law="overlap", **{unequal: (1e6, 2e6)})
    with pytest.raises(RequestError, match="must be one number each in a code's tower"):
        tower_values(case, 3.0, 100.0, "a code")


def test_the_deformable_law_is_refused_with_who_has_it():
    check_overlap_law(Tower(law="overlap"), "a code")
    with pytest.raises(RequestError, match=r"law = 'deformable': a code has .* or lammps"):
        check_overlap_law(Tower(law="deformable"), "a code")
