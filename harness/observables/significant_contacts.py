"""The contacts of the grain's chain whose force is above rounding."""

from __future__ import annotations

from harness.observables.tower import Floats, TowerRun

SIGNIFICANT_FORCE = 1e-6
"""Contacts that press with more than this part of the peak; fainter ones are rounding's."""


def significant_contacts(run: TowerRun) -> Floats:
    """Return the contacts of the grain's chain above rounding (M,), of a run with profiles.

    All that carry a force, of one without.
    """
    if run.profiles is None:
        return run.contacts
    return run.contacts_above(SIGNIFICANT_FORCE * float(run.grain_force.max()))
