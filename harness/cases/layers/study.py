"""Does the angle at which layers stop fall with their thickness, and is it softness? The runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from harness.cases.contract import Arm, CaseStudy, Conclusion, EngineOf, Level, Row, StudyCost
from harness.cases.layers.extents import (
    CHANGES,
    COMPARED,
    EXTENTS,
    RANKS,
    SPLIT,
    Box,
    Changed,
    Extent,
)
from harness.cases.layers.system import SINGLE, SOFTEST, Layers
from harness.observables.reference import ReferencePoints

THICKNESS, LIMIT = "thickness", "single grain"
"""Arms: thickness and stiffness over seeds, and the incline as the limit of one grain."""


SINGLE_CRITICAL_DEG = (10.2023, 0.0008)
"""[deg] critical angle, and its error, at the stiffness and step of SINGLE: the smallest angle that
keeps moving in the reference DEM, which a test runs again. In the limit of a small step it is
10.204 at this stiffness, of rigid spheres 10.2078."""

REFERENCE = "as it is"
"""The arm that the changed ones of one layer are held against."""


class LayersStudy(CaseStudy):
    """Angle of stop against thickness and stiffness, and what else could move it."""

    title = "Layers: the angle at which they stop, against thickness and stiffness"
    question = (
        "The paper explains the lower angle of thick layers by deformation: the angle falls from "
        "10.21 to about 5 deg. Does a DEM of frictionless layers show the fall, and does it take "
        "soft grains?"
    )
    columns = ("arm", "layers", "stiffness_over_weight", "restitution", "stop_angle_deg",
               "uncertainty_deg", "grains", "seeds")  # fmt: skip

    def arms(self, level: Level) -> Sequence[Arm]:
        """Return thickness and stiffness over seeds, one change at a time, the single grain."""
        extent = EXTENTS[level]
        softest = min(extent.stiffnesses)
        found = [Arm(THICKNESS, tuple(_over_thickness(extent)))]
        compared = tuple(_seeds(extent.compared, COMPARED, softest))
        found.append(Arm(REFERENCE, compared))
        for name, change in extent.changes:
            found.append(Arm(name, tuple(one.replace(**change) for one in compared)))
        for value in extent.restitutions:
            contact = {"name": f"e = {value:g}, clipped", "restitution": value}
            changed = tuple(one.replace(contact=contact) for one in compared)
            found.append(Arm(f"restitution {value:g}", changed))
        if level != "quick":
            found.append(Arm(SPLIT, compared, RANKS))
        found += [_at_more_layers(some, extent) for some in extent.thicker]
        return [*found, Arm(LIMIT, (SINGLE, SINGLE.replace(rate=SINGLE.rate / 4)))]

    def cost(self, level: Level, engine_of: EngineOf, runs: Sequence[Row] = ()) -> StudyCost:
        """Return what a level costs: by runs that were made, else as measured here."""
        from harness.cases.layers.extents import cost_seen, study_cost

        arms = self.arms(level)
        return cost_seen(arms, {"runs": runs}) or study_cost(arms, engine_of)

    def conclude(
        self, arms: Mapping[str, Sequence[Row]], points: ReferencePoints | None
    ) -> Conclusion:
        """Return angles with intervals, the verdict on softness, figures and tables."""
        from harness.cases.layers.changes import TEST
        from harness.cases.layers.conclusion import read_arms, rows_of, verdict_of
        from harness.cases.layers.report import sections_of

        found = read_arms(arms)
        return Conclusion(rows_of(found), verdict_of(found), TEST, sections_of(found, points))


def _over_thickness(extent: Extent) -> Iterable[Layers]:
    """Yield the runs, the costliest first so that no core idles at the end."""
    for stiffness in sorted(extent.stiffnesses, reverse=True):
        for layers in sorted(extent.boxes, reverse=True):
            if stiffness >= SOFTEST * layers:
                box = extent.boxes[layers]
                more = box.softest if stiffness == min(extent.stiffnesses) else 0
                yield from _seeds(box, layers, stiffness, more)


def _at_more_layers(some: Changed, extent: Extent) -> Arm:
    """Return the arm of another rate, box, base or two ranks at more layers than one."""
    stiffness = (max if some.stiffest else min)(extent.stiffnesses)
    box = extent.boxes[some.layers]
    change = {**CHANGES[some.what]} if some.what else {}
    if some.factor != 1.0:
        change["length"] = round(some.factor * box.length)
        change["width"] = round(some.factor * box.width)
    runs = _seeds(box, some.layers, stiffness, some.seeds)
    return Arm(
        some.name + place_of(some.layers, stiffness),
        tuple(one.replace(**change) for one in runs),
        RANKS if some.what == SPLIT else 1,
    )


def grains_in(row: Row) -> int:
    """Return how many grains move in a run, from its row."""
    return int(row["layers"] * (row["filled_d"] or row["length_d"]) * row["width_d"])


def place_of(layers: int, stiffness: float) -> str:
    """Return what the name of an arm ends with where it is not of one layer."""
    return f", {layers} layers at {stiffness:g} weights"


def _seeds(box: Box, layers: int, stiffness: float, seeds: int = 0) -> Iterable[Layers]:
    for seed in range(1, (seeds or box.seeds) + 1):
        yield Layers(
            layers=layers,
            stiffness_over_weight=stiffness,
            length=box.length,
            width=box.width,
            first_angle=box.first_angle,
            seed=seed,
        )
