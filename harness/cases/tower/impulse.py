"""The impulse on the grain of a tower over a window of time, and the critical angle from it.

The windows need the series of a run alone, so they are the same for a solver and an engine. Times
count from the start of the run; where the grain has a gap to cross first, a window begins with its
touch.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from harness.cases.bench import Bench
from harness.cases.tower.parameters import LAWS, SEARCH, Law, Tower
from harness.cases.tower.runs import Progress, TowerRun, make_setup, run_in, solve
from harness.engines.base import Engine
from harness.errors import RequestError
from harness.model.scene import Floats
from harness.report.content import power
from harness.theory import incline
from harness.theory.chain import Reading, shock_from_impulse_ratio

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Window = Literal["turnaround", "structure", "first-contact"]
WINDOWS: tuple[Window, ...] = get_args(Window)
READINGS: tuple[Reading, ...] = get_args(Reading)
HEIGHTS = tuple(range(1, 20))  # the source's runs, whose stiffness it calls rigidity 1e4 to 1e6
STIFFNESSES = (1e5, 1e6, 1e7)  # [N/m]
SPEEDS = (2.0, 4.0)  # [m/s]
MARGIN = 1.001  # a longer run has another step, and finds the end of its window a little off
EQUAL_PEAKS = 1e-5  # of a peak: more than 1000 samples per t0 may miss of its height
MEASURED = ("h_over_d", "theta_deg")  # columns of a user's measured angles
QUASI_STATIC = (5.76, 0.22)  # [deg] frictionless spheres, Peyneau and Roux (2008), PRE 78, 011307


def impulse_angles(  # noqa: PLR0913 - the options of a user
    *,
    reading: Reading = "lost",
    case: Tower | None = None,
    solver: str | None = None,
    engine: Engine | None = None,
    progress: Progress = lambda *_: None,
    heights: Iterable[int] = HEIGHTS,
    stiffnesses: Iterable[float] = STIFFNESSES,
    speeds: Iterable[float] = SPEEDS,
    laws: Iterable[Law] = LAWS,
    windows: Sequence[Window] = ("turnaround",),
) -> pd.DataFrame:
    """Return alpha(n) = J(n)/J(1) [1] and theta_c(n) [deg], a row for each combination.

    Heights, stiffnesses [N/m] and speeds [m/s] are the source's unless given; ``case`` has the
    other parameters. An engine runs the heights of one law, stiffness and speed together; without
    one the ``solver`` does, RK4 unless named. ``progress`` is called for each.

    ``critical_angle_deg`` is that of ``reading``; both readings have columns too. ``window_s`` is
    the end of a window; it, impulse, ratio and angles are NaN where a tower does not show the
    window, as the structure window of tall ones. Raise RequestError for another reading or window.
    """
    import pandas as pd

    _check_word("reading", reading, READINGS)
    for window in windows:  # at first: a run without its window is NaN
        _check_word("window", window, WINDOWS)
    runner, rows, heights = Runner(solver or "rk4", engine), [], tuple(heights)
    first_too = dict.fromkeys((1, *heights))  # height 1 first, which others need
    families = [
        (case or Tower()).replace(law=law, stiffness=k, speed=speed, height=1)
        for law, k, speed in itertools.product(laws, stiffnesses, speeds)
    ]
    if engine is not None:  # before it runs those that it takes
        engine.check(make_setup(family).job for family in families)
    for number, family in enumerate(families):
        impulses = {}
        for run in runner.runs([family.replace(height=height) for height in first_too]):
            impulses[run.tower.height] = [runner.impulse(run, window) for window in windows]
            done = number * len(first_too) + len(impulses)
            progress("towers", done, len(families) * len(first_too))
        for height, (place, window) in itertools.product(heights, enumerate(windows)):
            end, value = impulses[height][place]
            ratio = value / impulses[1][place][1]
            angles = {name: angle_from_impulse_ratio(ratio, name) for name in READINGS}
            rows.append({
                "height": height,
                "stiffness_N_per_m": family.each("stiffness")[0],
                "speed_m_per_s": family.speed,
                "law": family.law,
                "window": window,
                "impulse_ratio": ratio,
                "critical_angle_deg": angles[reading],
                **{f"critical_angle_{name}_deg": angle for name, angle in angles.items()},
                "impulse_Ns": value,
                "window_s": end,
                "gamma": family.gamma,
            })  # fmt: skip
    return pd.DataFrame(rows)


def _check_word(name: str, word: str, allowed: Sequence[str]) -> None:
    if word not in allowed:
        raise RequestError(f"{name} = {word!r}: must be one of {', '.join(allowed)}")


def angle_from_impulse_ratio(ratio: float, reading: Reading = "lost") -> float:
    """Return the critical angle [deg] of an impulse ratio alpha.

    NaN unless 0 < alpha < 2, where the shock of neither reading is one.
    """
    if not 0.0 < ratio < 2.0:
        return math.nan
    return incline.critical_angle(shock_from_impulse_ratio(ratio, reading))


@cache
def source_table() -> pd.DataFrame:
    """Return :func:`impulse_angles` of the source: turnaround window, 1e6 N/m and 2 m/s; exact."""
    return impulse_angles(stiffnesses=(1e6,), speeds=(2.0,), solver="exact")


def source_angles(height: int, law: Law) -> Mapping[Reading, float]:
    """Return the source's theta_c(n) [deg] by its reading."""
    table = source_table()
    row = table[(table["law"] == law) & (table["height"] == height)]
    return {reading: float(row[f"critical_angle_{reading}_deg"].iloc[0]) for reading in READINGS}


