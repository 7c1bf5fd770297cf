"""What else could move the angle of stop: each arm of one change against the runs without it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from statistics import fmean
from typing import Literal

from harness.cases.layers.averages import (
    BOX_POWERS,
    MARGIN_DEG,
    RATE_POWERS,
    Mean,
    ModelLimit,
    Word,
    covering,
    limit_of,
    mean_of,
    paired_difference,
    welch,
    with_scatter_of,
)
from harness.cases.layers.extents import LIMIT, REFERENCE, THICKNESS
from harness.cases.study import Row

STOP, START = "stop_angle_deg", "start_angle_deg"

TEST = (
    "One test judges every difference of two angles, of softness as of any change. The same: the "
    f"95 % interval of the difference lies within ±{MARGIN_DEG:g} deg. Differs: it excludes zero "
    "and does not lie within that margin. Undecided: anything else; zero within a wide interval "
    "shows nothing. Runs on the same base (box, kind of base and seed are equal: the same base, "
    "sizes and places) are subtracted seed by seed, with the interval of Student's t over the "
    "pairs; runs on other bases take Welch's. Runs of one system on one rank and on two are "
    "averaged seed by seed. The margin was fixed after pilot runs and before most others; that "
    "this one test judges all changes, and what is paired, was settled when 265 runs were known, "
    "before any run that was added to them was over."
)

DEFINITIONS = {
    "kinetic over elastic energy below 1e-3": "stop_angle_at_100_times_the_ratio_deg",
    "mean speed alone below 0.01 sqrt(g d)": "stop_angle_by_speed_deg",
}
"""Other definitions of the arrest than energies at a ratio of 1e-5, from the same runs."""

Kind = Literal["protocol", "box", "system"]
"""What is changed: how the angle is measured, the box, or what is measured."""

BOX = {"length_d", "width_d"}
PHYSICAL = {"base", "contact.restitution"}
SYSTEM = ("layers", "stiffness_over_weight", "contact.restitution", "base", "rate_deg", "length_d",
          "width_d", "steps_per_contact")  # fmt: skip
"""Columns that tell systems apart; a flow is the same on any ranks, and raised after its stop."""

COLUMNS = (*SYSTEM, "rise_deg", "ranks")
"""Columns that tell arms apart."""


@dataclass(frozen=True)
class AngleChange:
    """A change, the mean angle with it, and the difference that it makes [deg].

    ``paired`` by seed or of independent samples; ``independent`` is that difference by Welch's
    test in any case.
    """

    name: str
    place: str
    kind: Kind
    mean: Mean
    difference: Mean
    independent: Mean
    paired: bool

    @property
    def word(self) -> Word:
        """Return what the test says."""
        return self.difference.word


@dataclass(frozen=True)
class OwnRuns:
    """A quantity of the same runs: another definition of the arrest, or the angle of start."""

    name: str
    mean: Mean
    difference: Mean


@dataclass(frozen=True)
class Compared:
    """The arms at one thickness and stiffness, and the runs that they are held against."""

    reference: Sequence[Row]
    arms: Mapping[str, Sequence[Row]]
    changes: tuple[AngleChange, ...]
    definitions: tuple[OwnRuns, ...]
    starts: tuple[OwnRuns, ...]

    @property
    def place(self) -> str:
        """Return thickness and stiffness in words."""
        return place_of_row(self.reference[0])

    @property
    def boxes(self) -> dict[float, Mean]:
        """Return the mean angle by the length of the box [d], rising, of arms of that alone."""
        return _means_of_boxes(_boxes(self.reference, self.arms))

    def box_limit(self) -> ModelLimit | None:
        """Return the limit in an endless box; None of fewer than three boxes."""
        inverse = {1.0 / length: mean for length, mean in self.boxes.items()}
        return limit_of(inverse, BOX_POWERS) if len(inverse) > 2 else None

    def rate_limits(self) -> Iterator[tuple[Row, ModelLimit]]:
        """Yield a row of each box with three rates or more, and the limit of a slow descent."""
        for base in _boxes(self.reference, self.arms):
            rates = {
                rows[0]["rate_deg"]: mean_of([*seeds_of(rows).values()])
                for rows in (base, *self.arms.values())
                if rows is base or changed_in(rows, base) == {"rate_deg"}
            }
            means = {rate: mean for rate, mean in rates.items() if mean.count > 1}
            if len(means) > 2:
                yield base[0], limit_of(means, RATE_POWERS)


def layers_label(number: int) -> str:
    """Return a number of layers in words."""
    return "1 layer" if number == 1 else f"{number} layers"


def place_of_row(row: Row) -> str:
    """Return thickness and stiffness in words."""
    return f"{layers_label(row['layers'])} at {row['stiffness_over_weight']:g} weights"


def seeds_of(rows: Sequence[Row], quantity: str = STOP) -> dict[int, float]:
    """Return a quantity by seed, the mean over runs on different ranks, of the runs that have it.

    A run that stands in several arms counts once.
    """
    runs = {(r["seed"], r["ranks"]): r[quantity] for r in rows if r.get(quantity) is not None}
    seeds: dict[int, list[float]] = {}
    for (seed, _), value in sorted(runs.items()):
        seeds.setdefault(seed, []).append(value)
    return {seed: fmean(values) for seed, values in seeds.items()}


def same_system(rows: Sequence[Row], arms: Mapping[str, Sequence[Row]]) -> list[Row]:
    """Return rows and all other runs of their system, in any arm; raised ones have its stop."""
    key = [rows[0][name] for name in SYSTEM]
    return [
        row for row in chain(rows, *arms.values()) if [row[name] for name in SYSTEM] == key
    ]  # fmt: skip


def compared(arms: Mapping[str, Sequence[Row]]) -> list[Compared]:
    """Return the changes of the arms, those of one thickness and stiffness together.

    They are held against the arm of that name, else against the runs over the thickness.
    """
    together: dict[tuple[object, ...], dict[str, Sequence[Row]]] = {}
    for name, rows in arms.items():
        if rows and name not in (THICKNESS, LIMIT):
            together.setdefault(_key(rows[0]), {})[name] = rows
    listed = []
    for key, some in together.items():
        over_thickness = [row for row in arms.get(THICKNESS, ()) if _key(row) == key]
        alone = some.pop(REFERENCE, over_thickness)
        if len(seeds_of(alone)) > 1:
            listed.append(_compared(same_system(alone, arms), some, arms))
    return listed


def _compared(
    reference: Sequence[Row],
    some: Mapping[str, Sequence[Row]],
    arms: Mapping[str, Sequence[Row]],
) -> Compared:
    comparable = {
        name: rows if "ranks" in changed_in(rows, reference) else same_system(rows, arms)
        for name, rows in some.items()
        if seeds_of(rows) and changed_in(rows, reference) != {"rise_deg"}
    }
    raised = [rows for rows in some.values() if seeds_of(rows, START)]
    return Compared(
        reference,
        comparable,
        (*_changes(reference, comparable), *_box_changes(reference, comparable)),
        tuple(_definitions(reference)),
        tuple(_starts(raised)),
    )


def _key(row: Row) -> tuple[object, ...]:
    return row["layers"], row["stiffness_over_weight"]


def changed_in(rows: Sequence[Row], reference: Sequence[Row]) -> set[str]:
    """Return the columns in which two arms differ, seeds and results apart."""
    return {name for name in COLUMNS if rows[0][name] != reference[0][name]}


def _boxes(
    reference: Sequence[Row], arms: Mapping[str, Sequence[Row]]
) -> list[Sequence[Row]]:  # fmt: skip
    """Return the runs of the reference and of arms that differ in the box alone, by its length."""
    others = [
        rows for rows in arms.values()
        if (changed := changed_in(rows, reference)) and changed <= BOX
    ]  # fmt: skip
    return sorted((reference, *others), key=lambda rows: rows[0]["length_d"])


def _means_of_boxes(boxes: Sequence[Sequence[Row]]) -> dict[float, Mean]:
    means: dict[float, Mean] = {}
    for rows in boxes:
        mean = mean_of([*seeds_of(rows).values()])
        if means:
            mean = with_scatter_of(mean, [*means.values()][-1])
        if not math.isnan(mean.half_width):  # as of one seed without a smaller box
            means[rows[0]["length_d"]] = mean
    return means


def _box_changes(
    reference: Sequence[Row], arms: Mapping[str, Sequence[Row]]
) -> Iterator[AngleChange]:  # fmt: skip
    boxes = {rows[0]["length_d"]: rows[0] for rows in _boxes(reference, arms)}
    means = _means_of_boxes(_boxes(reference, arms))
    for small, large in pairwise(means):
        difference = welch(means[large], means[small])
        name = f"{box_of(boxes[large])} for {box_of(boxes[small])} d"
        place = place_of_row(reference[0])
        yield AngleChange(name, place, "box", means[large], difference, difference, paired=False)


def _changes(
    reference: Sequence[Row], arms: Mapping[str, Sequence[Row]]
) -> Iterator[AngleChange]:  # fmt: skip
    """Yield each arm against the runs that it differs from in the fewest columns."""
    boxes = _boxes(reference, arms)
    for name, rows in arms.items():
        if any(rows is box for box in boxes) or len(seeds_of(rows)) < 2:
            continue
        base = min(boxes, key=lambda box: len(changed_in(rows, box)))
        changed = changed_in(rows, base)
        if changed == {"ranks"}:  # runs on other ranks are not among those without the change
            base = [row for row in base if row["ranks"] != rows[0]["ranks"]]
        kind: Kind = "system" if changed & PHYSICAL else "protocol"
        angles, without = seeds_of(rows), seeds_of(base)
        means = mean_of([*angles.values()]), mean_of([*without.values()])
        independent = welch(*means)
        paired = not changed & {*BOX, "base"}
        difference = paired_difference(angles, without) if paired else independent
        words = f"{name.partition(', ')[0].partition(' in the ')[0]}, {box_of(base[0])} d"
        place = place_of_row(reference[0])
        yield AngleChange(words, place, kind, means[0], difference, independent, paired)


def _definitions(reference: Sequence[Row]) -> Iterator[OwnRuns]:
    stop = seeds_of(reference)
    for name, quantity in DEFINITIONS.items():
        other = seeds_of(reference, quantity)
        difference = paired_difference(other, stop)
        if difference.count > 1:
            yield OwnRuns(name, mean_of([*other.values()]), difference)


def _starts(raised: Sequence[Sequence[Row]]) -> Iterator[OwnRuns]:
    for rows in raised:
        start, stop = seeds_of(rows, START), seeds_of(rows)
        words = f"{box_of(rows[0])} d, {rows[0]['rise_deg']:g} deg in each sqrt(d/g)"
        yield OwnRuns(words, mean_of([*start.values()]), paired_difference(start, stop))


def box_of(row: Row) -> str:
    """Return length by width of a run's box."""
    return f"{row['length_d']} x {row['width_d']}"


