"""What follows from the runs of the study: angles with intervals, rows, a verdict in sentences."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

from harness.cases.layers.averages import (
    Fit,
    Mean,
    Word,
    fit_over_thickness,
    mean_of,
    paired_difference,
    welch,
)
from harness.cases.layers.changes import (
    START,
    STOP,
    AngleChange,
    Compared,
    Kind,
    compared,
    interval,
    layers_label,
    same_system,
    seeds_of,
    signed,
    softness_in_an_endless_box,
)
from harness.cases.layers.extents import LIMIT, REFERENCE, THICKNESS, grains_in
from harness.cases.study import Row
from harness.errors import RequestError

Key = tuple[float, int]
"""Stiffness over weight, layers."""


@dataclass(frozen=True)
class StudyAngles:
    """Angles [deg] by stiffness and thickness, each by seed, and what follows."""

    angles: Mapping[Key, Mapping[int, float]]
    arms: Mapping[str, Sequence[Row]]
    fits: Mapping[float, Fit] = field(default_factory=dict)

    @cached_property
    def places(self) -> list[Compared]:
        """Return the changes at each thickness and stiffness."""
        return compared(self.arms)

    @property
    def stiffnesses(self) -> list[float]:
        """Return the stiffnesses over weight, rising."""
        return sorted({k for k, _ in self.angles})

    def layers(self, stiffness: float) -> list[int]:
        """Return the thicknesses of a stiffness, rising."""
        return sorted(h for k, h in self.angles if k == stiffness)

    def mean(self, stiffness: float, layers: int) -> Mean:
        """Return the mean angle of stop."""
        return mean_of([*self.angles[stiffness, layers].values()])

    def softness(self) -> dict[int, Mean]:
        """Return the angle of the softest minus that of the stiffest contact, by layers."""
        if len(self.stiffnesses) < 2:
            return {}
        soft, stiff = self.stiffnesses[0], self.stiffnesses[-1]
        shared = set(self.layers(soft)) & set(self.layers(stiff))
        return {
            h: paired_difference(self.angles[soft, h], self.angles[stiff, h])
            for h in sorted(shared)
        }


def read_arms(arms: Mapping[str, Sequence[Row]]) -> StudyAngles:
    """Return the angles over the thickness, each of all runs of its system, and the fits."""
    angles = {
        (some[0]["stiffness_over_weight"], some[0]["layers"]): seeds
        for some in grouped(arms.get(THICKNESS, ())).values()
        if (seeds := seeds_of(same_system(some, arms)))
    }
    boxes = {(row["length_d"], row["width_d"]) for row in arms.get(THICKNESS, ())}
    fits = {}
    for stiffness in {k for k, _ in angles} if len(boxes) == 1 else ():
        means = {h: mean_of([*a.values()]) for (k, h), a in angles.items() if k == stiffness}
        try:
            fits[stiffness] = fit_over_thickness({h: m for h, m in means.items() if m.count > 1})
        except RequestError:
            continue  # the section says that there is no fit
    return StudyAngles(angles, arms, fits)


def grouped(rows: Sequence[Row]) -> dict[tuple[object, ...], list[Row]]:
    """Return rows by all that is not a seed."""
    names = ("stiffness_over_weight", "layers", "length_d", "width_d", "rate_deg", "base")
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return groups


def rows_of(results: StudyAngles) -> tuple[Row, ...]:
    """Return a row of results for each arm, of the thickness for each place."""
    return tuple(
        _row(name, some, same_system(some, results.arms) if name == THICKNESS else some)
        for name, rows in results.arms.items()
        for some in grouped(rows).values()
    )


def _row(arm: str, some: Sequence[Row], system: Sequence[Row]) -> Row:
    first = some[0]
    stop = mean_of([*seeds_of(system).values()])
    start = mean_of([*seeds_of(some, START).values()])
    return {
        "arm": arm,
        "layers": first["layers"],
        "stiffness_over_weight": first["stiffness_over_weight"],
        "restitution": first["contact.restitution"] or 0.0,
        "stop_angle_deg": stop.value,
        # one grain has one well: its angle is known to the rate
        "uncertainty_deg": first["rate_deg"] if arm == LIMIT else stop.half_width,
        "grains": grains_in(first),
        "seeds": stop.count,
        "scatter_deg": stop.scatter,
        "undecided": sum(row[STOP] is None for row in some),
        "start_angle_deg": start.value if start.count else None,
        "start_uncertainty_deg": start.half_width if start.count else None,
        "length_d": first["length_d"],
        "width_d": first["width_d"],
        "rate_deg_per_d": first["rate_deg"],
        "steps_per_contact": first["steps_per_contact"],
        "base": first["base"],
        "ranks": first["ranks"],
    }


def verdict_of(results: StudyAngles) -> tuple[str, ...]:
    """Return what the runs say, in sentences."""
    return (
        *_of_thickness(results), *_of_softness(results), *_of_changes(results),
        *_of_own_runs(results), *_of_boxes(results), *_of_undecided(results.arms),
    )  # fmt: skip


def _of_thickness(results: StudyAngles) -> list[str]:
    if not results.angles:
        return ["No run stopped: there is no angle."]
    stiff = results.stiffnesses[-1]
    layers = results.layers(stiff)
    if len(layers) < 2:
        return ["One thickness only: nothing is said of the fall."]
    means = {h: results.mean(stiff, h) for h in layers}
    listed = ", ".join(f"{interval(means[h])} at {h}" for h in layers)
    fall = welch(means[layers[0]], means[layers[-1]])
    falls = all(welch(means[a], means[b]).low > 0.0 for a, b in pairwise(layers))
    how = "falls" if falls else "is not shown to fall"
    return [
        f"With stiff grains (k d/(m g) = {stiff:g}) the angle of stop {how} with every step in "
        f"thickness: {listed} layers (deg); "
        f"from {layers[0]} to {layers[-1]} layers by {interval(fall)} deg."
    ]


def _of_softness(results: StudyAngles) -> list[str]:
    differences = results.softness()
    if not differences:
        return ["One stiffness only: nothing is said of softness."]
    soft, stiff = results.stiffnesses[0], results.stiffnesses[-1]
    listed = "; ".join(
        f"{layers_label(h)}: {signed(mean)} deg, {mean.word}" for h, mean in differences.items()
    )
    largest = max(abs(difference.value) for difference in differences.values())
    first, last = min(differences), max(differences)
    falls = {k: welch(results.mean(k, first), results.mean(k, last)) for k in (soft, stiff)}
    overall = _overall({difference.word for difference in differences.values()})
    return [
        f"Softness, {soft:g} against {stiff:g} weights ({stiff / soft:.0f} times): {listed}.",
        f"{overall} The largest difference is {largest:.2f} deg.",
        f"From {first} to {last} layers the angle falls by {interval(falls[soft])} deg at {soft:g} "
        f"weights and by {interval(falls[stiff])} deg at {stiff:g}.",
    ]


def _overall(words: set[Word]) -> str:
    if words == {"the same"}:
        return "The angle does not depend on softness at any thickness: disorder and size do it."
    if "differs" in words:
        where = "at every thickness" if words == {"differs"} else "at some thicknesses"
        return f"The angle depends on softness {where}."
    return "Softness is undecided at some thicknesses, and nowhere does the angle depend on it."


SUBJECTS: Mapping[Kind, str] = {
    "protocol": "Another rate, step or number of ranks, in runs of their own",
    "box": "A box against the next smaller one",
    "system": "Another restitution, or an ordered base",
}


def _of_changes(results: StudyAngles) -> list[str]:
    changes = [change for place in results.places for change in place.changes]
    sentences = []
    for kind, subject in SUBJECTS.items():
        some = [change for change in changes if change.kind == kind]
        if some:
            sentences.append(f"{subject}: {_counted(some)}")
    return sentences


def _counted(some: Sequence[AngleChange]) -> str:
    words = Counter(change.word for change in some)
    numbers = (
        f"{words['the same']} the same, {words['differs']} differ, {words['undecided']} undecided"
    )
    moved = [f"{c.name} at {c.place}: {signed(c.difference)} deg"
             for c in some if c.word == "differs"]  # fmt: skip
    wide = [c.difference.half_width for c in some if c.word == "undecided"]
    return (
        f"of {len(some)} changes {numbers}."
        + (f" Those that differ: {'; '.join(moved)}." if moved else "")
        + (f" The undecided have half widths of {min(wide):.2f} to {max(wide):.2f} deg."
           if wide else "")
    )  # fmt: skip


def _of_own_runs(results: StudyAngles) -> list[str]:
    sentences = []
    definitions = [definition for place in results.places for definition in place.definitions]
    if definitions:
        same = sum(definition.difference.word == "the same" for definition in definitions)
        largest = max(abs(definition.difference.value) for definition in definitions)
        sentences.append(
            f"Other definitions of the arrest are read from the same runs and are no changes of "
            f"their own: {same} of {len(definitions)} the same, by {largest:.2f} deg at most."
        )
    starts = [f"{place.place}, {start.name}: {signed(start.difference)} deg "
              f"({start.difference.count} seeds, {start.difference.word})"
              for place in results.places for start in place.starts]  # fmt: skip
    if starts:
        sentences.append(f"Hysteresis, start minus stop of the same runs: {'; '.join(starts)}.")
    return sentences


def _of_boxes(results: StudyAngles) -> list[str]:
    limits = {place.place: place.box_limit() for place in results.places}
    listed = "; ".join(f"{name}: {interval(limit.mean)}" for name, limit in limits.items() if limit)
    if not listed:
        return []
    sentences = [
        f"In an endless box, by each model that the boxes do not reject: {listed} deg."
    ]  # fmt: skip
    endless = softness_in_an_endless_box(results.places)
    if endless:
        differences = "; ".join(
            f"{layers_label(h)}: {signed(mean)} deg, {mean.word}" for h, mean in endless.items()
        )
        sentences.append(f"Softness in an endless box: {differences}.")
    return sentences


def _of_undecided(arms: Mapping[str, Sequence[Row]]) -> list[str]:
    missing = sum(row[STOP] is None for rows in arms.values() for row in rows)
    left_out = [name for name, rows in arms.items() if name != REFERENCE and not rows]
    sentences = []
    if missing:
        sentences.append(f"Without an angle: {missing} runs, undecided or failed, see runs.csv.")
    if left_out:
        sentences.append(f"Not run: {'; '.join(left_out)}.")
    return sentences
