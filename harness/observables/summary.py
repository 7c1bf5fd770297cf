"""Summary of a tower run in a few numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from harness.observables.impulse import impulse_until
from harness.observables.tower import TowerRun
from harness.observables.windows import Window, turnaround, window_end


def peak_force(run: TowerRun) -> float:
    """Return the largest contact force on the grain [N].

    The top of the parabola through the largest sample and its neighbours; the
    sample itself where they do not lie below a maximum.
    """
    i = int(np.argmax(run.grain_force))
    peak = float(run.grain_force[i])
    if not 0 < i < run.time.size - 1:
        return peak
    left, right = run.time[i - 1] - run.time[i], run.time[i + 1] - run.time[i]
    if left == 0 or right == 0:
        return peak
    down = (run.grain_force[i - 1] - peak) / left
    up = (run.grain_force[i + 1] - peak) / right
    curvature = (up - down) / (right - left)
    if curvature >= 0:
        return peak
    slope = up - curvature * right
    return peak - float(slope**2 / (4 * curvature))


def energy_drift(run: TowerRun) -> float:
    """Return the largest relative deviation of the total energy [-].

    As a part of the largest sum of kinetic and elastic energy of the run; 0 where nothing moves.
    """
    scale = float(np.max(run.kinetic_energy + run.elastic_energy))
    return float(np.max(np.abs(run.energy - run.energy[0]))) / scale if scale > 0 else 0.0


def contact_changes(run: TowerRun) -> list[tuple[float, int]]:
    """Return (t/t0, contacts in the grain's chain) at the start and whenever they change.

    A grain that begins in touch has the contacts of the next sample already.
    """
    contacts = run.contacts.astype(int)
    if run.tower.start != "gapped":
        contacts[0] = contacts[min(1, contacts.size - 1)]
    rows = np.flatnonzero(np.diff(contacts, prepend=-1))
    return [(float(run.time_over_t0[i]), int(contacts[i])) for i in rows]


def grain_alone(run: TowerRun) -> list[tuple[float, float]]:
    """Return (from, to) [t0] of every stretch in which nothing presses on the grain.

    The last one ends with the run if the grain does not come back.
    """
    changes = contact_changes(run)
    ends = [time for time, _ in changes[1:]] + [float(run.time_over_t0[-1])]
    return [
        (time, end) for (time, contacts), end in zip(changes, ends, strict=True) if contacts == 0
    ]


def summary(
    run: TowerRun, window: Window = "turnaround", whole: TowerRun | None = None
) -> dict[str, Any]:
    """Return what ``dem-harness tower --json`` prints.

    ``whole`` is a run of the same case that covers the window, where ``run`` does
    not. ``turnaround_s`` is when grain and base are closest; ``window_s`` is when
    the window of ``impulse_Ns`` ends, for the turnaround window twice as late.
    """
    tower, whole = run.tower, whole or run
    end = window_end(whole, window)
    return {
        "law": tower.law,
        "solver": run.solver,
        "height": tower.height,
        "stiffness_N_per_m": tower.stiffness,
        "mass_kg": tower.mass,
        "speed_m_per_s": tower.speed,
        "gravity_m_per_s2": tower.gravity,
        "base": tower.base,
        "step_s": run.step,
        "duration_s": float(run.time[-1]),
        "window": window,
        "window_s": end,
        "impulse_Ns": impulse_until(whole, end),
        "peak_force_N": peak_force(run),
        "contact_time_s": tower.contact_time,
        "turnaround_s": turnaround(whole),
        "energy_drift": energy_drift(run),
        "contacts": [list(change) for change in contact_changes(run)],
        "final_velocity_m_per_s": [float(value) for value in run.final_velocity],
        **(run.provenance.record() if run.provenance else {}),
    }
