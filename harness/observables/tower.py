"""The result of one tower run, from whatever solver or engine, and the impulse on its grain.

A window says how long the impulse is summed up; there are three. They need the series of a run
alone, so they are the same for a solver and an engine. Times count from the start of the run; where
the grain has a gap to cross first, a window is measured from its touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.errors import RequestError
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


# ---- the motion of the grain between samples
def hermite(time: Floats, value: Floats, rate: Floats, at: float) -> float:
    """Return the cubic through values and rates (M,) on both sides of ``at`` [s].

    Its error is of fourth order in the distance of the samples.
    """
    i = int(np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2))
    width = float(time[i + 1] - time[i])
    if width == 0:
        return float(value[i])
    s = (at - float(time[i])) / width
    start, end = float(value[i]), float(value[i + 1])
    slope_before, slope_after = width * float(rate[i]), width * float(rate[i + 1])
    cubic = 2 * (start - end) + slope_before + slope_after
    return start + s * (
        slope_before + s * (3 * (end - start) - 2 * slope_before - slope_after + s * cubic)
    )


def grain_acceleration(run: TowerRun) -> Floats:
    """Return the acceleration of the grain (M,) [m/s2]."""
    return run.tower.gravity - run.grain_force / run.tower.each("mass")[0]


def grain_velocity_at(run: TowerRun, time: float) -> float:
    """Return the velocity of the grain [m/s] at ``time`` [s]."""
    return hermite(run.time, run.grain_velocity, grain_acceleration(run), time)


SIGNIFICANT_FORCE = 1e-6
"""Contacts that press with more than this part of the peak; fainter ones are rounding's."""


def significant_contacts(run: TowerRun) -> Floats:
    """Return the contacts of the grain's chain above rounding (M,), of a run with profiles.

    All that carry a force, of one without.
    """
    if run.profiles is None:
        return run.contacts
    return run.contacts_above(SIGNIFICANT_FORCE * float(run.grain_force.max()))


Window = Literal["turnaround", "structure", "first-contact"]
WINDOWS: tuple[Window, ...] = ("turnaround", "structure", "first-contact")
SEARCH = 3.0  # [t0] within which the largest compression is looked for, the source's bound

_EQUAL = 1e-5  # of a peak: what 1000 samples per t0 may miss of its height, and some more


# ---- the ends of windows


def window_end(run: TowerRun, window: Window) -> float:
    """Return when ``window`` ends [s].

    Raise RequestError if the run is too short to tell.
    """
    if window == "turnaround":
        touch = touch_time(run)
        return touch + 2 * (turnaround(run) - touch)
    if window == "structure":
        return structure_end(run)
    if window == "first-contact":
        return first_contact_end(run)
    raise RequestError(f"window = {window!r}: must be one of {', '.join(WINDOWS)}")


def touch_time(run: TowerRun) -> float:
    """Return when the grain first touches [s], 0 unless the start has gaps."""
    if run.tower.start != "gapped":
        return 0.0
    touching = np.flatnonzero(run.grain_force > 0)
    if touching.size == 0:
        raise _too_short(run, "the grain does not touch by then")
    return float(run.time[touching[0]])


def turnaround(run: TowerRun) -> float:
    """Return when grain and base are closest, within 3 t0 of the touch [s].

    The source's choice (its second appendix, on picking a time scale); the
    window is twice as long. Under strong gravity a tall tower may still sink at
    3 t0, which is then the answer. Of peaks that no sampling tells apart, as those
    of a grain that bounces on a rigid base, the first counts. It is where the rate falls through
    zero next to the highest sample, which positions in single precision may put some samples
    away. Raise RequestError for a run that ends before.
    """
    bound = touch_time(run) + SEARCH * run.tower.contact_time
    if run.time[-1] < bound * (1 - 1e-9):
        raise _too_short(run, f"the closest approach is looked for up to {SEARCH:g} t0")
    inside = int(np.count_nonzero(run.time <= bound * (1 + 1e-12)))
    best = _first_of_the_highest(run.compression[:inside])
    rate = run.compression_rate
    turns = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
    turns = turns[turns < inside]
    away = np.abs(turns + 0.5 - best)
    sinking = best == inside - 1 and rate[best] > 0
    if away.size and (away.min() < 1.0 or not sinking):
        acceleration = _compression_acceleration(run)
        i = int(turns[away.argmin()])
        return min(bound, _falls_through_zero(run.time, rate, acceleration, i))
    return bound if sinking else float(run.time[best])