def angle_figure(
    frame: pd.DataFrame,
    *,
    readings: Sequence[Reading] = ("lost", "kept"),
    measured: pd.DataFrame | None = None,
) -> Figure:
    """Draw critical angles of a table of ``impulse_angles`` against height, a panel a law.

    ``measured`` has the columns ``MEASURED``: heights [diameters] and angles [deg].
    """
    from harness.report.figures import BLACK, COLOURS, STYLES, label, legend_below, panels

    laws = list(dict.fromkeys(frame["law"]))
    figure = panels(1, len(laws))
    for axes, law in zip(figure.axes, laws, strict=True):
        part = frame[(frame["law"] == law) & (frame["window"] == frame["window"].iloc[0])]
        groups = part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False)
        for colour, ((k, speed), run) in enumerate(groups, 1):
            for style, reading in zip(STYLES, readings, strict=False):
                axes.plot(
                    run["height"], run[f"critical_angle_{reading}_deg"],
                    color=COLOURS[colour % len(COLOURS)], linestyle=style, marker=".",
                    label=f"velocity {reading}, k = {power(k)} N/m, {speed:g} m/s",
                )  # fmt: skip
        band = (QUASI_STATIC[0] - QUASI_STATIC[1], QUASI_STATIC[0] + QUASI_STATIC[1])
        axes.axhspan(*band, color="0.85", label="quasi-static, Peyneau and Roux 2008")
        if measured is not None:
            heights, angles = (measured[name] for name in MEASURED)
            axes.plot(heights, angles, "x", color=BLACK, label="measured")
        axes.locator_params(axis="x", integer=True)
        label(axes, "height (contacts)", "critical angle (deg)", f"{law} law")
    legend_below(figure)
    return figure


@dataclass(frozen=True)
class Runner:
    """Runs towers by a solver, or in an engine where one is given."""

    solver: str
    engine: Engine | None = None

    def runs(self, cases: Sequence[Tower], duration: float = SEARCH) -> Iterator[TowerRun]:
        """Yield the runs of ``cases`` for ``duration`` [t0]; in an engine they are one batch."""
        if self.engine is None:
            yield from (solve(case, self.solver, duration=duration) for case in cases)
        else:
            yield from run_in(Bench(self.engine), *(make_setup(case, duration) for case in cases))

    def covering(self, run: TowerRun, window: Window) -> TowerRun:
        """Return ``run``, or a longer one of the same case that covers ``window``.

        Closest approach and impulse need 3 t0, and more where the window ends later. Raise
        RequestError if the tower does not show that window.
        """
        t0, long = run.tower.contact_time, run
        if long.time[-1] < (touch_time(run) + SEARCH * t0) * (1 - 1e-9):
            (long,) = self.runs([run.tower], touch_time(run) / t0 + SEARCH)
        end = max(window_end(long, name) for name in {window, "turnaround"})
        if end > long.time[-1]:
            (long,) = self.runs([run.tower], end / t0 * MARGIN)
        return long

    def impulse(self, run: TowerRun, window: Window) -> tuple[float, float]:
        """Return the end [s] of a window and the impulse [N s], NaN where there is none."""
        try:
            covered = self.covering(run, window)
        except RequestError:
            return math.nan, math.nan
        return window_end(covered, window), impulse(covered, window)


