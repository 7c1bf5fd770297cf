"""What else could move the angle of stop: each arm of one change against the runs without it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.cases.case_study import Row
from harness.cases.layers.averages import Mean, difference_of, extrapolated, mean_of, unpaired
from harness.cases.layers.conclusion import START, Found, interval, layers_told, seeds_of
from harness.cases.layers.study import LIMIT, REFERENCE, THICKNESS

DEFINITIONS = {
    "kinetic over elastic energy below 1e-3": "stop_angle_at_100_times_the_ratio_deg",
    "mean speed alone below 0.01 sqrt(g d)": "stop_angle_by_speed_deg",
}
"""Other definitions of the arrest than energies at a ratio of 1e-5, from the same runs."""

SAME = ("layers", "stiffness_over_weight", "contact.restitution", "base", "rate_deg", "length_d",
        "width_d", "steps_per_contact", "rise_deg")  # fmt: skip
"""Columns that tell arms apart."""

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
    """Return the runs that an arm differs from in one thing: of larger boxes, the next smaller."""
    length = rows[0]["length_d"]
    others = [reference, *(box for box in boxes if box is not rows)]
    smaller = [one for one in others if one[0]["length_d"] < length]
    if _in_box_alone(rows, reference) and smaller:
        return max(smaller, key=lambda one: one[0]["length_d"])
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
        if len(other) > 1:
            difference = difference_of(other, stop)
            yield Change(name, mean_of([*other.values()]), difference, without.half_width)


def _box(rows: Sequence[Row]) -> str:
    return f"{rows[0]['length_d']} x {rows[0]['width_d']}"


def sentences(found: Found) -> list[str]:
    """Return in how many changes of rate, box, step, ranks and arrest the angle is the same."""
    having = [(c, one.place) for one in compared(found) for c in one.changes if not c.physical]
    every = [(c, place) for c, place in having if not c.approach]
    if not every:
        return []
    moved = [_moved(c, place) for c, place in every if not c.same]
    narrow = [_moved(c, place) for c, place in having if c.approach and not c.same]
    widest = max(c.difference.half_width for c, _ in every)
    told = [
        f"Another rate, box, step, number of ranks or definition of the arrest: in "
        f"{len(every) - len(moved)} of {len(every)} changes the angle is the same within its 95 % "
        f"interval (that of the difference is ±{widest:.2f} deg at the widest)"
        + (f"; not in {'; '.join(moved)}." if moved else ".")
    ]
    if narrow:
        told.append(
            "In boxes smaller than the two largest of a thickness and stiffness it still depends "
            f"on the box: {'; '.join(narrow)}. There the angles over the thickness are those of "
            "their boxes."
        )
    return told


def _moved(one: Change, place: str) -> str:
    """Return a change with its place and the difference that it makes."""
    return (
        f"{one.name} at {place}: {one.difference.value:+.2f} ± {one.difference.half_width:.2f} deg"
    )


def over_box(some: Compared) -> dict[float, Mean]:
    """Return the angle of stop by 1/length of the box [1/d], of arms that differ in it alone."""
    return {1.0 / row["length_d"]: mean for row, mean in _along(some, BOX)}


def _along(some: Compared, columns: set[str]) -> Iterator[tuple[Row, Mean]]:
    """Yield a row and the mean angle of each arm that differs in some columns alone."""
    for name, rows in {"": some.reference, **some.arms}.items():
        changed = changed_in(rows, some.reference)
        if len(seeds_of(rows)) > 1 and (not name or (changed and changed <= columns)):
            yield rows[0], mean_of([*seeds_of(rows).values()])


def limits(some: Compared) -> Iterator[str]:
    """Yield the limits of a slow descent and of a large box, where there are three values."""
    rates = {row["rate_deg"]: mean for row, mean in _along(some, {"rate_deg"})}
    told = {"rate to zero": rates, "length of the box to infinity, linear in 1/length":
            over_box(some)}  # fmt: skip
    for limit, values in told.items():
        if len(values) > 2:
            value = extrapolated([*values], [*values.values()])
            yield f"Extrapolated, {some.place}, {limit}: {interval(value)} deg."


def softness_at_rates(found: Found) -> dict[tuple[int, float], Mean]:
    """Return soft minus stiff, paired by seed, by layers and rate where it is not the study's."""
    angles: dict[tuple[int, float], dict[float, dict[int, float]]] = {}
    for some in compared(found):
        for rows in some.arms.values():
            if changed_in(rows, some.reference) == {"rate_deg"}:
                one = rows[0]
                at = angles.setdefault((one["layers"], one["rate_deg"]), {})
                at[one["stiffness_over_weight"]] = seeds_of(rows)
    return {
        at: difference_of(by_stiffness[min(by_stiffness)], by_stiffness[max(by_stiffness)])
        for at, by_stiffness in angles.items()
        if len(by_stiffness) > 1
    }
