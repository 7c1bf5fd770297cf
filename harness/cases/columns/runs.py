"""Runs of a grain over columns: judged, at equal steps, and the critical angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from harness import __version__
from harness.cases.bench import OWN, Bench
from harness.cases.columns.system import (
    Columns,
    crest_energy,
    crest_place,
    job_of,
    scene_of,
    sinking,
)
from harness.cases.incline.case import Search
from harness.cases.incline.runs import Fate, Run, read
from harness.cases.incline.search import CriticalAngle, Measure, prepared, search
from harness.cases.incline.system import Incline, Route, wells_of
from harness.cases.plane import COLUMNS as PATH
from harness.engines.base import Output
from harness.engines.jobs import cores, parallel_map
from harness.engines.provenance import Provenance
from harness.engines.scene_tables import STAGES
from harness.errors import EngineError, EngineOutputError, Unsupported
from harness.model.motion import STAGE_COLUMNS

CHAIN = Provenance("harness", __version__, how="compiled")


def read_run(case: Columns, route: Route, output: Output) -> Run:
    """Return the run in an output: judged by LAMMPS's script, else by the ends of its stages."""
    plain = case.incline
    if output.results:
        return read(plain, route, output)
    table = output.table(("step", *PATH), name=STAGES)
    x, y, vx, vy = (table[name][1:] for name in PATH[1:])
    if not x.size:
        raise EngineOutputError(f"{output.who} left no end of a stage")
    number = np.arange(1, x.size + 1)
    height = y * math.cos(case.tilt) - x * math.sin(case.tilt)
    energy = 0.5 * plain.mass * (vx * vx + vy * vy) + case.weight * height - crest_energy(case)
    margins = energy / plain.weight_energy + number * math.sin(case.tilt)
    beyond = x > np.array([crest_place(case, int(well)) for well in number])
    fate = Fate.MOVES_ON if beyond.all() and x.size == wells_of(plain, route) else Fate.TRAPPED
    if not beyond[-1] and not vx[-1] < 0.0:
        fate = Fate.UNDECIDED
    if route == "passage" and fate is Fate.MOVES_ON and margins[-1] < 0.0:
        fate = Fate.TRAPPED
    passed = int(np.count_nonzero(beyond))
    # of a top that rests without a grain: a grain in contact presses it further down
    distance = math.hypot(x[-1] - x.size * case.diameter, y[-1] + float(sinking(case)[0]))
    return Run(
        plain, fate, float(margins[-1]), distance < case.diameter, float(table["time_s"][-1]),
        int(table["step"][-1]), table["time_s"][1 : passed + 1], margins[:passed], output,
    )  # fmt: skip


def measure_in(bench: Bench, case: Columns, route: Route) -> Measure:
    """Return a function that runs inclines as columns, in an engine or in the reference.

    Raise Unsupported for a run that the engine refuses, the first EngineError of a run.
    """

    def measure(cases: Sequence[Incline]) -> list[Run]:
        varied = ("angle", "phase", "wells", "time_limit")
        own = [case.replace(**{name: getattr(plain, name) for name in varied}) for plain in cases]
        if bench.name == OWN:
            return parallel_map(partial(run_at_equal_steps, bench, route=route), own, cores())
        jobs = [job_of(one, route) for one in own]
        if reason := next(filter(None, map(bench.refusal, jobs)), ""):
            raise Unsupported(reason)
        runs = []
        for one, outcome in zip(own, bench.outcomes(jobs), strict=True):
            if isinstance(outcome, EngineError):
                raise outcome
            runs.append(read_run(one, route, outcome))
        return runs

    return measure


def run_at_equal_steps(bench: Bench, case: Columns, route: Route = "passage") -> Run:
    """Return a run at equal steps: by the reference, under the deformable law by the chain's."""
    scene = scene_of(case, route)
    if not case.deformable:
        return read_run(case, route, bench.reference_output(scene))
    from harness.solvers.chain import columns

    stages = dict(zip(STAGE_COLUMNS, columns.run(scene, case.n).T, strict=True))
    return read_run(case, route, Output((), CHAIN, {STAGES: stages}, title="the chain solver"))


def critical_angle(case: Columns, bench: Bench, **options: Any) -> CriticalAngle:
    """Return the critical angle [deg] of a case; ``options`` are those of the incline's search."""
    wanted = Search(**options)
    measure = measure_in(bench, case, wanted.method)
    plain = prepared(case.incline, wanted.method)
    return search(measure, plain, wanted.method, wanted.tolerance, wanted.starts)
