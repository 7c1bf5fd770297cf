"""What the study of layers costs: of a grain and a step, as measured, and of a level on a cluster.

The model. A run costs steps times grains times the cost of a grain and step in a run of that size
on one rank. On r ranks it takes the part s + (1 - s)/r of that (Amdahl), with s from the measured
efficiency of two ranks, e = 1/(1 + s). Runs are independent: cores take the longest one that is
left, r cores to a run, r being the power of two that ends first. It knows no network, no queue and
no memory that cores share: of more ranks than two it is an extrapolation.
"""

from __future__ import annotations

import heapq
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from itertools import chain
from typing import NamedTuple

import numpy as np

from harness.cases.case_study import Arm, Row, StudyCost
from harness.cases.layers.parameters import Layers
from harness.cases.layers.study import grains_in
from harness.cases.layers.template import job_of
from harness.engines.contract import Engine
from harness.engines.output import Output
from harness.errors import EngineError, EngineOutputError

CORES = (1, 16, 256)
SIZES = (16, 50)
"""[d] sides of the boxes that are measured: 1,024 and 10,000 grains, which the runs lie between."""

LAYERS = 4
REPEATS = 3
"""The fastest counts: whatever else the machine does only slows a run down."""

LOWERING = {1: 18.5, 2: 29.3, 4: 50.7, 8: 54.3}
"""[sqrt(d/g) for each d of length] from the first angle to the stop at RATE, by layers: means over
the runs of reports/layers; a longer box is longer in coming to rest. Other thicknesses lie between,
or are the last."""

RATE = 0.1
"""[deg for each d] at which that was measured; the time goes as its inverse."""

LEAST_SPEED = 0.01
"""[sqrt(g d)] of a flow that is not at rest: no descent takes longer than its angles at it."""

RISE_DEG = 2.5
"""[deg] from the stop to the start: what raised runs of 1 to 8 layers took."""

LOOP = re.compile(r"^Loop time of (\S+) on (\d+) procs for (\d+) steps with \d+ atoms", re.M)

MODEL = (
    "steps x grains x cost of a grain and step in a run of its size; of it s + (1 - s)/r on r "
    "ranks, s from the efficiency of two, 1/(1 + s); independent runs, the longest first, r cores "
    "to a run. Without network, queue and shared memory; more than two ranks are extrapolated."
)


class Speed(NamedTuple):
    """What a grain and step cost [s] in a run of so many grains on so many ranks."""

    grains: int
    ranks: int
    seconds: float


def probe(side: int) -> Layers:
    """Return a short run: grains fall on the base and flow, and nothing is lowered."""
    return Layers(
        layers=LAYERS, length=side, width=side, stiffness_over_weight=100.0, first_angle=20.0,
        lowest_angle=19.99, flow_time=1.01, rate=10.0,
    )  # fmt: skip


def speed_of(engine: Engine, side: int, repeats: int = REPEATS) -> Speed:
    """Return the cost of a grain and step in an engine, the least of some repeats.

    Raise the first EngineError, EngineOutputError where the log tells of no time.
    """
    case, found = probe(side), []
    for _ in range(repeats):
        (output,) = engine.run([job_of(case)])
        if isinstance(output, EngineError):
            raise output
        found.append(loop_speed(output, case.grains))
    return min(found, key=lambda one: one.seconds)


def loop_speed(output: Output, grains: int) -> Speed:
    """Return what the longest stretch of a run's log cost a grain and step."""
    loops = LOOP.findall(output.log)
    if not loops:
        raise EngineOutputError(f"{output.who} left no line 'Loop time of' in its log")
    time, ranks, steps = max(loops, key=lambda loop: int(loop[2]))
    return Speed(grains, int(ranks), float(time) / int(steps) / grains)


def efficiency(one: Speed, two: Speed) -> float:
    """Return the efficiency of two ranks, from the cost on one and on two."""
    return one.seconds / (2.0 * two.seconds)


def serial_part(efficiency_of_two: float) -> float:
    """Return s of e = 1/(1 + s), from 0 to 1."""
    return min(max(1.0 / efficiency_of_two - 1.0, 0.0), 1.0)


def steps_of(case: Layers) -> float:
    """Return the steps that a run is expected to take."""
    slowness = float(np.interp(case.layers, [*LOWERING], [*LOWERING.values()]))
    longest = (case.first_angle - case.lowest_angle) / case.rate / LEAST_SPEED
    lowering = min(slowness * case.length * RATE / case.rate, longest, case.time_limit)
    raising = 0.0 if case.rise == 0.0 else RISE_DEG / case.rise
    return (20.0 + case.flow_time + lowering + raising) / case.step


