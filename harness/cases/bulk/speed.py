"""What a particle and step cost a code in the bulk cases, on one core and on two.

    python -m harness.cases.bulk.speed FOLDER lammps liggghts yade kratos

writes ``speed.csv`` and ``speed.svg``. Runs are made one after the other, each code with the same
law, step and dense start. A run of few steps, in which grains come to lie on one another, is
subtracted from one of many, so that no start of a program counts. On one core processor time is
taken, user and system; on two ranks of MPI, or threads of codes without, wall time is held against
that on one. Wall time is no measure where other processes take a part of the cores: each row says
how many they took meanwhile.
"""

from __future__ import annotations

import contextlib
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.cases.registry import get_case
from harness.engines.contract import Engine, Job
from harness.engines.registry import engine_class
from harness.errors import EngineError, EngineMissingError
from harness.report.plain import write_csv
from harness.shown.figure import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = ("penetration", "silo", "drum")
FEW = 1500
"""Steps before the release, the opening, the turning of the short run."""

MORE = 10000
"""Steps by which the long run is longer: seconds of the fastest code."""

DENSE = {
    "penetration": {"spacing": 1.002, "scatter": 0.002},
    "silo": {"spacing": 1.02, "scatter": 0.02},
    "drum": {"spacing": 1.02, "scatter": 0.02},
}
"""Lattices whose grains have met in the few steps."""

BUSY = 0.1
"""Cores that other processes take, above which a wall time is no measure."""


@dataclass(frozen=True)
class Clock:
    """Times [s]: processor time of ended processes, wall time, of all cores at work."""

    processor: Callable[[], float]
    wall: Callable[[], float]
    machine: Callable[[], float]


