"""The contacts of the grain's chain that press hard enough to be seen."""

from __future__ import annotations

from harness.observables.tower import Floats, TowerRun

FELT_FORCE = 1e-6
"""Contacts that press with more than this part of the peak; fainter ones are rounding's."""


def significant_contacts(run: TowerRun) -> Floats:
    """Return the contacts of the grain's chain that are worth showing (M,), of a run with profiles.

    All that carry a force, of one without.
    """
    if run.profiles is None:
        return run.contacts
    return run.contacts_above(FELT_FORCE * float(run.grain_force.max()))
