"""Run towers by solvers of this package or in an engine; their records for the baseline."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypedDict, Unpack

import numpy as np
import pandas as pd

from harness import __version__
from harness.cases.grain import run_jobs, run_or_raise
from harness.cases.tower.comparison import SeriesComparison, contact_events
from harness.cases.tower.system import Timing, check_duration, job_of, timing_of
from harness.cases.verification import Progress, silent
from harness.comparison.regression import BaselineRecord, made_by
from harness.comparison.series import Comparison, Series
from harness.engines.contract import Engine, Output
from harness.engines.output import SERIES
from harness.engines.registry import engine_names
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.reference import FEWEST, contradiction
from harness.observables.row import Row, by_name
from harness.observables.tower import (
    SEARCH,
    Floats,
    Profiles,
    TowerRun,
    Window,
    impulse,
    peak_force,
    touch_time,
    window_end,
)
from harness.parameters.tower import Property, Tower
from harness.store.cache import EngineChoice, opened

ROUNDINGS = 4
"""A contact pressed in by fewer roundings of a position cannot be told from an open one."""

PROPERTIES: dict[Property, str] = {"mass": "kg", "stiffness": "N_per_m", "diameter": "m"}
"""Of the particles, with the units that results name."""

MOTION = ("x_m", "vx_m_per_s")
TOTAL_FORCE, CONTACTS_ON_PARTICLE, CONTACT_FORCE = "fx_N", "contacts_fx_N", "contact_force_N"
"""The force columns of which a table has one: on each particle with its weight, on each particle
by its contacts alone, of each contact."""

FORCES = (CONTACT_FORCE, TOTAL_FORCE, CONTACTS_ON_PARTICLE)

LATE = 0.75
"""Steps that a sample may be off its time, and that velocities and forces of codes other than
velocity Verlet may be from the positions: some are half a step early."""

COARSE = 0.5
"""[rad] of the fastest mode that a sampling interval may hold for samples to be held against each
other: its chord is then 1 % off."""

ROUNDINGS_OF_A_SAMPLE = 16
"""Roundings of a position or velocity that adding up a sample's terms may leave."""


def run_towers(
    engine: Engine,
    cases: Sequence[Tower],
    duration: float,
    *,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
) -> list[TowerRun | EngineError]:
    """Run towers for ``duration`` [t0] and return their results in order.

    Steps count in pi sqrt(m/k), samples default to about 1000 per t0.
    Raise RequestError for a case that the engine cannot state.
    """

    def timing(case: Tower) -> Timing:
        return timing_of(case, duration, steps_per_contact, samples)

    return run_jobs(
        engine,
        cases,
        lambda case: job_of(case, timing(case)),
        lambda case, output: read(case, timing(case), output, engine.traits, profiles),
    )


