"""What a particle and step cost a code in the bulk cases: processor time of one core.

    python -m harness.cases.bulk.speed FOLDER lammps liggghts yade kratos

writes ``speed.csv`` and ``speed.svg``. Runs are made one after the other, each code with the same
law, step and dense start (a lattice of 1.02 diameters). A run of few steps is subtracted from one
of many, so that no start of a program counts, and processor time is taken, user and system, so
that other work of the machine counts little.
"""

from __future__ import annotations

import csv
import resource
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.cases.registry import get_case
from harness.engines.contract import Engine, Job
from harness.engines.registry import engine_class
from harness.errors import EngineError
from harness.shown.figure import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = ("penetration", "silo", "drum")
FEW, MANY = 1500, 3000
"""Steps before the release, the opening, the turning of the two runs."""

DENSE = {"spacing": 1.02, "scatter": 0.02}
COLUMNS = ("case", "code", "grains", "step_s", "microseconds_per_particle_step")

Clock = Callable[[], float]
Row = tuple[str, str, int, float, float]


def processor_seconds() -> float:
    """Return the processor time of all processes that were started and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(
    case_name: str, engine: Callable[[], Engine], clock: Clock = processor_seconds
) -> tuple[int, float, float]:
    """Return grains, step [s] and processor time of a particle and step [us].

    Raise EngineError for a run that fails.
    """
    case = get_case(case_name)
    p: Any = case.default.replace(**DENSE)
    values = {**case.job(p).values, "steps": 50, "series_every": 50}
    spent = []
    for steps in (FEW, MANY):
        began = clock()
        with engine() as opened:
            (output,) = opened.run(
                [Job(case.template, {**values, "settle_steps": steps}, "", True)]
            )
        if isinstance(output, EngineError):
            raise output
        spent.append(clock() - began)
    work = p.grains * (MANY - FEW)
    return p.grains, p.step_size, 1e6 * (spent[1] - spent[0]) / work


def table(names: Sequence[str]) -> list[Row]:
    """Return a row for each case and engine, by name."""
    rows = []
    for case in CASES:
        for name in names:
            kind: Any = engine_class(name)
            rows.append((case, kind.traits.title or name.upper(), *measure(case, kind)))
            print(*rows[-1], flush=True)
    return rows


def drawn(rows: Sequence[Row]) -> Figure:
    """Draw the cost of each code, a group of bars for each case."""
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.subplots()
    codes = list(dict.fromkeys(row[1] for row in rows))
    cases = list(dict.fromkeys(row[0] for row in rows))
    for number, code in enumerate(codes):
        cost = {row[0]: row[4] for row in rows if row[1] == code}
        places = [
            i + (number - 0.5 * (len(codes) - 1)) * 0.8 / len(codes) for i in range(len(cases))
        ]
        bars = axes.bar(
            places,
            [cost[case] for case in cases],
            0.8 / len(codes),
            color=COLOURS[number],
            label=code,
        )
        axes.bar_label(bars, fmt="%.2g", fontsize=8)
    axes.set_xticks(range(len(cases)), cases)
    axes.set(yscale="log", ylabel="time of a particle and step (µs)")
    axes.grid(axis="x", visible=False)
    axes.set_axisbelow(True)
    axes.margins(y=0.15)
    figure.legend(title="one core", ncols=len(codes), fontsize=8, loc="outside upper center")
    return figure


def main(words: Sequence[str]) -> None:
    """Measure engines by name and write table and figure into a folder."""
    folder, names = Path(words[0]), words[1:]
    rows = table(names)
    with (folder / "speed.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([*row[:4], f"{row[4]:.3g}"] for row in rows)
    with house_style():
        drawn(rows).savefig(folder / "speed.svg", metadata={"Date": None})


if __name__ == "__main__":
    main(sys.argv[1:])
