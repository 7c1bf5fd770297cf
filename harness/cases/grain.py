"""One grain on fixed spheres of its size: what the incline, columns and the tower have in common.

Its parameters and contact time, the runs of its jobs in an engine and what comes back.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from harness.engines.contract import Engine, Job, Output, Value
from harness.engines.output import Table
from harness.errors import EngineError
from harness.observables.reference import Trajectory
from harness.parameters.base import Parameters
from harness.parameters.law import SOURCE, NamedContact
from harness.parameters.scene import ContactScene, in_plane, spheres

COLUMNS = ("time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
"""Of a path in a table."""

UNIT_MASS_DENSITY = 6.0 / math.pi
"""[kg/m3] gives a sphere of 1 m the mass of 1 kg, as in the source."""


class Grain(Parameters):
    """A grain and the fixed spheres it meets: size, mass, contact and step, in SI units."""

    contact: NamedContact = Field(SOURCE, description="[-] dissipation of the contact")
    stiffness: float = Field(1e6, gt=0.0, description="[N/m] normal stiffness")
    steps_per_contact: float = Field(
        50.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)"
    )
    diameter: float = Field(1.0, gt=0.0, description="[m] diameter of all spheres")
    density: float = Field(UNIT_MASS_DENSITY, gt=0.0, description="[kg/m3] density of the grain")
    gravity: float = Field(9.81, gt=0.0, description="[m/s2] acceleration of gravity")

    @property
    def mass(self) -> float:
        """Return the grain's mass [kg]."""
        return self.density * math.pi / 6.0 * self.diameter**3

    @property
    def contact_time(self) -> float:
        """Return pi sqrt(m / k) [s], the undamped contact time that steps are counted in."""
        return math.pi * math.sqrt(self.mass / self.stiffness)

    @property
    def step(self) -> float:
        """Return the time step [s]."""
        return self.contact_time / self.steps_per_contact

    def settings(self) -> dict[str, float]:
        """Return what a script says it ran with, by the names of its results."""
        return {
            "mass_kg": self.mass,
            "stiffness_N_per_m": self.stiffness,
            "damping_coefficient_N_s_per_m": self.contact.dashpot(self.stiffness, self.mass),
            "gravity_m_per_s2": self.gravity,
            "step_s": self.step,
        }

    def values(self, *names: str) -> dict[str, Value]:
        """Return the properties of these names, as a script is told them."""
        return {name: getattr(self, name) for name in names}

    def scene(
        self, start: tuple[float, float, float, float], fixed: ArrayLike, **more: Any
    ) -> ContactScene:
        """Return the grain from a start (x, y, vx, vy) [m, m/s] and spheres at ``fixed`` (N, 2).

        The grain is particle 1. ``more`` are the fields that a case has for itself: ``gravity``,
        ``steps`` and so on.
        """
        places = np.vstack([start[:2], fixed])
        count = len(places)
        velocity = [start[2:], *[(0.0, 0.0)] * (count - 1)]
        sizes = np.full(count, self.mass), np.full(count, self.diameter)
        return in_plane(
            spheres(places, velocity, *sizes, np.arange(count) > 0),
            self.contact,
            self.stiffness,
            step=self.step,
            **more,
        )


def path_in(table: Table) -> Trajectory:
    """Return the grain's path: the first particle where a table has several."""
    columns = [np.asarray(table[name]) for name in COLUMNS]
    return Trajectory(*(c[:, 0] if c.ndim == 2 else c for c in columns))


P = TypeVar("P")
Run = TypeVar("Run")


def run_jobs(
    engine: Engine,
    cases: Sequence[P],
    job_of: Callable[[P], Job],
    read: Callable[[P, Output], Run],
) -> list[Run | EngineError]:
    """Run cases, in parallel where that helps, and return their results in order; errors in place.

    Raise RequestError for a case that the engine cannot state.
    """
    results: list[Run | EngineError] = []
    outputs = engine.run([job_of(case) for case in cases])
    for case, output in zip(cases, outputs, strict=True):
        try:
            if isinstance(output, EngineError):
                raise output
            results.append(read(case, output))
        except EngineError as error:
            if isinstance(output, Output):
                error.log = output.log
            results.append(error)
    return results


def complete(results: Iterable[Run | EngineError]) -> list[Run]:
    """Return results; raise the first error among them, for callers that need them all."""
    return [run_or_raise(result) for result in results]


def run_or_raise(result: Run | EngineError) -> Run:
    """Return a run; raise the error in its place where it failed."""
    if isinstance(result, EngineError):
        raise result
    return result