def structure_end(run: TowerRun, least: int | None = None) -> float:
    """Return when the grain's chain, having held all n contacts, is down to one or none [s].

    The first such time after t0; the source uses it for two to seven particles.
    The chain may pass other lengths on its way down. With ``least``, a chain that
    held so many contacts will do: a looser reading, for towers whose chain never
    reaches the base. Between samples of a solver with a step, the force of the
    contact that opens is drawn on to 0, for which the run needs profiles; without
    them the window ends at the sample after.
    """
    full = False
    after = touch_time(run) + run.tower.contact_time * (1 - 1e-9)
    enough = run.tower.height if least is None else min(least, run.tower.height)
    down_to = min(1, run.tower.height - 1)
    for i in range(run.time.size):
        if run.contacts[i] >= enough:
            full = True
        elif run.contacts[i] <= down_to:
            if full and run.time[i] >= after:
                opens = int(run.contacts[i])  # the first that is open
                return _force_vanishes(run, i - 1, opens)
            full = False
    held = "all" if least is None else f"{enough}"
    raise _too_short(run, f"the grain's chain has not swung from {held} contacts to one")


def first_contact_end(run: TowerRun) -> float:
    """Return when the grain first detaches [s].

    Between samples of a solver with a step the force is drawn on to 0.
    """
    touching = np.flatnonzero((run.grain_force > 0) & (run.time > 0))
    if touching.size:
        i = int(touching[0])
        while i < run.time.size and run.grain_force[i] > 0:
            i += 1
        if i < run.time.size:
            return _force_vanishes(run, i - 1)
    raise _too_short(run, "the grain has not detached")


def _first_of_the_highest(value: Floats) -> int:
    """Return the row of the first peak that is as high as the highest, to ``_EQUAL``."""
    top = float(np.max(value))
    row = int(np.flatnonzero(value >= top - _EQUAL * abs(top))[0])
    while row + 1 < value.size and value[row + 1] > value[row]:
        row += 1
    return row


def _force_vanishes(run: TowerRun, i: int, contact: int = 0) -> float:
    """Return when the force that row ``i`` still holds vanishes, at row ``i + 1`` or before.

    The parabola through three rows, a straight line where there are but two.
    """
    has_forces = contact == 0 or run.profiles is not None
    if run.step is None or i == 0 or not has_forces:
        return float(run.time[i + 1])
    force = run.profiles.forces[:, contact] if run.profiles else run.grain_force
    slope, bend = _slope(run.time, force, i), 0.0
    if i > 1:
        before = _slope(run.time, force, i - 1)
        bend = (slope - before) / float(run.time[i] - run.time[i - 2])
    since = 0.0
    for _ in range(4):
        steepness = slope + bend * (since + float(run.time[i] - run.time[i - 1]))
        if steepness >= 0:
            return float(run.time[i + 1])
        since = -float(force[i]) / steepness
    return min(float(run.time[i + 1]), float(run.time[i]) + since)


def _slope(time: Floats, value: Floats, i: int) -> float:
    return float((value[i] - value[i - 1]) / (time[i] - time[i - 1]))


def _compression_acceleration(run: TowerRun) -> Floats:
    """Return the second derivative of the compression (M,) [m/s2]."""
    if run.tower.base == "fixed":
        return grain_acceleration(run)
    base = run.base_force / run.tower.each("mass")[-1] + run.tower.gravity
    return grain_acceleration(run) - base