def read(
    case: Tower, timing: Timing, output: Output, traits: Traits, profiles: bool = False
) -> TowerRun:
    """Return the run in a table of positions, velocities and forces.

    Raise EngineOutputError for what is missing or cut, for samples at other times than were asked
    for, and for a tower in which nothing ever touches; EngineNaNError for values that are not
    finite.
    """
    output.check_numbers(
        {
            **{f"{name}_{unit}": case.each(name)[0] for name, unit in PROPERTIES.items()},
            "speed_m_per_s": case.speed,
            "gravity_m_per_s2": case.gravity,
            "contact_time_s": case.contact_time,
            "step_s": timing.step,
            "steps": timing.steps,
        }
    )
    rows, count = timing.steps // timing.every + 1, case.particles
    written = output.tables.get(SERIES, {})
    clock = "step" if "step" in written else "time_s"
    forces = next((name for name in FORCES if name in written), TOTAL_FORCE)
    table = output.table((clock, *MOTION, forces), rows)
    x, v, f = (np.asarray(table[name]) for name in (*MOTION, forces))
    for name, values, width in zip(
        (*MOTION, forces), (x, v, f), (count, count, count - (forces == CONTACT_FORCE)), strict=True
    ):
        if values.shape != (rows, width):
            raise EngineOutputError(f"{output.who} left {name} of {values.shape[-1]}, not {width}")
    time = np.asarray(table[clock] * timing.step if clock == "step" else table[clock])
    _check_times(time, timing, clock, output.who)
    acceleration = _accelerations(case, forces, f)
    smallest = _rounding(case, x)
    least = smallest / case.each("mass")[0]
    _same_motion(case, timing, (x, v, acceleration), least, traits, output.who)
    if forces == CONTACT_FORCE:
        force = np.where(f > smallest, f, 0.0)
    else:
        weight = case.each("mass")[0] * case.gravity if forces == TOTAL_FORCE else 0.0
        force = _forces_of_contacts(f, weight, smallest)
    if not (force > 0.0).any():
        raise EngineOutputError(f"{output.who}: no contact of the tower ever presses")
    speed = float(v[-1, 0])
    push = case.each("mass")[0] * (case.speed - speed + case.gravity * timing.steps * timing.step)
    totals = {"final_velocity_m_per_s": speed, "impulse_Ns": push}
    output.check_numbers(totals, "is what its series says")
    displacement = x - case.each("diameter")[0] * np.arange(count)
    return _tower_run(
        case, timing.step, time, displacement, v, force, output.provenance, profiles=profiles
    )


def _check_times(time: Floats, timing: Timing, clock: str, engine_name: str) -> None:
    """Raise EngineOutputError for samples (M,) [s] at other times than were asked for."""
    expected = timing.step * timing.every * np.arange(time.size)
    off = np.abs(time - expected)
    # steps are counted: what is left of them is the rounding of a product
    if off.max() > (LATE if clock == "time_s" else 1e-6) * timing.step:
        row = int(off.argmax())
        raise EngineOutputError(
            f"{engine_name} wrote samples at other times than were asked for: row {row + 1} "
            f"at {time[row]:.9g} s, not {expected[row]:.9g} s"
        )


def _accelerations(case: Tower, forces: str, f: Floats) -> Floats:
    """Return the accelerations (M, N) [m/s2] by the forces of a table, 0 of a fixed base."""
    mass, gravity = case.each("mass")[0], case.gravity
    if forces == CONTACT_FORCE:
        closed = np.pad(f, ((0, 0), (1, 1)))
        f = closed[:, :-1] - closed[:, 1:]
    acceleration = f / mass + (0.0 if forces == TOTAL_FORCE else gravity)
    if case.base == "fixed":
        acceleration[:, -1] = 0.0
    return np.asarray(acceleration)


def _same_motion(
    case: Tower,
    timing: Timing,
    motion: tuple[Floats, Floats, Floats],
    least: float,
    traits: Traits,
    engine_name: str,
) -> None:
    """Raise EngineOutputError for positions, velocities or forces that contradict each other.

    ``motion`` are positions [m], velocities [m/s] and accelerations [m/s2], each (M, N); ``least``
    [m/s2] is the least acceleration above rounding. Samples too coarse to follow the fastest mode
    of the chain show only that a particle moves by the mean of its velocities, to within their
    change in an interval.
    """
    interval = timing.step * timing.every
    x, v, a = motion
    # omega is pi over the contact period; the deformable law's fastest mode grows with the chain
    fastest = 2.0 * math.pi / case.contact_period
    if case.law == "deformable":
        fastest /= math.sqrt(2.0) * math.sin(math.pi / (2 * (case.height + 1)))
    if len(x) < FEWEST or fastest * interval > COARSE:
        moved = np.abs(np.diff(x, axis=0) - 0.5 * interval * (v[1:] + v[:-1]))
        room = interval * np.abs(np.diff(v, axis=0)).max(initial=0.0)
        if moved.max(initial=0.0) > room + 10.0 ** (1 - traits.digits) * np.abs(x).max():
            raise EngineOutputError(
                f"{engine_name} wrote positions and velocities that contradict each other"
            )
        return
    late = 0.0 if traits.integrator == "velocity-verlet" else LATE * timing.step
    digit = max(10.0 ** (1 - traits.digits), ROUNDINGS_OF_A_SAMPLE * float(np.finfo(float).eps))
    scales = [float(np.abs(column).max(initial=0.0)) for column in motion]
    of_positions = digit * (scales[0] + interval * scales[1])
    of_velocities = digit * (scales[1] + interval * scales[2]) + interval * least
    for of, values, rates, rounding in (
        ("positions and velocities", x, v, of_positions),
        ("velocities and forces", v, a, of_velocities),
    ):
        place = contradiction(values, rates, interval, rounding, late)
        if place is not None:
            row, particle = place
            raise EngineOutputError(
                f"{engine_name} wrote {of} that contradict each other: particle {particle + 1} at "
                f"{row * interval:.6g} s"
            )


