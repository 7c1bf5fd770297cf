"""What follows from the runs of the study: angles with intervals, a verdict, the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from harness.cases.case_study import Conclusion, Row
from harness.cases.layers.averages import (
    Fit,
    Mean,
    difference_of,
    fit_over_thickness,
    mean_of,
    unpaired,
)
from harness.cases.layers.study import LIMIT, REFERENCE, THICKNESS, grains_in
from harness.errors import RequestError
from harness.observables.reference import ReferencePoints

MARGIN_DEG = 0.3
"""Differences within it count as none: what the angles are asked to be known to."""

TEST = (
    "Stated in the code, whatever a run gives: at each thickness the angles of stop at the softest "
    "and at the stiffest contact, at least a hundred apart, are subtracted seed by seed (same "
    "base, sizes and places). The angle does not depend on softness where the 95 % interval of "
    f"the mean difference lies within ±{MARGIN_DEG:g} deg; it does where the interval excludes "
    "zero and is not within that margin; else it is undecided. Intervals: the wider of a "
    "bootstrap over seeds and Student's t."
)

STOP, START = "stop_angle_deg", "start_angle_deg"
Key = tuple[float, int]
"""Stiffness over weight, layers."""


@dataclass(frozen=True)
class Found:
    """Angles [deg] by stiffness and thickness, each by seed, and what follows."""

    angles: Mapping[Key, Mapping[int, float]]
    arms: Mapping[str, Sequence[Row]]
    fits: Mapping[float, Fit] = field(default_factory=dict)

    @property
    def stiffnesses(self) -> list[float]:
        """Return the stiffnesses over weight, rising."""
        return sorted({k for k, _ in self.angles})

    def layers(self, stiffness: float) -> list[int]:
        """Return the thicknesses of a stiffness, rising."""
        return sorted(h for k, h in self.angles if k == stiffness)

    def mean(self, stiffness: float, layers: int) -> Mean:
        """Return the mean angle of stop."""
        return mean_of(list(self.angles[stiffness, layers].values()))

    def softness(self) -> dict[int, Mean]:
        """Return the angle of the softest minus that of the stiffest contact, by layers."""
        if len(self.stiffnesses) < 2:
            return {}
        soft, stiff = self.stiffnesses[0], self.stiffnesses[-1]
        shared = set(self.layers(soft)) & set(self.layers(stiff))
        return {
            h: difference_of(self.angles[soft, h], self.angles[stiff, h]) for h in sorted(shared)
        }


def concluded(arms: Mapping[str, Sequence[Row]], points: ReferencePoints | None) -> Conclusion:
    """Return rows, verdict and sections of the runs."""
    from harness.cases.layers.robustness import sentences
    from harness.cases.layers.study_sections import sections_of

    found = _found(arms)
    verdict = (
        *_of_thickness(found), *_of_softness(found), *sentences(found), *_of_undecided(arms)
    )  # fmt: skip
    rows = tuple(row for name, some in arms.items() for row in _rows(name, some))
    return Conclusion(rows, verdict, TEST, sections_of(found, points))


def seeds_of(rows: Sequence[Row], quantity: str = STOP) -> dict[int, float]:
    """Return a quantity by seed, of the runs that have it."""
    return {row["seed"]: row[quantity] for row in rows if row.get(quantity) is not None}


def grouped(rows: Sequence[Row]) -> dict[tuple[object, ...], list[Row]]:
    """Return rows by all that is not a seed."""
    names = ("stiffness_over_weight", "layers", "length_d", "width_d", "rate_deg", "base")
    found: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[name] for name in names), []).append(row)
    return found


def _found(arms: Mapping[str, Sequence[Row]]) -> Found:
    angles: dict[Key, dict[int, float]] = {}
    for row in arms.get(THICKNESS, ()):
        if row[STOP] is not None:
            key = row["stiffness_over_weight"], row["layers"]
            angles.setdefault(key, {})[row["seed"]] = row[STOP]
    fits = {}
    for stiffness in {k for k, _ in angles}:
        some = {h: list(a.values()) for (k, h), a in angles.items() if k == stiffness}
        try:
            fits[stiffness] = fit_over_thickness({h: a for h, a in some.items() if len(a) > 1})
        except RequestError:
            continue  # too few thicknesses: the section says that there is no fit
    return Found(angles, arms, fits)


def _rows(arm: str, rows: Sequence[Row]) -> list[Row]:
    return [_row(arm, some) for some in grouped(rows).values()]


def _row(arm: str, some: Sequence[Row]) -> Row:
    one = some[0]
    stop, start = mean_of([*seeds_of(some).values()]), mean_of([*seeds_of(some, START).values()])
    single = arm == LIMIT
    return {
        "arm": arm,
        "layers": one["layers"],
        "stiffness_over_weight": one["stiffness_over_weight"],
        "restitution": one["contact.restitution"] or 0.0,
        "stop_angle_deg": stop.value,
        # one grain has one well: its angle is known to the rate
        "uncertainty_deg": one["rate_deg"] if single else stop.half_width,
        "grains": grains_in(one),
        "seeds": stop.count,
        "scatter_deg": stop.scatter,
        "undecided": len(some) - stop.count,
        "start_angle_deg": start.value if start.count else None,
        "start_uncertainty_deg": start.half_width if start.count else None,
        "length_d": one["length_d"],
        "width_d": one["width_d"],
        "rate_deg_per_d": one["rate_deg"],
        "steps_per_contact": one["steps_per_contact"],
        "base": one["base"],
        "ranks": one["ranks"],
    }


def _of_thickness(found: Found) -> list[str]:
    if not found.angles:
        return ["No run stopped: there is no angle."]
    stiff = found.stiffnesses[-1]
    layers = found.layers(stiff)
    if len(layers) < 2:
        return ["One thickness only: nothing is said of the fall."]
    means = {h: found.mean(stiff, h) for h in layers}
    told = ", ".join(f"{interval(means[h])} at {h}" for h in layers)
    fall = unpaired(means[layers[0]], means[layers[-1]])
    falls = all(unpaired(means[a], means[b]).low > 0.0 for a, b in pairwise(layers))
    how = "falls" if falls else "is not shown to fall"
    return [
        f"With stiff grains (k d/(m g) = {stiff:g}) the angle of stop {how} with every step in "
        f"thickness: {told} layers (deg); "
        f"from {layers[0]} to {layers[-1]} layers by {interval(fall)} deg."
    ]


def _of_softness(found: Found) -> list[str]:
    differences = found.softness()
    if not differences:
        return ["One stiffness only: nothing is said of softness."]
    soft, stiff = found.stiffnesses[0], found.stiffnesses[-1]
    words = {h: judged(one) for h, one in differences.items()}
    told = "; ".join(
        f"{layers_told(h)}: {signed(one)} deg, {words[h]}" for h, one in differences.items()
    )
    largest = max(abs(one.value) for one in differences.values())
    first, last = min(differences), max(differences)
    falls = {k: unpaired(found.mean(k, first), found.mean(k, last)) for k in (soft, stiff)}
    return [
        f"Softness, {soft:g} against {stiff:g} weights ({stiff / soft:.0f} times): {told}.",
        f"{_overall(set(words.values()))} The largest difference is {largest:.2f} deg.",
        f"From {first} to {last} layers the angle falls by {interval(falls[soft])} deg at {soft:g} "
        f"weights and by {interval(falls[stiff])} deg at {stiff:g}.",
    ]


def judged(one: Mean) -> str:
    """Return what the test says of a difference, in one word or three."""
    if math.isnan(one.half_width):
        return "undecided"
    if one.low >= -MARGIN_DEG and one.high <= MARGIN_DEG:
        return "the same"
    return "depends on softness" if one.low > 0.0 or one.high < 0.0 else "undecided"


def _overall(words: set[str]) -> str:
    if words == {"the same"}:
        return "The angle does not depend on softness at any thickness: disorder and size do it."
    if "depends on softness" in words:
        where = "at every thickness" if words == {"depends on softness"} else "at some thicknesses"
        return f"The angle depends on softness {where}."
    return "Softness is undecided at some thicknesses, and nowhere does the angle depend on it."


def _of_undecided(arms: Mapping[str, Sequence[Row]]) -> list[str]:
    missing = sum(row[STOP] is None for rows in arms.values() for row in rows)
    left_out = [name for name, rows in arms.items() if name != REFERENCE and not rows]
    told = []
    if missing:
        told.append(f"Without an angle: {missing} runs, undecided or failed, see runs.csv.")
    if left_out:
        told.append(f"Not run: {'; '.join(left_out)}.")
    return told


def layers_told(number: int) -> str:
    """Return a number of layers in words."""
    return "1 layer" if number == 1 else f"{number} layers"


def signed(one: Mean) -> str:
    """Return a difference with its sign and the half width of its interval."""
    return f"{one.value:+.2f} ± {one.half_width:.2f}"


def interval(one: Mean) -> str:
    """Return a mean with the half width of its interval."""
    return f"{one.value:.2f} ± {one.half_width:.2f}"
