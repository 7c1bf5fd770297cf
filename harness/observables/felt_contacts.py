"""The contacts of the grain's chain that press hard enough to be seen, and when they change."""

from __future__ import annotations

import numpy as np

from harness.observables.tower import Floats, TowerRun

FELT_FORCE = 1e-6
"""Contacts that press with more than this part of the peak; fainter ones are rounding's."""


def felt_contacts(run: TowerRun) -> Floats:
    """Return the contacts of the grain's chain that are worth showing (M,), of a run with profiles.

    All that carry a force, of one without.
    """
    if run.profiles is None:
        return run.contacts
    return run.contacts_above(FELT_FORCE * float(run.grain_force.max()))


def chain_changes(run: TowerRun) -> list[tuple[float, int]]:
    """Return (t/t0, contacts from then on) for every change of the grain's felt chain.

    The start, at which nothing presses yet, is left out.
    """
    felt = felt_contacts(run).astype(int)
    rows = np.flatnonzero(np.diff(felt)) + 1
    return [(float(run.time_over_t0[i]), int(felt[i])) for i in rows]


def grain_alone(run: TowerRun) -> list[tuple[float, float]]:
    """Return (from, to) [t0] of every stretch in which nothing presses on the grain.

    The last one ends with the run if the grain does not come back.
    """
    changes = chain_changes(run)
    ends = [time for time, _ in changes[1:]] + [float(run.time_over_t0[-1])]
    return [
        (time, end) for (time, contacts), end in zip(changes, ends, strict=True) if contacts == 0
    ]
