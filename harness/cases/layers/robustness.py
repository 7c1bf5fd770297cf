"""What the verdict says of changes of rate, box, step, ranks and arrest, and softness with them."""

from __future__ import annotations

from collections.abc import Sequence

from harness.cases.layers.averages import Mean, difference_of, extrapolated, unpaired
from harness.cases.layers.changes import BOX, LITTLE, Change, changed_in, compared, over_box
from harness.cases.layers.conclusion import Found, layers_told, seeds_of, signed


def sentences(found: Found) -> list[str]:
    """Return in how many changes of rate, box, step, ranks and arrest the angle is the same."""
    having = [(c, one.place) for one in compared(found) for c in one.changes if not c.physical]
    every = [(c, place) for c, place in having if not c.approach]
    if not every:
        return []
    moved = [_moved(c, place) for c, place in every if c.word == "no"]
    little = [_moved(c, place) for c, place in every if c.word == LITTLE]
    narrow = [_moved(c, place) for c, place in having if c.approach and c.word != "yes"]
    same = len(every) - len(moved) - len(little)
    widest = max(c.difference.half_width for c, _ in every)
    told = [
        f"Another rate, box, step, number of ranks or definition of the arrest: in "
        f"{same} of {len(every)} changes the angle is the same within its 95 % interval (that of "
        f"the difference is ±{widest:.2f} deg at the widest)."
        + (f" It moves, but stays {LITTLE}, in {'; '.join(little)}." if little else "")
        + (f" It moves further in {'; '.join(moved)}." if moved else "")
        + _overlapping(every)
    ]
    if narrow:
        told.append(
            "In boxes smaller than the two largest of a thickness and stiffness it still depends "
            f"on the box: {'; '.join(narrow)}."
        )
    endless = softness_without_a_box(found)
    if endless:
        listed = "; ".join(f"{layers_told(h)}: {signed(one)}" for h, one in endless.items())
        told.append(f"Softness, extrapolated to an endless box, linear in 1/length: {listed} deg.")
    return told


def _overlapping(every: Sequence[tuple[Change, str]]) -> str:
    """Return in how many changes the intervals of both angles overlap."""
    apart = [f"{one.name} at {place}" for one, place in every if not one.overlaps]
    told = f" The intervals of both angles overlap in {len(every) - len(apart)} of {len(every)}"
    return told + (f", not in {'; '.join(apart)}." if apart else ".")


def _moved(one: Change, place: str) -> str:
    """Return a change with its place and the difference that it makes."""
    return f"{one.name} at {place}: {signed(one.difference)} deg"


def softness_without_a_box(found: Found) -> dict[int, Mean]:
    """Return soft minus stiff in an endless box, by layers, where both have three boxes or more."""
    limits: dict[int, dict[float, Mean]] = {}
    for some in compared(found):
        boxes, one = over_box(some), some.reference[0]
        if len(boxes) > 2:
            limit = extrapolated([*boxes], [*boxes.values()])
            limits.setdefault(one["layers"], {})[one["stiffness_over_weight"]] = limit
    return {
        h: unpaired(of[min(of)], of[max(of)]) for h, of in sorted(limits.items()) if len(of) > 1
    }


def softness_elsewhere(found: Found) -> dict[tuple[int, int, int, float], Mean]:
    """Return soft minus stiff, paired by seed, in another box or at another rate than the study's.

    The key is the layers, the length and width of the box [d] and the rate [deg/d].
    """
    angles: dict[tuple[int, int, int, float], dict[float, dict[int, float]]] = {}
    for some in compared(found):
        for rows in some.arms.values():
            changed = changed_in(rows, some.reference)
            if changed and changed <= BOX | {"rate_deg"}:
                one = rows[0]
                key = one["layers"], one["length_d"], one["width_d"], one["rate_deg"]
                angles.setdefault(key, {})[one["stiffness_over_weight"]] = seeds_of(rows)
    differences = {
        key: difference_of(by_stiffness[min(by_stiffness)], by_stiffness[max(by_stiffness)])
        for key, by_stiffness in sorted(angles.items())
        if len(by_stiffness) > 1
    }
    return {key: one for key, one in differences.items() if one.count > 1}
