"""Section Results: contacts and forces on the grain of a tower in time."""

from __future__ import annotations

import numpy as np

from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.runs import contact_intervals, run
from harness.reproduction.source import SOURCES
from harness.theory.two_spheres import contact_time_on_fixed


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    three = run(Tower(height=2))
    return [_unit_of_time(), _collapse(), _begins(three), *_times(three, printed), _aligned(three)]


def _unit_of_time() -> Statement:
    case = Tower(height=1)
    one = run(case)
    found = contact_intervals(one)[0][1] * one.tower.contact_time
    return compare(
        SOURCES["text-unit-of-time"],
        printed=contact_time_on_fixed(1.0, 1e6, 2.0, 9.81),
        found=found,
        computed=f"contact of the grain with one fixed particle at 1e6 N/m and 2 m/s: {found:.6f} "
        "s in the run, (2/omega)(pi - atan(v0 omega/g)) in closed form",
    )


def _collapse() -> Statement:
    grid = np.linspace(0.0, 3.0, 601)
    off = {}
    for height in (2, 9):
        curves = []
        for stiffness in (1e5, 1e6, 1e7):
            one = run(Tower(height=height, stiffness=stiffness))
            force = np.interp(grid, one.time_over_t0, one.grain_force)
            curves.append(force / run(Tower(height=1, stiffness=stiffness)).grain_force.max())
        off[height] = [float(np.abs(curves[i] - curves[i + 1]).max()) for i in (0, 1)]
    return claim(
        SOURCES["text-collapse"],
        holds=max(max(values) for values in off.values()) < 0.1,
        computed="; ".join(
            f"{height + 1} particles: force curves of 1e5 and 1e6 N/m at most {values[0]:.3f}, of "
            f"1e6 and 1e7 N/m {values[1]:.3f} of the two-particle peak apart"
            for height, values in off.items()
        )
        + " (3 t0, 2 m/s): exact without gravity, with it the one parameter m g/(v0 sqrt(k m)) "
        "is left, which tells at 1e5 N/m",
    )


def _begins(three: TowerRun) -> Statement:
    early = (three.time_over_t0 > 0.01) & (three.time_over_t0 < 0.4)
    assert three.profiles is not None
    displaced = float(np.abs(three.profiles.displacements[early, 2]).max())
    opened = bool((three.profiles.forces[early, 1] == 0).all())
    return claim(
        SOURCES["text-parts"],
        holds=opened and bool((three.contacts[early] == 1).all()) and displaced == 0,
        computed="from 0.01 to 0.4 t0 the second contact carries no force and the grain's chain "
        "is one contact long",
    )


def _times(three: TowerRun, printed: Printed) -> list[Statement]:
    first, second = contact_intervals(three)[:2]
    joins = float(three.time_over_t0[np.argmax(three.contacts == 2)])
    after = np.searchsorted(three.time_over_t0, second[0], side="right") + 1
    length = int(three.contacts[after])
    rows = [
        ("text-joins", printed.joins, joins),
        ("text-returns", printed.returns, second[0]),
        ("text-leaves", printed.leaves, second[1]),
    ]
    told = [
        compare(
            SOURCES[key],
            printed=value,
            found=found,
            computed=f"{found:.3f} t0 at 1e6 N/m and 2 m/s, deformable law, exact propagator",
        )
        for key, value, found in rows
    ]
    alone = claim(
        SOURCES["text-alone"],
        holds=second[0] > first[1] and length == 2,
        computed=f"alone from {first[1]:.3f} to {second[0]:.3f} t0, then {length} contacts",
    )
    return [*told, alone]


def _aligned(three: TowerRun) -> Statement:
    once = np.diff(three.time, prepend=-1.0) > 0  # a change of contacts is sampled twice
    force, contacts = three.grain_force[once], three.contacts[once]
    rate = np.gradient(force, three.time[once])
    scale = float(np.abs(rate).max())
    changes = np.flatnonzero(np.diff(contacts) != 0)
    inside = changes[(changes > 3) & (changes < force.size - 5)]
    kinks = [abs(float(rate[i + 4] - rate[i - 3])) / scale for i in inside]
    return claim(
        SOURCES["text-aligned"],
        holds=bool(kinks) and min(kinks) > 0.1,
        computed=f"slope of the grain's force jumps by {min(kinks):.2f} to {max(kinks):.2f} of its "
        f"largest value at the {len(kinks)} changes of its chain",
    )