# ---- windows


def window_end(run: TowerRun, window: Window) -> float:
    """Return when ``window`` ends [s]. Raise RequestError if the run is too short."""
    _check_word("window", window, WINDOWS)
    if window == "structure":
        return structure_end(run)
    if window == "first-contact":
        return first_contact_end(run)
    touch = touch_time(run)
    return touch + 2 * (turnaround(run) - touch)


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

    The source's choice (its second appendix, on picking a time scale); the window is twice as
    long. Under strong gravity a tall tower may still sink at 3 t0, which is then the answer. Of
    peaks that no sampling resolves, as those of a grain that bounces on a rigid base, the first
    counts. It is where the rate falls through zero next to the highest sample. Raise RequestError
    for a run that ends before.
    """
    bound = touch_time(run) + SEARCH * run.tower.contact_time
    if run.time[-1] < bound * (1 - 1e-9):
        raise _too_short(run, f"the closest approach is looked for up to {SEARCH:g} t0")
    inside = int(np.count_nonzero(run.time <= bound * (1 + 1e-12)))
    best = _first_of_the_highest(run.compression[:inside])
    rate = run.compression_rate
    turns = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
    turns = turns[turns < inside]
    distance = np.abs(turns + 0.5 - best)
    sinking = best == inside - 1 and rate[best] > 0
    if distance.size and (distance.min() < 1.0 or not sinking):
        return min(bound, _falls_through_zero(run, int(turns[distance.argmin()])))
    return bound if sinking else float(run.time[best])


def structure_end(run: TowerRun) -> float:
    """Return when the grain's chain, after all n contacts were closed, is down to one or none [s].

    The first such time after t0; the source uses it for two to seven particles. The chain may pass
    other lengths on its way down. Between samples of a solver with a step, the force of the contact
    that opens is drawn on to 0.
    """
    full, down_to = False, min(1, run.tower.height - 1)
    after = touch_time(run) + run.tower.contact_time * (1 - 1e-9)
    for i, contacts in enumerate(run.contacts):
        if contacts >= run.tower.height:
            full = True
        elif contacts <= down_to:
            if full and run.time[i] >= after:
                return _force_vanishes(run, i - 1, int(contacts))
            full = False
    raise _too_short(run, "the grain's chain has not swung from all contacts to one")


def first_contact_end(run: TowerRun) -> float:
    """Return when the grain first detaches [s], by its force drawn on to 0 between samples."""
    touching = np.flatnonzero((run.grain_force > 0) & (run.time > 0))
    if touching.size:
        open_ = np.flatnonzero(~(run.grain_force[touching[0] :] > 0))
        if open_.size:
            return _force_vanishes(run, int(touching[0] + open_[0]) - 1)
    raise _too_short(run, "the grain has not detached")


def _first_of_the_highest(value: Floats) -> int:
    """Return the row of the first peak that is as high as the highest, to ``EQUAL_PEAKS``."""
    top = float(np.max(value))
    row = int(np.flatnonzero(value >= top - EQUAL_PEAKS * abs(top))[0])
    while row + 1 < value.size and value[row + 1] > value[row]:
        row += 1
    return row


def _force_vanishes(run: TowerRun, i: int, contact: int = 0) -> float:
    """Return when the force of row ``i`` vanishes, at row ``i + 1`` or before.

    The parabola through three rows, a straight line where there are but two.
    """
    end = float(run.time[i + 1])
    if run.step is None or i == 0:
        return end
    force = run.forces[:, contact]
    slope, bend = _slope(run.time, force, i), 0.0
    if i > 1:
        before = _slope(run.time, force, i - 1)
        bend = (slope - before) / float(run.time[i] - run.time[i - 2])
    since = 0.0
    for _ in range(4):
        steepness = slope + bend * (since + float(run.time[i] - run.time[i - 1]))
        if steepness >= 0:
            return end
        since = -float(force[i]) / steepness
    return min(end, float(run.time[i]) + since)


def _slope(time: Floats, value: Floats, i: int) -> float:
    return float((value[i] - value[i - 1]) / (time[i] - time[i - 1]))


def _falls_through_zero(run: TowerRun, i: int) -> float:
    """Return when the compression rate falls through 0 between rows ``i`` and ``i + 1`` [s]."""
    low, high = float(run.time[i]), float(run.time[i + 1])
    rate, pair = run.compression_rate[i : i + 2], slice(i, i + 2)
    if rate[1] == 0 or high == low:
        return high
    acceleration = grain_acceleration(run)[pair]
    if run.tower.base != "fixed":
        base = run.base_force[pair] / run.tower.each("mass")[-1] + run.tower.gravity
        acceleration = acceleration - base
    cubic = CubicHermiteSpline(run.time[pair], rate, acceleration)
    return float(brentq(lambda t: float(cubic(t)), low, high, xtol=1e-300, rtol=1e-15))


def _too_short(run: TowerRun, why: str) -> RequestError:
    reached = run.time[-1] / run.tower.contact_time
    return RequestError(f"duration = {reached:.6g} t0: too short, {why}")


# ---- numbers of a run


def grain_acceleration(run: TowerRun) -> Floats:
    """Return the acceleration of the grain (M,) [m/s2]."""
    return run.tower.gravity - run.grain_force / run.tower.each("mass")[0]


def grain_velocity_at(run: TowerRun, time: float) -> float:
    """Return the velocity of the grain [m/s] at ``time`` [s], by the cubic between two samples.

    Its error is of fourth order in their distance.
    """
    i = int(np.clip(np.searchsorted(run.time, time, side="right") - 1, 0, run.time.size - 2))
    pair = slice(i, i + 2)
    if run.time[i + 1] == run.time[i]:
        return float(run.grain_velocity[i])
    rates = grain_acceleration(run)[pair]
    return float(CubicHermiteSpline(run.time[pair], run.grain_velocity[pair], rates)(time))


def impulse_until(run: TowerRun, time: float) -> float:
    """Return the integral of the contact force on the grain up to ``time`` [N s].

    Momentum balance, ``J = m (v0 - v) + m g t``: exact, where a quadrature of the samples of the
    force would not be. Raise RequestError beyond the run.
    """
    t0 = run.tower.contact_time
    if not 0 <= time <= run.time[-1] * (1 + 1e-9):
        raise RequestError(
            f"duration = {run.time[-1] / t0:.6g} t0: must be at least {time / t0:.6g} t0, "
            "where the window ends"
        )
    lost = float(run.grain_velocity[0]) - grain_velocity_at(run, time)
    return run.tower.each("mass")[0] * (lost + run.tower.gravity * time)


def impulse(run: TowerRun, window: Window = "turnaround") -> float:
    """Return the impulse on the grain over ``window`` [N s]."""
    return impulse_until(run, window_end(run, window))


def peak_force(run: TowerRun) -> float:
    """Return the largest contact force on the grain [N].

    The top of the parabola through the largest sample and its neighbours; the sample itself where
    they do not lie below a maximum.
    """
    time, force = run.time, run.grain_force
    i = int(np.argmax(force))
    near = slice(i - 1, i + 2)
    if not 0 < i < time.size - 1 or np.any(np.diff(time[near]) == 0):
        return float(force[i])
    bend, slope, _ = np.polyfit(time[near] - time[i], force[near] - force[i], 2)
    return float(force[i] - slope**2 / (4 * bend) if bend < 0 else force[i])


def energy_drift(run: TowerRun) -> float:
    """Return the largest change of the total energy over its largest value without weight [-]."""
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
    return [*zip(run.time_over_t0[rows].tolist(), contacts[rows].tolist(), strict=True)]


def grain_alone(run: TowerRun) -> list[tuple[float, float]]:
    """Return (from, to) [t0] of every stretch in which nothing presses on the grain."""
    changes = [*contact_changes(run), (float(run.time_over_t0[-1]), -1)]
    pairs = itertools.pairwise(changes)
    return [(start, end) for (start, contacts), (end, _) in pairs if contacts == 0]


def summary(
    run: TowerRun, window: Window = "turnaround", covering: TowerRun | None = None
) -> dict[str, Any]:
    """Return the JSON-ready numbers of a run.

    ``covering`` is a run of the same case that covers the window, where ``run`` does not.
    ``turnaround_s`` is when grain and base are closest; ``window_s`` is when the window ends.
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
        **(asdict(run.provenance) if run.provenance else {}),
    }