def wall_seconds(durations: Sequence[float], cores: int, share: float, ranks: int) -> float:
    """Return when the last of independent runs ends, each on so many ranks of one machine."""
    part = share + (1.0 - share) / ranks
    free = [0.0] * max(1, min(cores // ranks, len(durations)))
    for duration in sorted(durations, reverse=True):
        heapq.heapreplace(free, free[0] + duration * part)
    return max(free)


def best_ranks(durations: Sequence[float], cores: int, share: float) -> tuple[int, float]:
    """Return the ranks of a run, a power of two, by which all ends first, and when [s]."""
    powers = (2**i for i in range(cores.bit_length()))
    found = [(wall_seconds(durations, cores, share, r), r) for r in powers if r <= cores]
    wall, ranks = min(found)
    return ranks, wall


def durations_of(arms: Iterable[Arm], speeds: Sequence[Speed]) -> list[float]:
    """Return what each different run of some arms is expected to take on one rank [s]."""
    runs = dict.fromkeys(
        (one, arm.ranks) for arm in arms for one in arm.parameters if isinstance(one, Layers)
    )
    sizes = np.log([s.grains for s in speeds])
    costs = [s.seconds for s in speeds]
    return [
        steps_of(one) * one.grains * float(np.interp(np.log(one.grains), sizes, costs))
        for one, _ in runs
    ]


def study_cost(
    arms: Sequence[Arm], engine_of: Callable[[int], AbstractContextManager[Engine]]
) -> StudyCost:
    """Measure an engine on one rank and on two, and return what the runs of some arms cost."""
    speeds: dict[int, list[Speed]] = {}
    for ranks in (1, 2):
        with engine_of(ranks) as engine:
            speeds[ranks] = [speed_of(engine, side) for side in SIZES]
        if speeds[ranks][0].ranks != ranks:
            raise EngineOutputError(
                f"{engine.title}: of {ranks} ranks that were asked for it took "
                f"{speeds[ranks][0].ranks}: is the launcher (--mpirun) of the MPI it is built with?"
            )
    return _cost(arms, speeds[1], speeds[2])


def core_seconds(found: Mapping[str, Sequence[Row]]) -> tuple[int, float]:
    """Return how many different runs tell of their time, and the core time [s] of them all."""
    runs = {
        repr([row[name] for name in row if name != "arm"]): row["wall_time_s"] * row["ranks"]
        for row in chain.from_iterable(found.values())
        if row.get("wall_time_s") and row.get("steps")
    }
    return len(runs), sum(runs.values())


def cost_seen(arms: Sequence[Arm], found: Mapping[str, Sequence[Row]]) -> StudyCost | None:
    """Return what some arms cost by the wall times of runs that were made; None without any.

    Of runs of one size on one rank the least counts: whatever else the machine did only slowed them
    down. Nothing is split over ranks: runs that were, on a machine that did more, tell nothing of
    what two ranks gain.
    """
    least: dict[int, Speed] = {}
    for row in chain.from_iterable(found.values()):
        if row.get("wall_time_s") and row.get("steps") and row["ranks"] == 1:
            grains = grains_in(row)
            one = Speed(grains, 1, row["wall_time_s"] / row["steps"] / grains)
            least[grains] = min(one, least.get(grains, one), key=lambda speed: speed.seconds)
    return _cost(arms, [least[grains] for grains in sorted(least)], ()) if least else None


def _cost(arms: Sequence[Arm], ones: Sequence[Speed], twos: Sequence[Speed]) -> StudyCost:
    """Return what arms cost by speeds on one rank and on two, those of rising sizes."""
    split = {two.grains: two for two in twos}
    together = [efficiency(one, split[one.grains]) for one in ones if one.grains in split]
    measured = [
        {
            "grains": one.grains,
            "microseconds_per_grain_and_step": 1e6 * one.seconds,
            "efficiency_of_2_ranks": efficiency(one, split[one.grains])
            if one.grains in split
            else None,
        }
        for one in ones
    ]
    durations = durations_of(arms, ones)
    return StudyCost(tuple(measured), tuple(_rows(durations, [0.5, *together][-1])), MODEL)


def _rows(durations: Sequence[float], together: float) -> Iterable[Mapping[str, float]]:
    share, total = serial_part(together), sum(durations)
    for cores in CORES:
        ranks, wall = best_ranks(durations, cores, share)
        yield {
            "cores": cores,
            "ranks_per_run": ranks,
            "runs": len(durations),
            "longest_run_h": max(durations) / 3600.0,
            "wall_time_h": wall / 3600.0,
            "core_hours": wall * cores / 3600.0,
            "efficiency": total / (wall * cores),
        }
