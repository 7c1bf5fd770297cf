"""What else could move the angle of stop: each arm of one change against the runs without it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.cases.case_study import Row
from harness.cases.layers.averages import Mean, difference_of, extrapolated, mean_of, unpaired
from harness.cases.layers.conclusion import (
    MARGIN_DEG,
    START,
    Found,
    interval,
    layers_told,
    seeds_of,
)
from harness.cases.layers.study import LIMIT, REFERENCE, THICKNESS

DEFINITIONS = {
    "kinetic over elastic energy below 1e-3": "stop_angle_at_100_times_the_ratio_deg",
    "mean speed alone below 0.01 sqrt(g d)": "stop_angle_by_speed_deg",
}
"""Other definitions of the arrest than energies at a ratio of 1e-5, from the same runs."""

SAME = ("layers", "stiffness_over_weight", "contact.restitution", "base", "rate_deg", "length_d",
        "width_d", "steps_per_contact", "rise_deg", "ranks")  # fmt: skip
"""Columns that tell arms apart."""

LITTLE = f"within {MARGIN_DEG:g} deg"

BOX = {"length_d", "width_d"}
PHYSICAL = {"base", "contact.restitution"}
"""Columns of what may move the angle: another system, not another way to measure the same one."""


@dataclass(frozen=True)
class Change:
    """A change, the mean angle with it, and the difference that it makes [deg].

    ``own`` is the half width of the interval of the angle without it, ``physical`` says whether it
    may move the angle, ``approach`` whether it is a smaller box than the two largest.
    """

    name: str
    mean: Mean
    difference: Mean
    own: float
    physical: bool = False
    approach: bool = False

    @property
    def same(self) -> bool:
        """Return whether the angle is the same within intervals.

        Zero lies within the interval of the difference, or that one within the angle's own: pairs
        of one run know a difference far better than the angle is known.
        """
        low, high = self.difference.low, self.difference.high
        return low <= 0.0 <= high or max(-low, high) <= self.own

    @property
    def overlaps(self) -> bool:
        """Return whether the intervals of both angles overlap, the weaker sense of the same."""
        return abs(self.difference.value) <= self.own + self.mean.half_width

    @property
    def word(self) -> str:
        """Return whether the angle is the same; of one that moves a little, by how much at most."""
        low, high = self.difference.low, self.difference.high
        if self.same:
            return "yes"
        return LITTLE if max(-low, high) <= MARGIN_DEG else "no"


@dataclass(frozen=True)
class Compared:
    """The arms at one thickness and stiffness, and the runs that they are held against."""

    reference: Sequence[Row]
    arms: Mapping[str, Sequence[Row]]
    changes: tuple[Change, ...]

    @property
    def place(self) -> str:
        """Return thickness and stiffness in words."""
        one = self.reference[0]
        return f"{layers_told(one['layers'])} at {one['stiffness_over_weight']:g} weights"


def compared(found: Found) -> list[Compared]:
    """Return the changes of the arms, those of one thickness and stiffness together.

    They are held against the arm of that name, else against the runs over the thickness.
    """
    together: dict[tuple[object, ...], dict[str, Sequence[Row]]] = {}
    for name, rows in found.arms.items():
        if rows and name not in (THICKNESS, LIMIT):
            together.setdefault(_key(rows[0]), {})[name] = rows
    listed = []
    for key, arms in together.items():
        over_thickness = [row for row in found.arms.get(THICKNESS, ()) if _key(row) == key]
        reference = arms.pop(REFERENCE, over_thickness)
        if len(seeds_of(reference)) > 1:
            listed.append(Compared(reference, arms, tuple(_changes(reference, arms))))
    return listed


def _key(row: Row) -> tuple[object, ...]:
    return row["layers"], row["stiffness_over_weight"]


def changed_in(rows: Sequence[Row], reference: Sequence[Row]) -> set[str]:
    """Return the columns in which two arms differ, seeds and results apart."""
    return {name for name in SAME if rows[0][name] != reference[0][name]}


def _held_against(
    rows: Sequence[Row], reference: Sequence[Row], boxes: Sequence[Sequence[Row]]
) -> Sequence[Row]:
    """Return the runs that an arm differs from in one thing: of boxes, the next to the study's."""
    own, usual = rows[0]["length_d"], reference[0]["length_d"]
    others = [reference, *(box for box in boxes if box is not rows)]
    between = [one for one in others if min(own, usual) <= one[0]["length_d"] <= max(own, usual)]
    if _in_box_alone(rows, reference) and own != usual:
        return min(between, key=lambda one: abs(one[0]["length_d"] - own))
    return min(others, key=lambda one: len(changed_in(rows, one)))


