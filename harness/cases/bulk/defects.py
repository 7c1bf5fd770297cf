"""What known defects of LAMMPS do in bulk: the same runs with a defect and without it.

    python -m harness.cases.bulk.defects FOLDER [--seeds N] [--only PATTERN]

writes ``defects.csv`` and ``defects.svg`` of the :mod:`switches <harness.cases.bulk.switches>`.
Runs are made one after the other and kept, so that a command that is cut goes on. With a pattern
of defect and case, as ``"tsuji* heap"``, other rows stay as they are in the folder.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.cases.bulk.equivalence import FEWEST, Sample, equivalence, interval
from harness.cases.bulk.seeds import MARGIN
from harness.cases.bulk.switches import UNSWITCHED, Switch, Variant, default, switches
from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Engine, Output
from harness.engines.registry import engine_class
from harness.errors import EngineError, EngineMissingError, EngineUndecidedError
from harness.report.plain import write_csv
from harness.shown.figure import house_style
from harness.store.cache import keeping

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 8

QUANTITIES = {
    "silo": {"discharge_rate_per_s": "rate"},
    "drum": {"mixing_index": "mixing", "surface_angle_deg": "angle"},
    "penetration": {"final_depth_m": "depth"},
    "heap": {"angle_deg": "angle", "remaining_ratio": "what stays"},
}
"""Quantities of a case, and what the figure calls them."""

WORDS = {
    Verdict.PASS: "equivalent",
    Verdict.FAIL: "moved",
    Verdict.NOT_TESTED: "undecided",
}
"""Of a ratio within 5 % of one, of one beyond, and of an interval that is partly beyond."""

LAW, PREDICTION = "law", "prediction"

NOT_RUN = "not run yet: --only has it run"
"""Why a switch that the table has not yet has no size."""


@dataclass(frozen=True)
class Runs:
    """Quantities of a variant, a value for each seed that gave one, and why others did not."""

    values: Mapping[str, tuple[float, ...]]
    failed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Row:
    """A quantity with a defect over that without it, or over that of the law that is predicted.

    ``switched`` are the words that have the defect, ``held_against`` those of the other side;
    ``against`` is :data:`LAW` or :data:`PREDICTION`. ``low`` and ``high`` are the 90 % interval of
    the ratio of the means over ``seeds`` and ``seeds_held`` values; NaN where a side has too few.
    ``without_value`` says of how many seeds of the two sides there is no value, and why; or why the
    defect is not switched in a case, in which ``switched`` is empty.
    """

    defect: str
    case: str
    quantity: str
    switched: str
    against: str
    held_against: str
    seeds: int
    mean: float
    seeds_held: int
    mean_held: float
    ratio: float
    low: float
    high: float
    verdict: str
    without_value: str

    @property
    def key(self) -> tuple[str, ...]:
        """Return what tells the row from others."""
        return self.defect, self.case, self.quantity, self.switched, self.against


def opened(variant: Variant) -> Engine:
    """Return LAMMPS as :func:`bare` does; its runs are kept."""
    return keeping(bare(variant))


def bare(variant: Variant) -> Any:
    """Return LAMMPS with a variant's lines, of its release, on its ranks.

    Raise EngineMissingError where the release, or a launcher of ranks, is not here.
    """
    kind: Any = engine_class("lammps")
    engine = kind.release(variant.release) if variant.release else kind(lmp="lmp", workers=1)
    if variant.ranks > 1:
        engine = engine.on_ranks(variant.ranks)
    engine.replaced = variant.replaced
    return engine


def runs_of(
    name: str, variant: Variant, seeds: int, opens: Callable[[Variant], Engine] = opened
) -> Runs:
    """Return the quantities of a case in a variant, seeds from 1 on; a run that fails has none.

    Raise EngineMissingError where LAMMPS is not here.
    """
    case, rows, failed = get_case(name), [], []
    with opens(variant) as engine:
        for seed in range(1, seeds + 1):
            p = default(name).replace(seed=seed)
            job = case.job(p)
            output: Output | EngineError
            (output,) = engine.run([replace(job, values={**job.values, **variant.values})])
            try:
                if isinstance(output, EngineError):
                    raise output
                rows.append(case.measured(p, output, engine.traits).values)
            except EngineUndecidedError:
                failed.append("undecided")
            except EngineError as error:
                failed.append(error.kind)
    values = {name: tuple(row[name] for row in rows) for name in QUANTITIES[name]}
    return Runs(values, tuple(failed))


def compared(switch: Switch, on: Runs, held: Runs, against: str) -> Iterator[Row]:
    """Yield a row for each quantity of a case, held against the law or the prediction."""
    for quantity in QUANTITIES[switch.case]:
        one, other = (Sample("", runs.values.get(quantity, ())) for runs in (on, held))
        means = [sample.mean if sample.values else math.nan for sample in (one, other)]
        ratio = low = high = math.nan
        failed = Counter((*on.failed, *held.failed))
        if min(len(one.values), len(other.values)) < FEWEST:
            verdict = "not tested"
        else:
            verdict = WORDS[equivalence("", one, other, MARGIN).verdict]
            ratio = means[0] / means[1]
            low, high = interval(one.values, other.values)
        yield Row(
            defect=switch.defect or "none",
            case=switch.case,
            quantity=quantity,
            switched=switch.words,
            against=against,
            held_against=switch.words_off if against == LAW else switch.cause,
            seeds=len(one.values),
            mean=means[0],
            seeds_held=len(other.values),
            mean_held=means[1],
            ratio=ratio,
            low=low,
            high=high,
            verdict=verdict,
            without_value=", ".join(f"{times} {why}" for why, times in sorted(failed.items())),
        )


def table(
    chosen: Sequence[Switch], seeds: int, run: Callable[[str, Variant, int], Runs] = runs_of
) -> Iterator[Row]:
    """Yield the rows of switches, each variant of a case run once."""
    done: dict[str, Runs] = {}

    def runs(switch: Switch, variant: Variant) -> Runs:
        key = f"{switch.case} {variant}"
        if key not in done:
            try:
                done[key] = run(switch.case, variant, seeds)
            except EngineMissingError as error:
                done[key] = Runs({}, (error.kind,))
        return done[key]

    for switch in chosen:
        on = runs(switch, switch.on)
        yield from compared(switch, on, runs(switch, switch.off), LAW)
        if switch.predicted is not None and not switch.exact:
            yield from compared(switch, on, runs(switch, switch.predicted), PREDICTION)


def unswitched() -> Iterator[Row]:
    """Yield the rows of cases in which a defect has nothing to act on, with the reason."""
    nothing = Variant()
    for (defect, case), why in UNSWITCHED.items():
        switch = Switch(defect, case, "", "", nothing, nothing)
        for row in compared(switch, Runs({}), Runs({}), LAW):
            yield replace(row, without_value=why)


def read(path: Path) -> Iterator[Row]:
    """Yield the rows of a table; none where there is no file."""
    if path.exists():
        kinds = {"seeds": int, "seeds_held": int, "mean": float, "mean_held": float}
        kinds |= {"ratio": float, "low": float, "high": float}
        with path.open(encoding="utf-8", newline="") as file:
            for record in csv.DictReader(file):
                yield Row(**{f.name: kinds.get(f.name, str)(record[f.name]) for f in fields(Row)})


def updated(before: Iterable[Row], after: Iterable[Row]) -> list[Row]:
    """Return the rows of all switches in their order, those after in place of those before."""
    rows = {row.key: row for row in (*before, *after)}
    blank = table(list(switches()), 0, lambda *_: Runs({}))
    return [
        *(rows.get(row.key, replace(row, without_value=NOT_RUN)) for row in blank),
        *unswitched(),
    ]


def written(rows: Sequence[Row], path: Path) -> None:
    """Write rows as CSV, means and ratios with five digits."""
    import pandas as pd

    write_csv(pd.DataFrame(rows), path, float_format="%.5g", na_rep="nan")


def drawn(rows: Sequence[Row]) -> Figure:
    """Draw the ratio of each row held against the law, a line each, and the margin of 5 %."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from harness.report.style import COLOURS

    held = [row for row in rows if row.against == LAW and math.isfinite(row.ratio)]
    colours = dict(zip(WORDS.values(), COLOURS, strict=False))
    figure = Figure(figsize=(4.6, 1.2 + 0.4 * len(held)), layout="constrained")
    axes = figure.subplots()
    width = MARGIN.width(1.0)
    axes.axvspan(1.0 - width, 1.0 + width, color="#dddddd", lw=0.0, zorder=0)
    axes.axvline(1.0, color="black", lw=0.8, zorder=1)
    ends = [end for row in held for end in (row.low, row.high)]
    low, high = min([0.85, *ends]) - 0.05, max([1.2, *ends]) + 0.05
    for place, row in enumerate(held):
        colour = colours[row.verdict]
        axes.plot((row.low, row.high), (place, place), color=colour, lw=2.0)
        axes.plot(row.ratio, place, "o", color=colour)
        label = f"{row.case}, {QUANTITIES[row.case][row.quantity]}: {row.switched}"
        axes.annotate(label, (0.01, place - 0.36), xycoords=("axes fraction", "data"),
                      fontsize=8.5, va="center")  # fmt: skip
    # a defect may turn the sign of an angle: no logarithm
    axes.set(xlim=(low, high), ylim=(len(held) - 0.5, -0.9), yticks=[])
    axes.set_xlabel("with the defect over without it, 90 % interval")
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)
    marks = [Line2D([], [], color=c, marker="o", lw=2.0, label=word) for word, c in colours.items()]
    figure.legend(handles=marks, ncols=3, loc="outside upper center")
    return figure


def main(words: Sequence[str] | None = None) -> None:
    """Run the selected switches and write table and figure into a folder."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"of each variant, {SEEDS}")
    parser.add_argument("--only", default="*", help='defect and case, as "tsuji* heap"; all')
    options = parser.parse_args(words)
    selected = [s for s in switches() if fnmatchcase(f"{s.defect} {s.case}", options.only)]
    path = options.folder / "defects.csv"
    rows = []
    for row in table(selected, options.seeds):
        print(row, flush=True)
        rows.append(row)
    rows = updated(read(path), rows)
    written(rows, path)
    with house_style():
        drawn(rows).savefig(options.folder / "defects.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
