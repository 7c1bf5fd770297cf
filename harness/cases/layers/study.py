"""Does the angle at which layers stop fall with their thickness, and is it softness? The runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from harness.cases.case_study import (
    Arm,
    CaseStudy,
    Conclusion,
    EngineOf,
    Level,
    Row,
    StudyCost,
)
from harness.cases.layers.parameters import SINGLE, SOFTEST, Layers
from harness.observables.reference import ReferencePoints

THICKNESS, LIMIT = "thickness", "single grain"
"""Arms: thickness and stiffness over seeds, and the incline as the limit of one grain."""


class Thicker(NamedTuple):
    """More layers than one at which rate, box and ranks are changed, one at a time.

    ``seeds`` of each arm of another rate, ``boxed`` of the box ``factor`` times as long and wide,
    ``wide`` of the first rate in that box, ``split`` of two ranks; 0: no such arm.
    """

    layers: int
    stiffest: bool
    rates: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    seeds: int = 0
    factor: float = 1.0
    boxed: int = 0
    wide: int = 0
    split: int = 0


class Box(NamedTuple):
    """Of a thickness: the box [d], the first angle [deg], some 3 deg above the stop, the seeds.

    ``softest`` are those of the softest contact, which costs least; 0: the same.
    """

    length: int
    width: int
    first_angle: float
    seeds: int
    softest: int = 0


BOXES = {
    1: Box(36, 18, 17.0, 7),
    2: Box(20, 10, 14.0, 8, 14),
    4: Box(16, 8, 12.0, 12, 14),
    8: Box(12, 6, 11.0, 7),
}
"""Seeds were added until Student's t over them, t s/sqrt(n), was below 0.3 deg at each stiffness: a
rule that looks at the interval, not at the angle. The scatter s falls faster than the root of the
area, as a small box may rest by chance: 0.8, 0.5 and 0.2 deg in 16 x 8, 24 x 12 and 36 x 18 d at
one soft layer, 0.36 and 0.08 in 16 x 8 and 24 x 12 at four.

