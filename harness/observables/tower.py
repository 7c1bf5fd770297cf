"""The result of one tower run, the same type from every solver and engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.observables.provenance import Observable, Provenance
from harness.parameters.tower import Tower
from harness.shown import Result, power

if TYPE_CHECKING:
    from harness.shown.figure import Figure

Floats = NDArray[np.float64]

SERIES = (
    Observable("time", "s", "time", "time since the grain touched, or since the start"),
    Observable("grain_displacement", "m", "time", "grain from where all particles just touch"),
    Observable("grain_velocity", "m/s", "time", "velocity of the grain, along gravity"),
    Observable("grain_force", "N", "time", "contact force on the grain, gravity left out"),
    Observable("contacts", "1", "time", "closed contacts in the chain that begins at the grain"),
    Observable("compression", "m", "time", "approach of the centres of grain and base"),
    Observable("compression_rate", "m/s", "time", "rate of that approach"),
    Observable("kinetic_energy", "J", "time", "of all particles"),
    Observable("elastic_energy", "J", "time", "of all contacts"),
    Observable("gravitational_energy", "J", "time", "of all mobile particles, 0 where they touch"),
    Observable("momentum", "kg m/s", "time", "of all particles"),
    Observable("base_force", "N", "time", "force of the last contact, on the base"),
)
COLUMNS = tuple(observable.name for observable in SERIES)


class Profiles(NamedTuple):
    """Every particle and contact at every sample."""

    displacements: Floats  # (M, N) [m]
    velocities: Floats  # (M, N) [m/s]
    forces: Floats  # (M, n) [N]


@dataclass(frozen=True, repr=False)
class TowerRun(Result):
    """A tower in time: M samples, declared in :data:`SERIES`, and the last state.

    Time and step [s], displacements and compression [m], velocities and the rate of compression
    [m/s], forces [N], energies [J], momentum [kg m/s]; each series has the shape (M,).

    Samples need not be equally far apart. ``step`` [s] is None for a solver
    without one. ``profiles`` is None unless they were asked for, ``provenance`` unless
    an engine made the run.
    """

    tower: Tower
    solver: str
    step: float | None
    time: Floats
    grain_displacement: Floats
    grain_velocity: Floats
    grain_force: Floats
    contacts: Floats
    compression: Floats
    compression_rate: Floats
    kinetic_energy: Floats
    elastic_energy: Floats
    gravitational_energy: Floats
    momentum: Floats
    base_force: Floats
    final_displacement: Floats  # (N,) [m]
    final_velocity: Floats  # (N,) [m/s]
    profiles: Profiles | None = None
    provenance: Provenance | None = None

    @property
    def energy(self) -> Floats:
        """Return the total energy (M,) [J]."""
        return self.kinetic_energy + self.elastic_energy + self.gravitational_energy

    @property
    def time_over_t0(self) -> Floats:
        """Return the time in contact times of grain and one fixed particle (M,) [1]."""
        return self.time / self.tower.contact_time

    @property
    def known_profiles(self) -> Profiles:
        """Return the profiles; raise ValueError for a run that kept none."""
        if self.profiles is None:
            raise ValueError("this run kept no profiles")
        return self.profiles

    @property
    def deformations(self) -> Floats:
        """Return how much each particle's diameter is shortened (M, N) [m].

        Needs profiles. A contact force f shortens a particle by f/k, under
        either law.
        """
        force = np.pad(self.known_profiles.forces, ((0, 0), (1, 1)))
        stiffness = np.array(self.tower.each("stiffness"))
        return np.asarray((force[:, 1:] + force[:, :-1]) / stiffness)

    def contacts_above(self, least: float) -> Floats:
        """Return how many contacts from the grain on press with more than ``least`` [N] (M,).

        ``contacts`` counts every force above 0. In a touching row under the
        overlap law all contacts close at once, the far ones with forces too small
        to matter and at the mercy of rounding: a threshold makes codes comparable.
        Needs profiles.
        """
        pressing = np.cumprod(self.known_profiles.forces > least, axis=1).sum(axis=1)
        return np.asarray(pressing, dtype=np.float64)

    def to_frame(self) -> pd.DataFrame:
        """Return the series as a table, units in the names, ``t_over_t0`` in front."""
        columns = {"t_over_t0": self.time_over_t0}
        for observable in SERIES:
            columns[_column(observable)] = getattr(self, observable.name)
        return pd.DataFrame(columns).astype({"contacts": int})

    def summary(self) -> dict[str, str]:
        """Return the largest force, the case, and who ran it."""
        case, step = self.tower, "no step" if self.step is None else f"a step of {self.step:.4g} s"
        return {
            "peak force": f"{self.grain_force.max():.7g} N",
            "velocity of the grain at the end": f"{self.final_velocity[0]:.7g} m/s",
            "case": f"tower of height {case.height}, {case.law} law, "
            f"k = {power(case.each('stiffness')[0])} N/m, {case.speed:g} m/s",
            "length": f"{self.time_over_t0[-1]:.4g} t0, {self.time.size} samples",
            "engine": self.provenance.label if self.provenance else f"{self.solver}, {step}",
        }

    def draw(self) -> Figure:
        """Draw force and contacts of the grain against time."""
        from harness.shown.figure import Figure, label

        figure = Figure(figsize=(6.5, 4.4), layout="constrained")
        force, contacts = figure.subplots(2, 1, sharex=True)
        force.plot(self.time_over_t0, self.grain_force)
        contacts.step(self.time_over_t0, self.contacts, where="post")
        label(force, "", "force on the grain (N)", self.summary()["case"])
        label(contacts, "time (t0)", "contacts of the grain")
        return figure


def _column(observable: Observable) -> str:
    if observable.unit == "1":
        return observable.name
    return f"{observable.name}_{observable.unit.replace('/', '_per_').replace(' ', '_')}"