def _rounding(case: Tower, x: Floats) -> float:
    """Return the least force [N] above rounding."""
    pressed = case.each("stiffness")[0] * float(np.abs(x).max())
    return ROUNDINGS * float(np.finfo(float).eps) * pressed


def _tower_run(
    case: Tower,
    step: float,
    time: Floats,
    displacement: Floats,
    velocity: Floats,
    force: Floats,
    provenance: Provenance,
    *,
    profiles: bool = False,
) -> TowerRun:
    """Return the run of a tower of equal particles, M samples of N particles, grain first.

    ``time`` (M,); ``displacement`` (M, N) from where all just touch, along the motion; ``velocity``
    (M, N); ``force`` (M, N - 1) of each contact, the engine's own, 0 where it is open.
    """
    mass, gravity = case.each("mass")[0], case.gravity
    overlap = displacement[:, :-1] - displacement[:, 1:]
    weight = np.full(case.particles, gravity)
    if case.base == "fixed":
        weight[-1] = 0.0
    return TowerRun(
        tower=case,
        solver=provenance.engine,
        step=step,
        time=time,
        grain_displacement=displacement[:, 0],
        grain_velocity=velocity[:, 0],
        grain_force=force[:, 0],
        # of the grain's chain: how many from the grain on press
        contacts=np.cumprod(force > 0.0, axis=1).sum(axis=1).astype(np.float64),
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
        provenance=provenance,
    )


def _forces_of_contacts(force: Floats, weight: float, smallest: float) -> Floats:
    """Return the contact forces (M, n) from the forces on the particles (M, N), grain first.

    The engine's own forces, whatever law made them: particle i feels its weight
    [N], is pushed on by contact i - 1 and held by contact i. What is below
    ``smallest`` [N] is rounding.
    """
    contact = np.cumsum(weight - force[:, :-1], axis=1)
    contact[np.abs(contact) <= smallest] = 0.0
    return np.asarray(contact)


DURATION = SEARCH  # [t0] the source's longest look
DEFAULT_SOLVER = "rk4"
MARGIN = 1.001  # the longer run has another step, and finds the end of its window a little off


class Options(TypedDict, total=False):
    """How a tower is run: keywords of :func:`tower`."""

    solver: str | None
    duration: float
    steps_per_contact: float | None
    samples: int | None
    profiles: bool
    engine: EngineChoice
    fresh: bool
    progress: Progress


Told = Callable[[int, int], None]
"""Called with what is done and all of it."""

Solver = Callable[[Tower, float, float | None, int | None, bool, Told], TowerRun]


def tower(case: Tower, **options: Unpack[Options]) -> TowerRun:
    """Run ``case`` for ``duration`` [t0] with a solver of :data:`SOLVERS`, or in an engine.

    ``engine`` runs it where it is given, open or by its name, as does the name of an engine for
    ``solver``; else RK4 does. An engine of a name is opened, its runs are kept, and ``fresh`` runs
    again what was kept. ``steps_per_contact`` counts steps in pi sqrt(m/k), for solvers
    with a step. ``samples`` is how many to keep, about 1000 per t0 if not given; with
    ``profiles`` all particles are kept, not only the grain. ``progress`` is called as solvers of
    this package go on. Raise RequestError for what cannot be, a solver that is not the given
    engine among it, and EngineError for a run that failed.
    """
    (run,) = towers([case], **options)
    return run


