"""What level full of the study would cost, from the runs of a page."""

from __future__ import annotations

from collections.abc import Sequence

from harness.cases.layers.conclusion import Found
from harness.cases.layers.cost import cost_seen
from harness.cases.layers.study import LayersStudy
from harness.report.sections import Section, Table


def cost_section(found: Found) -> Sequence[Section]:
    """Return the table of cores; nothing where no run tells of its time."""
    cost = cost_seen(LayersStudy().arms("full"), found.arms)
    if cost is None:
        return ()
    split = [one for one in cost.measured if one["efficiency_of_2_ranks"] is not None]
    measured = "; ".join(
        f"{one['microseconds_per_grain_and_step']:.2f} us at {one['grains']:,}"
        for one in cost.measured
    )
    items = [f"A grain and step, by the grains of a run: {measured}."]
    if split:
        items.append(
            f"Efficiency of two ranks: {split[-1]['efficiency_of_2_ranks']:.2f} at "
            f"{split[-1]['grains']:,} grains."
        )
    rows = tuple(
        (
            str(row["cores"]),
            str(row["ranks_per_run"]),
            f"{row['wall_time_h']:.1f}",
            f"{row['core_hours']:.0f}",
            f"{row['efficiency']:.2f}",
        )
        for row in cost.rows
    )
    first = cost.rows[0]
    table = Table(
        "What level full would cost",
        f"{first['runs']} runs, the longest of {first['longest_run_h']:.1f} hours of a core.",
        ("cores", "ranks of a run", "hours", "core hours", "efficiency"), rows,
        frozenset(range(5)),
    )  # fmt: skip
    text = (
        "From the least wall time of each size among the runs of this page, slowed by whatever "
        "else the machine did; study layers --full --cost measures an idle one in a minute. "
        f"The model: {cost.model}"
    )
    return (Section("What level full would cost", (text,), tuple(items), (table,)),)