A box is wide enough where one 1.5 times as long and wide gives the same angle within intervals. By
this 16 x 8 d at four soft layers and 12 x 6 at eight are not. That the larger box then takes its
place at both stiffnesses was meant and not done: stiff runs in it take ten minutes and more."""

WIDER = {
    1: Box(48, 24, 17.0, 12),
    2: Box(40, 20, 14.0, 12),
    4: Box(32, 16, 12.0, 12),
    8: Box(24, 12, 11.0, 12),
    12: Box(24, 12, 10.0, 12),
    20: Box(30, 15, 9.0, 12),
}
"""Of level full."""

COMPARED = 1
"""Layers of the arms that change one thing at a time, at the softest contact: there a seed scatters
least for its cost."""

ORDERED = (2, 4)
"""Layers of the arms on the ordered base, at the softest contact."""

FIRST_ON_ROWS, ON_ROWS = 20.0, 6
"""[deg] of the first flow there, at which layers surely flow, and at 30 no longer stop; seeds."""

RATE = ("half the rate", {"rate": 0.05})
SMALL = ("smaller box", {"length": 16, "width": 8})
LARGE = ("larger box", {"length": 36, "width": 18})
STEP = ("half the step", {"steps_per_contact": 30.0})
START = ("raised again", {"rise": 0.02})
TWICE = ("twice the rate", {"rate": 0.2})
QUARTER = ("a quarter of the rate", {"rate": 0.025})
LARGEST = ("largest box", {"length": 96, "width": 48})

THICKER = (
    Thicker(4, False, (TWICE, RATE), 8, 1.5, 6, 4, 4),
    Thicker(2, False, factor=1.5, boxed=4),
    Thicker(8, False, factor=1.5, boxed=5),
    Thicker(2, True, (TWICE,), 4, 0.7, 4, 0, 4),
    Thicker(4, True, (TWICE,), 4),
)
"""Soft and stiff, held against the same thickness and stiffness among the runs over the thickness.
Each was stated before one of its runs was made, half the rate at four soft layers and twice the
rate at four stiff ones after first results. Seeds are what there was time for."""


@dataclass(frozen=True)
class Extent:
    """How much of the study a level runs."""

    boxes: Mapping[int, Box]
    stiffnesses: tuple[float, ...]
    compared: Box
    restitutions: tuple[float, ...] = (0.5,)
    changes: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    thicker: tuple[Thicker, ...] = ()
    ordered: tuple[int, ...] = ()


EXTENTS: Mapping[Level, Extent] = {
    "quick": Extent(
        {1: Box(12, 6, 17.0, 5), 2: Box(10, 5, 14.0, 5), 4: Box(8, 4, 12.0, 5)},
        (300.0, 3e4), Box(12, 6, 17.0, 5), (), (RATE, START),
    ),
    "default": Extent(
        BOXES, (300.0, 3e4), Box(24, 12, 17.0, 8), (0.5,), (RATE, SMALL, LARGE, STEP, START),
        THICKER, ORDERED,
    ),
    "full": Extent(
        WIDER, (1e3, 1e4, 1e5, 1e6), Box(48, 24, 17.0, 12), (0.3, 0.5, 0.7),
        (TWICE, RATE, QUARTER, SMALL, LARGE, LARGEST, STEP, START),
        THICKER, ORDERED,
    ),
}  # fmt: skip

RANKS, REFERENCE = 2, "as it is"
"""Of MPI in the arms that split a run; the arm that the changed ones are held against."""


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
            found.append(Arm(f"{RANKS} ranks", compared, RANKS))
        for some in extent.thicker:
            found += _at_more_layers(some, extent)
        for layers in extent.ordered:
            found.append(_on_rows(layers, extent.boxes[layers], softest))
        return [*found, Arm(LIMIT, (SINGLE, SINGLE.replace(rate=SINGLE.rate / 4)))]

    def cost(self, level: Level, engine_of: EngineOf) -> StudyCost:
        """Return what a level costs, from the cost of a grain and step and of two ranks here."""
        from harness.cases.layers.cost import study_cost

        return study_cost(self.arms(level), engine_of)

    def conclude(
        self, arms: Mapping[str, Sequence[Row]], points: ReferencePoints | None
    ) -> Conclusion:
        """Return angles with intervals, the verdict on softness, figures and tables."""
        from harness.cases.layers.conclusion import concluded

        return concluded(arms, points)


def _over_thickness(extent: Extent) -> Iterable[Layers]:
    """Yield the runs, the costliest first so that no core idles at the end."""
    for stiffness in sorted(extent.stiffnesses, reverse=True):
        for layers in sorted(extent.boxes, reverse=True):
            if stiffness >= SOFTEST * layers:
                box = extent.boxes[layers]
                more = box.softest if stiffness == min(extent.stiffnesses) else 0
                yield from _seeds(box, layers, stiffness, more)


def _at_more_layers(some: Thicker, extent: Extent) -> Iterable[Arm]:
    """Yield the arms of another rate, another box and two ranks at more layers than one."""
    stiffness = (max if some.stiffest else min)(extent.stiffnesses)
    box = extent.boxes[some.layers]
    runs = tuple(_seeds(box, some.layers, stiffness, max(some.seeds, some.boxed, some.split)))
    at = place_of(some.layers, stiffness)
    for rate, change in some.rates:
        yield Arm(f"{rate}{at}", tuple(one.replace(**change) for one in runs[: some.seeds]))
    if some.split:
        yield Arm(f"{RANKS} ranks{at}", runs[: some.split], RANKS)
    if some.boxed:
        sides = {"length": round(some.factor * box.length), "width": round(some.factor * box.width)}
        boxed = tuple(one.replace(**sides) for one in runs[: some.boxed])
        name, _ = LARGE if some.factor > 1.0 else SMALL
        yield Arm(f"{name}{at}", boxed)
    if some.wide:
        rate, change = some.rates[0]
        wide = tuple(one.replace(**change) for one in boxed[: some.wide])
        yield Arm(f"{rate} in the {name}{at}", wide)


def grains_in(row: Row) -> int:
    """Return how many grains move in a run, from its row."""
    return int(row["layers"] * (row["filled_d"] or row["length_d"]) * row["width_d"])


def place_of(layers: int, stiffness: float) -> str:
    """Return what the name of an arm ends with where it is not of one layer."""
    return f", {layers} layers at {stiffness:g} weights"


def _on_rows(layers: int, box: Box, stiffness: float) -> Arm:
    """Return the arm of layers on the ordered base, first tilted until they surely flow."""
    runs = _seeds(box._replace(first_angle=FIRST_ON_ROWS), layers, stiffness, ON_ROWS)
    ordered = tuple(one.replace(base="ordered") for one in runs)
    return Arm(f"ordered base{place_of(layers, stiffness)}", ordered)


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
