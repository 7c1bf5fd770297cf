"""Make the result of a tower from what every engine can tell: where its particles were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.observables.provenance import Provenance
from harness.observables.tower import Profiles, TowerRun
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]


def tower_run(
    case: Tower,
    step: float,
    time: Floats,
    displacement: Floats,
    velocity: Floats,
    force: Floats,
    who: Provenance,
    *,
    profiles: bool = False,
) -> TowerRun:
    """Return the run of a tower of equal particles, M samples of N particles, grain first.

    ``time`` (M,) [s]; ``displacement`` (M, N) [m] from where all particles just touch, along the
    motion; ``velocity`` (M, N) [m/s]; ``force`` (M, N - 1) [N] of each contact, the
    engine's own, 0 where it is open; ``step`` [s].
    """
    mass, gravity = case.each("mass")[0], case.gravity
    overlap = displacement[:, :-1] - displacement[:, 1:]
    weight = np.full(case.particles, gravity)
    if case.base == "fixed":
        weight[-1] = 0.0
    return TowerRun(
        tower=case,
        solver=who.engine,
        step=step,
        time=time,
        grain_displacement=displacement[:, 0],
        grain_velocity=velocity[:, 0],
        grain_force=force[:, 0],
        contacts=_chain_of_grain(force),
        compression=displacement[:, 0] - displacement[:, -1],
        compression_rate=velocity[:, 0] - velocity[:, -1],
        kinetic_energy=0.5 * mass * np.sum(velocity**2, axis=1),
        elastic_energy=0.5 * np.sum(force * overlap, axis=1),
        gravitational_energy=-mass * displacement @ weight,
        momentum=mass * np.sum(velocity, axis=1),
        base_force=force[:, -1],
        final_displacement=displacement[-1],
        final_velocity=velocity[-1],
        profiles=Profiles(displacement, velocity, force) if profiles else None,
        provenance=who,
    )


def forces_of_contacts(force: Floats, weight: float, smallest: float) -> Floats:
    """Return the contact forces (M, n) from the forces on the particles (M, N), grain first.

    The engine's own forces, whatever law made them: particle i feels its weight
    [N], is pushed on by contact i - 1 and held by contact i. What is below
    ``smallest`` [N] is rounding.
    """
    contact = np.cumsum(weight - force[:, :-1], axis=1)
    contact[np.abs(contact) <= smallest] = 0.0
    return np.asarray(contact)


def _chain_of_grain(force: Floats) -> Floats:
    """Return how many contacts from the grain on press (M,)."""
    pressing = np.cumprod(force > 0.0, axis=1).sum(axis=1)
    return np.asarray(pressing, dtype=np.float64)