def _falls_through_zero(time: Floats, value: Floats, rate: Floats, i: int) -> float:
    """Return when the cubic between rows ``i`` and ``i + 1`` falls through 0 [s]."""
    low, high = float(time[i]), float(time[i + 1])
    if value[i + 1] == 0 or high == low:
        return high
    pair = slice(i, i + 2)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if hermite(time[pair], value[pair], rate[pair], middle) > 0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _too_short(run: TowerRun, why: str) -> RequestError:
    reached = run.time[-1] / run.tower.contact_time
    return RequestError(f"duration = {reached:.6g} t0: too short, {why}")


# ---- what a run is summed up in


def impulse_until(run: TowerRun, time: float) -> float:
    """Return the integral of the contact force on the grain up to ``time`` [N s].

    Momentum balance, ``J = m (v0 - v) + m g t``: exact, where a quadrature of the
    samples of the force would not be. Raise RequestError beyond the run.
    """
    t0 = run.tower.contact_time
    if not 0 <= time <= run.time[-1] * (1 + 1e-9):
        raise RequestError(
            f"duration = {run.time[-1] / t0:.6g} t0: must be at least {time / t0:.6g} t0, "
            "where the window ends"
        )
    mass = run.tower.each("mass")[0]
    lost = float(run.grain_velocity[0]) - grain_velocity_at(run, time)
    return mass * (lost + run.tower.gravity * time)


def impulse(run: TowerRun, window: Window = "turnaround") -> float:
    """Return the impulse on the grain over ``window`` [N s]."""
    return impulse_until(run, window_end(run, window))


@dataclass(frozen=True)
class ImpulseRow:
    """One entry of the impulse table: ``ratio`` is alpha(n) = J(n)/J(1).

    ``window_s``, ``impulse_Ns`` and ``ratio`` are NaN where the window does not
    exist, as the structure window of tall towers.
    """

    height: int
    stiffness: float  # [N/m]
    speed: float  # [m/s]
    law: str
    window: str
    window_s: float  # [s] its end
    impulse_Ns: float  # [N s]
    ratio: float  # [1]


def peak_force(run: TowerRun) -> float:
    """Return the largest contact force on the grain [N].

    The top of the parabola through the largest sample and its neighbours; the
    sample itself where they do not lie below a maximum.
    """
    i = int(np.argmax(run.grain_force))
    peak = float(run.grain_force[i])
    if not 0 < i < run.time.size - 1:
        return peak
    before, after = run.time[i - 1] - run.time[i], run.time[i + 1] - run.time[i]
    if before == 0 or after == 0:
        return peak
    down = (run.grain_force[i - 1] - peak) / before
    up = (run.grain_force[i + 1] - peak) / after
    curvature = (up - down) / (after - before)
    if curvature >= 0:
        return peak
    slope = up - curvature * after
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
    run: TowerRun, window: Window = "turnaround", covering: TowerRun | None = None
) -> dict[str, Any]:
    """Return what ``dem-harness tower --json`` prints.

    ``covering`` is a run of the same case that covers the window, where ``run`` does
    not. ``turnaround_s`` is when grain and base are closest; ``window_s`` is when
    the window of ``impulse_Ns`` ends, for the turnaround window twice as late.
    """
    tower, covering = run.tower, covering or run
    end = window_end(covering, window)
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
        "impulse_Ns": impulse_until(covering, end),
        "peak_force_N": peak_force(run),
        "contact_time_s": tower.contact_time,
        "turnaround_s": turnaround(covering),
        "energy_drift": energy_drift(run),
        "contacts": [list(change) for change in contact_changes(run)],
        "final_velocity_m_per_s": [float(value) for value in run.final_velocity],
        **(run.provenance.to_json() if run.provenance else {}),
    }
