"""What is to be seen in each motion, in words, with the numbers of the run."""

from __future__ import annotations

import numpy as np

from harness.cases.incline.result import InclineRun
from harness.observables.tower import TowerRun
from harness.theory.critical_angle import critical_angle

FELT_FORCE = 1e-6
"""A contact presses from this part of the peak force on; below it there is only rounding."""


def contact_changes(run: TowerRun) -> list[tuple[float, tuple[int, ...]]]:
    """Return each change of contacts: the time [t0] and the contacts that press from then on.

    Contacts count from 1, the grain's. Needs profiles; the times are as good as the samples.
    """
    if run.profiles is None:
        raise ValueError("run without profiles: no contact forces")
    pressing = run.profiles.forces > FELT_FORCE * run.profiles.forces.max()
    rows = 1 + np.flatnonzero((pressing[1:] != pressing[:-1]).any(axis=1))
    return [
        (float(run.time_over_t0[row]), tuple(int(i) + 1 for i in np.flatnonzero(pressing[row])))
        for row in rows
    ]


def pair_sentence(run: TowerRun) -> str:
    """Say how long two particles touch, how much they give, and how fast they part."""
    end, _ = contact_changes(run)[-1]
    return (
        f"They touch for {end:.3f} t0, each shortened by up to {1e3 * run.deformations.max():.2f} "
        f"mm, and part with {_velocities(run)} m/s."
    )


def triple_sentence(run: TowerRun) -> str:
    """Say who touches when, and how fast the three part."""
    names = {(1,): "grain and second", (2,): "second and third", (1, 2): "all three", (): "none"}
    story = [f"{names[c]} from {t:.2f} t0" for t, c in contact_changes(run)[1:]]
    most = [f"{1e3 * most:.2f}" for most in run.deformations.max(axis=0)]
    return (
        f"First grain and second touch; {', '.join(story)}. They are shortened by up to "
        f"{', '.join(most)} mm. "
        f"They part with {_velocities(run)} m/s."
    )


def tower_sentence(run: TowerRun) -> str:
    """Say when the shock is at the base, how many contacts carry it, and how strong it is."""
    if run.profiles is None:
        raise ValueError("run without profiles: no contact forces")
    forces, n = run.profiles.forces, run.tower.height
    at_base = forces.argmax(axis=1) == n - 1
    if not at_base.any():
        return "The shock does not reach the base."
    arrival = int(at_base.argmax())
    carrying = (forces[:arrival] > 0.1 * forces[:arrival].max(axis=1, keepdims=True)).sum(axis=1)
    middle = forces[: arrival + 1, n // 2].max()
    return (
        f"The strongest contact is the last one, {n}, from {run.time_over_t0[arrival]:.2f} t0 on. "
        f"On the way down at most {carrying.max()} contacts at a time carry a tenth of the "
        f"strongest or more. The largest force is {forces[:, 0].max() / 1e3:.2f} kN on the "
        f"grain, {middle / 1e3:.2f} kN in the middle and {forces[:, -1].max() / 1e3:.2f} kN "
        "on the base."
    )


def incline_sentence(below: InclineRun, above: InclineRun) -> str:
    """Say how far the grain comes at either angle."""
    assert below.trajectory is not None
    closed = critical_angle()
    diameter = below.case.diameter
    return (
        f"The closed form has the critical angle at {closed:.4f} deg. {_fate(below)}; "
        f"its path ends where it turns back, at {below.trajectory.x_m[-1] / diameter:.2f} "
        f"diameters. {_fate(above)}."
    )


def _fate(run: InclineRun) -> str:
    """Say what became of a grain: ``At 10.20 deg it is trapped after 6 crests (14.8 s)``."""
    words = {"moves_on": "moves on over", "trapped": "is trapped after"}
    crests = len(run.crests.time_s)
    fate = words.get(run.motion.value, "is undecided after")
    return f"At {run.case.angle:.2f} deg it {fate} {crests} crests ({run.time_s:.1f} s)"


def _velocities(run: TowerRun) -> str:
    # + 0.0: rounding may leave a minus before a zero
    return ", ".join(f"{round(v, 2) + 0.0:.2f}" for v in run.final_velocity)
