"""Engines that stand in for others: the reference DEM under other names, traits and faults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit

from harness.cases.tower.motion import tower_run
from harness.cases.tower.timing import plan
from harness.engines.reference.engine import Reference
from harness.errors import EngineCrashError, EngineMissingError
from harness.parameters.contact import Contact

TRAITS = replace(Reference.traits, install_hint="apt install it")


class Twin(Reference):
    """Runs inclines as the reference DEM does, and towers of 1 kg in the scheme it declares."""

    name = "twin"
    traits = replace(TRAITS, lineage="LAMMPS", caveats=("It grew out of LAMMPS.",))
    states_towers = True

    def __init__(self, program: str | None = None) -> None:
        super().__init__(self.traits.integrator)
        self.program = program

    def towers(self, cases, duration, *, steps_per_contact=None, samples=None, profiles=False):
        plans = [plan(case, duration, steps_per_contact, samples) for case in cases]
        half_kick = self.traits.integrator == "velocity-verlet"
        return [
            tower_run(
                case,
                timing.step,
                timing.step * timing.every * np.arange(timing.steps // timing.every + 1),
                *_row_of_particles(
                    case.particles,
                    case.each("stiffness")[0] / case.each("mass")[0],
                    case.gravity,
                    case.speed,
                    timing.step,
                    timing.steps,
                    timing.every,
                    half_kick,
                ),
                self.identify(),
                profiles=profiles,
            )
            for case, timing in zip(cases, plans, strict=True)
        ]


@njit(cache=True)
def _row_of_particles(particles, stiffness, gravity, speed, step, steps, every, half_kick):
    """Return displacements, velocities and forces (per mass) of an overlap row on a fixed base.

    Semi-implicit Euler; with ``half_kick`` velocity Verlet, which writes whole steps.
    """
    rows = steps // every + 1
    x, v, f = np.zeros(particles), np.zeros(particles), np.zeros(particles - 1)
    xs, vs = np.zeros((rows, particles)), np.zeros((rows, particles))
    fs = np.zeros((rows, particles - 1))
    v[0] = speed
    vs[0] = v
    share = 0.5 if half_kick else 1.0
    for i in range(1, steps + 1):
        for j in range(particles - 1):
            v[j] += share * step * (gravity + (f[j - 1] if j else 0.0) - f[j])
        x += step * v
        for j in range(particles - 1):
            f[j] = stiffness * max(x[j] - x[j + 1], 0.0)
        if half_kick:
            for j in range(particles - 1):
                v[j] += share * step * (gravity + (f[j - 1] if j else 0.0) - f[j])
        if i % every == 0:
            xs[i // every], vs[i // every], fs[i // every] = x, v, f
    return xs, vs, fs


class Clamped(Twin):
    name = "clamped"
    traits = replace(TRAITS, tails=("clipped",), caveats=("It always clips.",))


class Half(Twin):
    """As MFiX: half the mass, the tail kept, semi-implicit Euler."""

    name = "half"
    traits = replace(
        TRAITS, tails=("attractive",), effective_masses=("half",), integrator="mfix-euler"
    )


class Newer(Twin):
    name = "newer"
    traits = replace(TRAITS, versions=("0.0.1",))


class Missing(Twin):
    name = "missing"

    def identify(self):
        raise EngineMissingError("missing: no library of that name")


class Crashing(Twin):
    """Qualifies, and dies on every incline and tower."""

    name = "crashing"
    traits = TRAITS

    @staticmethod
    def _death():
        error = EngineCrashError("signal SIGSEGV")
        error.log = "input\nlast words\n"
        return error

    def inclines(self, cases, *_, **__):
        return [self._death() for _ in cases]

    def towers(self, cases, *_, **__):
        return [self._death() for _ in cases]


class Undamped(Twin):
    """Forgets its dashpot without a word, as a solver that fails to find one."""

    name = "undamped"
    traits = TRAITS

    def drops(self, cases):
        free = Contact(restitution=1.0)
        return super().drops([case.replace(contact=free) for case in cases])


ENGINES = {kind.name: kind for kind in (Twin, Clamped, Half, Newer, Missing, Crashing, Undamped)}
"""Every stand-in, by its name."""