def processor_seconds() -> float:
    """Return the processor time of all processes that were started and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def machine_seconds() -> float:
    """Return the processor time of all processes of this machine [s]; 0 where it is not told."""
    try:
        words = Path("/proc/stat").read_text(encoding="ascii").split(maxsplit=9)
    except OSError:
        return 0.0
    user, nice, system, _, _, interrupts, soft = map(float, words[1:8])
    ticks: int = os.sysconf("SC_CLK_TCK")
    return (user + nice + system + interrupts + soft) / ticks


CLOCK = Clock(processor_seconds, time.monotonic, machine_seconds)


@dataclass(frozen=True)
class Row:
    """The cost of a code in a case, of a particle and step [us]; ``ranks`` of MPI or threads.

    ``coordination`` is that at the end of the long run, NaN of the drum. ``others_cores`` is how
    many cores other processes took meanwhile.
    """

    case: str
    code: str
    ranks: int
    grains: int
    coordination: float
    step_s: float
    microseconds_per_particle_step: float
    wall_microseconds_per_particle_step: float
    others_cores: float

    @property
    def busy(self) -> bool:
        """Return whether its wall time is no measure."""
        return self.others_cores > BUSY


def measure(
    case_name: str,
    engine: Callable[[], AbstractContextManager[Engine]],
    ranks: int = 1,
    clock: Clock = CLOCK,
) -> Row:
    """Measure a code in a case; raise EngineError for a run that fails."""
    case = get_case(case_name)
    p: Any = case.default.replace(**DENSE[case_name])
    values = {**case.job(p).values, "steps": 50, "series_every": 50}
    processor, wall = [], []
    began, others, coordination, title = clock.wall(), -clock.machine(), float("nan"), ""
    before = clock.processor()
    for long in (False, True):
        since = clock.processor(), clock.wall()
        with engine() as opened:
            title = opened.title
            steps = FEW + (MORE if long else 0)
            (output,) = opened.run(
                [Job(case.template, {**values, "settle_steps": steps}, "", True)]
            )
        if isinstance(output, EngineError):
            raise output
        if output.has("coordination"):
            coordination = output.number("coordination")
        processor.append(clock.processor() - since[0])
        wall.append(clock.wall() - since[1])
    others += clock.machine() - (clock.processor() - before)
    return Row(
        case_name,
        title,
        ranks,
        p.grains,
        coordination,
        p.step_size,
        1e6 * (processor[1] - processor[0]) / (p.grains * MORE),
        1e6 * (wall[1] - wall[0]) / (p.grains * MORE),
        max(0.0, others / (clock.wall() - began)),
    )


@contextlib.contextmanager
def on_two(kind: Callable[[], Engine]) -> Iterator[Engine]:
    """Yield a code on two ranks or threads; raise EngineMissingError where it has neither."""
    with kind() as opened, opened.on_ranks(2) as engine:
        yield engine


def table(names: Sequence[str]) -> list[Row]:
    """Return two rows for each case and engine, by name; one where it runs on one core alone."""
    rows = []
    for case in CASES:
        for name in names:
            kind: Any = engine_class(name)
            rows.append(measure(case, kind))
            print(*astuple(rows[-1]), flush=True)
            try:
                rows.append(measure(case, lambda kind=kind: on_two(kind), ranks=2))  # type: ignore[misc]
            except EngineMissingError as error:
                print(f"{name} on two: {error}", flush=True)
            else:
                print(*astuple(rows[-1]), flush=True)
    return rows


def speedups(rows: Sequence[Row]) -> dict[tuple[str, str], float]:
    """Return the wall time on one core over that on two, by case and code.

    Without those where one of the two was measured on a busy machine.
    """
    walls = {(row.case, row.code, row.ranks): row for row in rows if not row.busy}
    return {
        (case, code): wall.wall_microseconds_per_particle_step
        / walls[case, code, 2].wall_microseconds_per_particle_step
        for (case, code, ranks), wall in walls.items()
        if ranks == 1 and (case, code, 2) in walls
    }


def drawn(rows: Sequence[Row]) -> Figure:
    """Draw the cost of each code, a group of bars for each case, and how it scales to two cores."""
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    above, below = figure.subplots(2)
    codes = list(dict.fromkeys(row.code for row in rows))
    cases = list(dict.fromkeys(row.case for row in rows))
    gains = speedups(rows)
    for number, code in enumerate(codes):
        shift = (number - 0.5 * (len(codes) - 1)) * 0.8 / len(codes)
        costs = {
            row.case: row.microseconds_per_particle_step
            for row in rows
            if (row.code, row.ranks) == (code, 1)
        }
        gained = {case: gains[case, code] for case in cases if (case, code) in gains}
        for axes, values, text in ((above, costs, "%.2g"), (below, gained, "%.2f")):
            places = [cases.index(case) + shift for case in values]
            bars = axes.bar(
                places, list(values.values()), 0.8 / len(codes), color=COLOURS[number], label=code
            )
            axes.bar_label(
                bars, fmt=text, fontsize=8, bbox={"fc": "white", "ec": "none", "pad": 0.3}
            )
    above.set(yscale="log", ylabel="time of a particle\nand step, one core (µs)")
    below.set(ylabel="wall time on one core\nover that on two", ylim=(0.0, 2.3))
    below.axhline(1.0, color="black", lw=1, zorder=0.5)
    for axes in (above, below):
        axes.set_xticks(range(len(cases)), cases)
        axes.set_xlim(-0.5, len(cases) - 0.5)
        axes.grid(axis="x", visible=False)
        axes.set_axisbelow(True)
    above.margins(y=0.15)
    if not gains:
        below.text(0.5, 0.5, "not measured: the machine was busy", ha="center",
                   transform=below.transAxes)  # fmt: skip
    figure.legend(*above.get_legend_handles_labels(), ncols=len(codes), fontsize=8,
                  loc="outside upper center")  # fmt: skip
    return figure


def main(words: Sequence[str]) -> None:
    """Measure engines by name and write table and figure into a folder."""
    import pandas as pd

    folder, names = Path(words[0]), words[1:]
    rows = table(names)
    write_csv(pd.DataFrame(rows), folder / "speed.csv", float_format="%.3g", na_rep="nan")
    with house_style():
        drawn(rows).savefig(folder / "speed.svg", metadata={"Date": None})
    busy = [f"{row.case} {row.code} on {row.ranks}" for row in rows if row.busy]
    if busy:
        print(f"the machine was busy, wall times are no measure: {', '.join(busy)}")


if __name__ == "__main__":
    main(sys.argv[1:])