def _in_box_alone(rows: Sequence[Row], reference: Sequence[Row]) -> bool:
    changed = changed_in(rows, reference)
    return bool(changed) and changed <= BOX


def _changes(reference: Sequence[Row], arms: Mapping[str, Sequence[Row]]) -> Iterator[Change]:
    boxes = [
        rows for rows in arms.values()
        if _in_box_alone(rows, reference) and len(seeds_of(rows)) > 1
    ]  # fmt: skip
    lengths = sorted({rows[0]["length_d"] for rows in (reference, *boxes)})
    for name, rows in arms.items():
        other = seeds_of(rows)
        if len(other) < 2:
            continue
        base = _held_against(rows, reference, boxes)
        without, mean = mean_of([*seeds_of(base).values()]), mean_of([*other.values()])
        changed, words = changed_in(rows, base), name.partition(", ")[0]
        if changed & BOX:
            words += f", {_box(rows)} for {_box(base)} d"
        pair = sorted({rows[0]["length_d"], base[0]["length_d"]})
        own, physical = without.half_width, bool(changed & PHYSICAL)
        approach = bool(changed & BOX) and pair != lengths[-2:]
        yield Change(words, mean, unpaired(mean, without), own, physical, approach)
        start = seeds_of(rows, START)
        if start:
            rises = difference_of(start, other)
            yield Change("angle of start", mean_of([*start.values()]), rises, own, physical=True)
    stop = seeds_of(reference)
    without = mean_of([*stop.values()])
    for name, quantity in DEFINITIONS.items():
        other = seeds_of(reference, quantity)
        difference = difference_of(other, stop)
        if difference.count > 1:
            yield Change(name, mean_of([*other.values()]), difference, without.half_width)


def _box(rows: Sequence[Row]) -> str:
    return f"{rows[0]['length_d']} x {rows[0]['width_d']}"


def over_box(some: Compared) -> dict[float, Mean]:
    """Return the angle of stop by 1/length of the box [1/d], of arms that differ in it alone."""
    return {1.0 / row["length_d"]: mean for row, mean in _along(some, some.reference, BOX)}


def _along(some: Compared, base: Sequence[Row], columns: set[str]) -> Iterator[tuple[Row, Mean]]:
    """Yield a row and the mean angle of ``base`` and of each arm that differs in some columns."""
    for rows in (base, *some.arms.values()):
        changed = changed_in(rows, base)
        if len(seeds_of(rows)) > 1 and (rows is base or (changed and changed <= columns)):
            yield rows[0], mean_of([*seeds_of(rows).values()])


def limits(some: Compared) -> Iterator[str]:
    """Yield the limits of a slow descent and of a large box, where there are three values."""
    boxes = [some.reference, *(rows for rows in some.arms.values()
                               if rows and _in_box_alone(rows, some.reference))]  # fmt: skip
    for base in boxes:
        rates = {row["rate_deg"]: mean for row, mean in _along(some, base, {"rate_deg"})}
        yield from _limit(f"{some.place}, {_box(base)} d, rate to zero", rates)
    endless = f"{some.place}, length of the box to infinity, linear in 1/length"
    yield from _limit(endless, over_box(some))


def _limit(what: str, values: Mapping[float, Mean]) -> Iterator[str]:
    if len(values) > 2:
        value = extrapolated([*values], [*values.values()])
        yield f"Extrapolated, {what}: {interval(value)} deg."