def towers(  # noqa: PLR0913 - keywords of a public function
    cases: Sequence[Tower],
    *,
    solver: str | None = None,
    duration: float = DURATION,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = silent,
) -> Iterator[TowerRun]:
    """Yield the runs of ``cases``, as :func:`tower` makes one: in an engine they are one batch."""
    name = chosen_solver(solver, engine)
    check_duration(duration)
    if name in SOLVERS:
        for case in cases:
            seconds = duration * case.contact_time
            report = partial(progress, f"tower of height {case.height}, {case.law} law")
            yield SOLVERS[name](case, seconds, steps_per_contact, samples, profiles, report)
        return
    with opened(engine or name, fresh=fresh) as running:
        runs = run_towers(
            running,
            cases,
            duration,
            steps_per_contact=steps_per_contact,
            samples=samples,
            profiles=profiles,
        )
    yield from map(run_or_raise, runs)


def chosen_solver(solver: str | None, engine: EngineChoice) -> str:
    """Return the name of the solver or engine that runs a tower.

    Raise RequestError for one that is not known, and for a solver beside an engine of another
    name: neither may replace the other in silence.
    """
    if engine is not None:
        name = engine if isinstance(engine, str) else engine.name
        if solver not in (None, name):
            raise RequestError(
                f"solver = {solver!r}: contradicts the engine that is given, {name!r}"
            )
        return name
    if solver is None or solver in SOLVERS:
        return solver or DEFAULT_SOLVER
    if solver not in engine_names():
        allowed = ", ".join((*SOLVERS, *engine_names()))
        raise RequestError(f"solver = {solver!r}: must be one of {allowed}")
    return solver


def covering(
    run: TowerRun, window: Window, engine: Engine | None = None, progress: Progress = silent
) -> TowerRun:
    """Return ``run``, or one of the same case and solver that covers ``window``.

    Closest approach and impulse need 3 t0, and more where the window ends
    later. ``engine`` is the one that made the run, if one did. Raise RequestError if the tower
    does not show that window.
    """
    t0, long = run.tower.contact_time, run
    if long.time[-1] < (touch_time(run) + SEARCH * t0) * (1 - 1e-9):
        long = _longer(run, touch_time(run) / t0 + SEARCH, engine, progress)
    end = max(window_end(long, name) for name in {window, "turnaround"})
    return long if end <= long.time[-1] else _longer(run, end / t0 * MARGIN, engine, progress)


def _longer(run: TowerRun, duration: float, engine: Engine | None, progress: Progress) -> TowerRun:
    """Run the same again for ``duration`` [t0]."""
    return tower(
        run.tower,
        solver=None if engine is not None else run.solver,
        duration=duration,
        steps_per_contact=None if run.step is None else run.tower.contact_period / run.step,
        profiles=run.profiles is not None,
        engine=engine,
        progress=progress,
    )


def _rk4(
    case: Tower, seconds: float, steps: float | None, samples: int | None, profiles: bool,
    progress: Told,
) -> TowerRun:  # fmt: skip
    from harness.solvers.chain import rk4

    return rk4.run(
        case,
        seconds,
        steps_per_contact=steps,
        samples=samples,
        profiles=profiles,
        progress=progress,
    )


def _exact(
    case: Tower, seconds: float, steps: float | None, samples: int | None, profiles: bool,
    progress: Told,
) -> TowerRun:  # fmt: skip
    from harness.solvers.chain import exact

    if steps is not None:
        raise RequestError(f"steps_per_contact = {steps}: the exact solver has no step")
    return exact.run(case, seconds, samples=samples, profiles=profiles, progress=progress)


SOLVERS: dict[str, Solver] = {"rk4": _rk4, "exact": _exact}
"""The harness's own solvers; engines go by the names of the registry."""


NAME = "tower"
"""Name of the case."""

LEAST_FORCE = 1e-6
"""Contacts that press with less, over the peak, are not counted: rounding decides on them."""

