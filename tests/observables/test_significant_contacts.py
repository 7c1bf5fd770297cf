import numpy as np

from harness.observables.tower import SIGNIFICANT_FORCE, significant_contacts
from harness.parameters.tower import Tower
from harness.solvers.chain import exact


def test_faint_contacts_of_the_overlap_law_are_not_felt():
    case = Tower(height=19, law="overlap")
    bare = exact.run(case, case.contact_time)
    whole = exact.run(case, case.contact_time, profiles=True)
    assert (significant_contacts(bare) == bare.contacts).all()
    felt = significant_contacts(whole).astype(int)
    assert (felt <= whole.contacts).all()
    assert felt.max() < whole.contacts.max()
    last = whole.profiles.forces[np.arange(felt.size), np.maximum(felt - 1, 0)]
    assert (last[felt > 0] > SIGNIFICANT_FORCE * whole.grain_force.max()).all()
