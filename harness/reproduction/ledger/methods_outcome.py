"""Section Methods: what three particles do, and what the fixed one is."""

from __future__ import annotations

import numpy as np

from harness.observables.impulse import impulse_until
from harness.observables.windows import window_end
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, bounded, claim, untestable
from harness.reproduction.ledger.runs import free_collision, run
from harness.reproduction.source import SOURCES
from harness.theory.free_chain import final_velocities


def statements() -> list[Statement]:
    """Return the rows of this part."""
    return [_incomplete(), _stored(), _softer(), _fixed_particle()]


def listed(values: np.ndarray) -> str:
    """Return numbers for a text."""
    return ", ".join(f"{value:.4f}" for value in values)


def _incomplete() -> Statement:
    final = free_collision(3).final_velocity / 2.0
    reference = final_velocities(3, deformable=True)
    return claim(
        SOURCES["text-incomplete"],
        holds=final[0] < -1e-3 and bool(np.abs(final - reference).max() < 1e-9),
        computed=f"velocities over the grain's: {listed(final)}, by matrix exponentials "
        f"{listed(reference)}",
    )


def _stored() -> Statement:
    two, three = free_collision(2), free_collision(3)
    total = [float(one.deformations.sum(axis=1).max()) for one in (two, three)]
    stored = [float(one.elastic_energy.max() / one.kinetic_energy[0]) for one in (two, three)]
    return claim(
        SOURCES["text-stored"],
        holds=total[1] > total[0] and stored[1] > stored[0],
        computed=f"largest sum of deformations {1e3 * total[0]:.3f} and {1e3 * total[1]:.3f} mm at "
        f"1e6 N/m and 2 m/s ({100 * (total[1] / total[0] - 1):+.1f} %), largest energy "
        f"{stored[0]:.4f} and {stored[1]:.4f} of the grain's ({stored[1] / stored[0]:.2f} times, "
        "not twice as U_n = n U_1 would have it)",
    )


def _softer() -> Statement:
    softer = []
    for stiffness in (1e6, 1e6 / 2, 1e6 / 3):
        pair = Tower(stiffness=(1e6, stiffness), base="free", gravity=0.0)
        softer.append(float(run(pair, 1.5).final_velocity[0]) / pair.speed)
    rebound = float(final_velocities(3, deformable=True)[0])
    return claim(
        SOURCES["text-softer"],
        holds=abs(rebound) < 1e-3,
        computed="the grain keeps "
        + ", ".join(bounded(value) for value in softer)
        + f" of its speed after one free particle of k, k/2 and k/3, and {rebound:.4f} after two "
        "of k: stiffness does not enter the outcome of two bodies, a larger mass does",
    )


def _fixed_particle() -> Statement:
    def alphas(base_times: float) -> list[float]:
        found = []
        for height in (2, 10):
            k = (*(1e6,) * height, 1e6 * base_times)
            found.append(_impulse(height, k) / _impulse(1, (1e6, 1e6 * base_times)))
        return found

    soft, hard = alphas(1.0), alphas(1e6)
    return untestable(
        SOURCES["text-fixed-particle"],
        computed=f"alpha(2) and alpha(10) are {listed(np.array(soft))} with a fixed particle that "
        f"deforms and {listed(np.array(hard))} with one that does not (1e6 N/m, 2 m/s)",
    )


def _impulse(height: int, stiffness: tuple[float, ...]) -> float:
    whole = run(Tower(height=height, stiffness=stiffness))
    return impulse_until(whole, window_end(whole, "turnaround"))