WITH_SERIES = (2, 19)
"""Heights whose force is kept over time: three particles, and the source's tallest."""

RATIO = Tower(stiffness=1e6, speed=2.0)
"""The run of the source whose impulse ratios are kept."""


def record_name(case: Tower, solver: str, content: str = NAME) -> str:
    """Return the name of a record of a tower run, or of other ``content`` at its parameters."""
    return f"{solver}/{content}-{case.law}-n{case.height}-k{_short(case)}-v{case.speed:g}"


def label(case: Tower) -> str:
    """Return the label of a tower among those of its solver."""
    return f"{case.law} law, n = {case.height}, k = {_short(case)} N/m, {case.speed:g} m/s"


def _short(case: Tower) -> str:
    """Return the stiffness of the grain [N/m], as in 1e6 or 3.16e5."""
    return f"{case.each('stiffness')[0]:.3g}".replace("e+0", "e").replace("e+", "e")


def tower_record(run: TowerRun) -> BaselineRecord:
    """Return the record of a run with profiles: peak force, impulse, changes of contacts, series.

    The impulse is NaN where the run shows no window.
    """
    try:
        value = impulse(run)
    except RequestError:
        value = math.nan
    series = {"grain_force_N": run.grain_force, "grain_velocity_m_per_s": run.grain_velocity}
    least = LEAST_FORCE * peak_force(run)
    events = contact_events(run, least)
    quantities = by_name(
        Row("peak_force_N", peak_force(run), 0.0, "N"),
        Row("impulse_Ns", value, 0.0, "N s"),
        Row("contact_changes", float(len(events)), 0.0, ""),
    )
    if events:
        quantities["last_change_s"] = Row("last_change_s", events[-1].time, 0.0, "s")
    return BaselineRecord(
        name=record_name(run.tower, run.solver),
        parameters={
            **run.tower.model_dump(mode="json"),
            "duration_t0": round(float(run.time_over_t0[-1]), 9),
            "step_s": run.step,
        },
        quantities=quantities,
        case=NAME,
        label=label(run.tower),
        family=(run.tower.law,),
        series=Series(run.time, series) if run.tower.height in WITH_SERIES else None,
        **made_by(run.provenance, run.solver, __version__),
    )


def ratio_records(
    frame: pd.DataFrame, provenance: Provenance | None, heights: Sequence[int]
) -> list[BaselineRecord]:  # fmt: skip
    """Return the records of the impulse ratios of a table, at the run of the source that is kept.

    ``provenance`` is the engine that made the table, None for the exact propagator.
    """
    solver, records = provenance.engine if provenance else "exact", []
    for row in of_ratio(frame).to_dict(orient="records"):
        case = RATIO.replace(height=int(row["height"]), law=row["law"])
        if case.height not in heights:
            continue
        records.append(
            BaselineRecord(
                name=record_name(case, solver, "impulse-ratio"),
                parameters={**case.model_dump(mode="json"), "window": "turnaround"},
                quantities=by_name(Row("impulse_ratio", float(row["impulse_ratio"]), 0.0, "")),
                case=NAME,
                label=f"impulse ratio, {label(case)}",
                family=(case.law,),
                **made_by(provenance, solver, __version__),
            )
        )
    return records


def of_ratio(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of a table of impulse ratios that are at the run of :data:`RATIO`."""
    stiffness, speed = frame["stiffness_N_per_m"], frame["speed_m_per_s"]
    return frame[(stiffness == RATIO.stiffness) & (speed == RATIO.speed)]


def force_comparison(name: str, compared: SeriesComparison, band: float) -> Comparison:
    """Return the force of two runs, over the reference's peak, as a series with its band."""
    wanted = np.interp(compared.time, compared.reference.time, compared.reference.grain_force)
    reference = wanted / compared.force.scale
    return Comparison(
        case=name,
        column="grain_force_over_peak",
        time=compared.time,
        value=reference + compared.force_difference,
        reference=reference,
        band=band,
        run_label=compared.run.solver,
        reference_label=compared.reference.solver,
    )