def softness_elsewhere(
    places: Sequence[Compared],
) -> dict[tuple[int, int, int, float], Mean]:
    """Return soft minus stiff, paired by seed, in another box or at another rate than the study's.

    The key is the layers, the length and width of the box [d] and the rate [deg/d].
    """
    angles: dict[tuple[int, int, int, float], dict[float, dict[int, float]]] = {}
    for some in places:
        for rows in some.arms.values():
            changed = changed_in(rows, some.reference)
            if changed and changed <= BOX | {"rate_deg"}:
                row = rows[0]
                key = row["layers"], row["length_d"], row["width_d"], row["rate_deg"]
                angles.setdefault(key, {})[row["stiffness_over_weight"]] = seeds_of(rows)
    differences = {
        key: paired_difference(by_stiffness[min(by_stiffness)], by_stiffness[max(by_stiffness)])
        for key, by_stiffness in sorted(angles.items())
        if len(by_stiffness) > 1
    }
    return {key: mean for key, mean in differences.items() if mean.count > 1}


def softness_in_an_endless_box(places: Sequence[Compared]) -> dict[int, Mean]:
    """Return soft minus stiff in an endless box, by layers, where both have three boxes or more.

    The interval covers those of each model that neither rejects.
    """
    limits: dict[int, dict[float, ModelLimit]] = {}
    for some in places:
        limit, row = some.box_limit(), some.reference[0]
        if limit is not None:
            limits.setdefault(row["layers"], {})[row["stiffness_over_weight"]] = limit
    return {
        h: _difference_of_limits(of[min(of)], of[max(of)])
        for h, of in sorted(limits.items())
        if len(of) > 1
    }


def _difference_of_limits(soft: ModelLimit, stiff: ModelLimit) -> Mean:
    pairs = list(zip(soft.models, stiff.models, strict=True))
    kept = [pair for pair in pairs if pair[0] in soft.kept and pair[1] in stiff.kept] or pairs
    return covering(
        [
            Mean(
                first.limit.value - second.limit.value,
                (first.limit.half_width**2 + second.limit.half_width**2) ** 0.5,
                min(first.limit.count, second.limit.count),
            )
            for first, second in kept
        ]
    )


def signed(mean: Mean) -> str:
    """Return a difference with its sign and the half width of its interval."""
    return f"{mean.value:+.2f} ± {mean.half_width:.2f}"


def interval(mean: Mean) -> str:
    """Return a mean with the half width of its interval."""
    return f"{mean.value:.2f} ± {mean.half_width:.2f}"
