"""How much of the study of layers a level runs: boxes, seeds, and what is changed one at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from harness.cases.case_study import Level


class Changed(NamedTuple):
    """An arm at more layers than one in which one thing is changed, or one and the box.

    The box is ``factor`` times as long and wide as the one over the thickness.
    """

    layers: int
    stiffest: bool
    seeds: int
    what: str = ""
    factor: float = 1.0

    @property
    def name(self) -> str:
        """Return what is changed, in words."""
        name = (LARGEST if self.factor > 2.0 else LARGE if self.factor > 1.0 else SMALL)[0]
        box = "" if self.factor == 1.0 else name
        return " in the ".join(filter(None, (self.what, box)))


class Box(NamedTuple):
    """Of a thickness: the box [d], the first angle [deg], some 3 deg above the stop, the seeds.

    ``softest`` are those of the softest contact where they are others; 0: the same.
    """

    length: int
    width: int
    first_angle: float
    seeds: int
    softest: int = 0


BOXES = {
    1: Box(36, 18, 17.0, 7),
    2: Box(20, 10, 14.0, 8, 14),
    4: Box(24, 12, 12.0, 12),
    8: Box(18, 9, 11.0, 5, 8),
}
"""Seeds were added until Student's t over them, t s/sqrt(n), was below 0.3 deg at each stiffness: a
rule that looks at the interval, not at the angle, and leaves the interval a little too narrow,
which the report says. The numbers are fixed here now. The scatter s falls with the area, as a small
box may rest by chance: 0.8, 0.6 and 0.2 deg in 16 x 8, 24 x 12 and 36 x 18 d at one soft layer,
0.36, 0.26 and 0.06 at four.

Four and eight layers began in 16 x 8 and 12 x 6 d, which a box 1.5 times as long and wide showed to
be too small. These still are: the angle falls further in larger ones, and the report gives limits
in an endless one."""

WIDER = {
    layers: Box(32, 16, first_angle, 12)
    for layers, first_angle in {1: 17.0, 2: 14.0, 4: 12.0, 8: 11.0, 12: 10.0, 20: 9.0}.items()
}
"""Of level full: equal boxes, as a law over the thickness is that of one box."""

COMPARED = 1
"""Layers of the arms that change one thing at a time, at the softest contact: there a seed scatters
least for its cost."""

RATE = ("half the rate", {"rate": 0.05})
SMALL = ("smaller box", {"length": 16, "width": 8})
LARGE = ("larger box", {"length": 36, "width": 18})
MIDDLE = ("middle box", LARGE[1])
WIDE = ("larger box", {"length": 24, "width": 12})
STEP = ("half the step", {"steps_per_contact": 30.0})
START = ("raised again", {"rise": 0.02})
TWICE = ("twice the rate", {"rate": 0.2})
QUARTER = ("a quarter of the rate", {"rate": 0.025})
LARGEST = ("largest box", {"length": 96, "width": 48})

RANKS = 2
SPLIT = f"{RANKS} ranks"
ON_ROWS = ("ordered base", {"base": "ordered", "first_angle": 20.0})
"""From an angle at which layers surely flow there; at 30 deg they no longer stop."""

LESS_DISSIPATION = (
    "restitution 0.5",
    {"contact": {"name": "e = 0.5, clipped", "restitution": 0.5}},
)

CHANGES: Mapping[str, Mapping[str, Any]] = dict(
    (RATE, TWICE, ON_ROWS, START, LESS_DISSIPATION, (SPLIT, {}))
)
"""What an arm at more layers than one changes beside the box, by its name."""

SMALLER, LARGER = 2.0 / 3.0, 1.5
"""Factors of the boxes that the one over the thickness is compared with."""

SOFT, STIFF = False, True

THICKER = (
    Changed(2, SOFT, 8, factor=LARGER),
    Changed(2, SOFT, 6, ON_ROWS[0]),
    Changed(2, STIFF, 4, TWICE[0]),
    Changed(2, STIFF, 4, factor=0.7),
    Changed(2, STIFF, 4, SPLIT),
    Changed(4, SOFT, 4, TWICE[0]),
    Changed(4, SOFT, 6, RATE[0]),
    Changed(4, SOFT, 8, factor=LARGER),
    Changed(4, SOFT, 14, factor=SMALLER),
    Changed(4, SOFT, 8, TWICE[0], SMALLER),
    Changed(4, SOFT, 8, RATE[0], SMALLER),
    Changed(4, SOFT, 4, SPLIT, SMALLER),
    Changed(4, SOFT, 6, ON_ROWS[0], SMALLER),
    Changed(4, STIFF, 5, factor=LARGER),
    Changed(4, STIFF, 12, factor=SMALLER),
    Changed(4, STIFF, 4, TWICE[0], SMALLER),
    Changed(8, SOFT, 4, factor=LARGER),
    Changed(8, SOFT, 7, factor=SMALLER),
    Changed(8, STIFF, 3, factor=LARGER),
    Changed(8, STIFF, 7, factor=SMALLER),
    Changed(4, SOFT, 4, START[0]),
    Changed(8, SOFT, 4, START[0]),
    Changed(4, SOFT, 1, factor=3.0),
    Changed(8, SOFT, 4, LESS_DISSIPATION[0]),
    Changed(8, SOFT, 4, TWICE[0]),
    Changed(8, SOFT, 4, RATE[0]),
    Changed(8, SOFT, 4, SPLIT),
)
"""Soft and stiff, held against the same thickness and stiffness among the runs over the thickness,
or against the same box. Each was stated before one of its runs was made, half the rate at four soft
layers and twice the rate at four stiff ones after first results. Seeds are what there was time
for."""


@dataclass(frozen=True)
class Extent:
    """How much of the study a level runs."""

    boxes: Mapping[int, Box]
    stiffnesses: tuple[float, ...]
    compared: Box
    restitutions: tuple[float, ...] = (0.5,)
    changes: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    thicker: tuple[Changed, ...] = ()


EXTENTS: Mapping[Level, Extent] = {
    "quick": Extent(
        {1: Box(12, 6, 17.0, 5), 2: Box(10, 5, 14.0, 5), 4: Box(8, 4, 12.0, 5)},
        (300.0, 3e4), Box(12, 6, 17.0, 5), (), (RATE, WIDE, START),
    ),
    "default": Extent(
        BOXES, (300.0, 3e4), Box(24, 12, 17.0, 8), (0.5,), (RATE, SMALL, LARGE, STEP, START),
        THICKER,
    ),
    "full": Extent(
        WIDER, (1e3, 1e4, 1e5, 1e6), Box(48, 24, 17.0, 12), (0.3, 0.5, 0.7),
        (TWICE, RATE, QUARTER, SMALL, MIDDLE, LARGEST, STEP, START),
        THICKER,
    ),
}  # fmt: skip
