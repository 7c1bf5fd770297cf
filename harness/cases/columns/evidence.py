"""Critical angles over columns, and what the source's theory makes of the same columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from harness.cases.columns.parameters import Columns, Inside
from harness.cases.columns.runs import critical_angle, run_columns
from harness.cases.contract import LevelName
from harness.cases.incline.result import Motion
from harness.cases.runs import complete
from harness.cases.source_angles import source_angles
from harness.engines.contract import Engine
from harness.engines.parallel import cores, parallel_map
from harness.parameters.contact import PLASTIC
from harness.parameters.tower import LAWS, Law
from harness.theory.shock import Reading

STEPS = 200.0


@dataclass(frozen=True)
class Angle:
    """A critical angle [deg] over columns, beside the source's in both readings [deg].

    The uncertainty of elastic columns is half the range in which moving and trapped angles mix.
    """

    n: int
    law: Law
    inside: Inside
    stiffness: float  # [N/m]
    value_deg: float
    uncertainty_deg: float

    @property
    def source_deg(self) -> dict[Reading, float]:
        """Return the source's angle of each reading."""
        return source_angles(self.n, self.law)


@dataclass
class Angles:
    """The angles of a study."""

    found: list[Angle] = field(default_factory=list)

    def of(self, **same: Any) -> list[Angle]:
        """Return the angles whose attributes have these values."""
        return [a for a in self.found if all(getattr(a, key) == v for key, v in same.items())]

    def records(self) -> list[dict[str, Any]]:
        """Return the angles as flat JSON-ready mappings."""
        return [
            {
                **asdict(angle),
                **{f"source_{reading}_deg": v for reading, v in angle.source_deg.items()},
            }
            for angle in self.found
        ]


HEIGHTS: dict[LevelName, tuple[int, ...]] = {
    "quick": (1, 2, 4),
    "default": (1, 2, 4, 8),
    "full": (1, 2, 4, 8, 16),
}
STIFFNESSES: dict[LevelName, tuple[float, ...]] = {
    "quick": (1e5, 1e6),
    "default": (1e4, 1e5, 1e6),
    "full": (1e5, 1e6, 1e7),
}


def damped_cases(level: LevelName) -> list[Columns]:
    """Return the columns of a level whose contacts all damp as the grain's, plastic."""
    return [
        Columns(n=n, law=law, contact=PLASTIC, stiffness=k, steps_per_contact=STEPS)
        for law in LAWS
        for k in STIFFNESSES[level]
        for n in HEIGHTS[level]
    ]


def damped_angles(cases: Sequence[Columns], engine: Engine) -> list[Angle]:
    """Return the critical angles by passage, side by side; raise the first EngineError."""

    def one(case: Columns) -> Angle:
        found = critical_angle(case, engine)
        return _angle(case, found.value_deg, found.uncertainty_deg)

    return parallel_map(one, cases, cores())


ELASTIC: dict[LevelName, tuple[int, ...]] = {"quick": (), "default": (2, 4), "full": (2, 4, 8)}
SCAN = tuple(10.0 + 0.1 * i for i in range(11))
"""[deg] angles of elastic columns: fates mix, so that they are counted and not bisected."""


def elastic_angles(level: LevelName, engine: Engine) -> Iterator[Angle]:
    """Yield where passages over columns without dashpots turn from trapped to moving on.

    Half way between the lowest angle that moves on and the highest that is trapped, with half
    their distance and half a step of the scan.
    """
    for law in LAWS:
        for n in ELASTIC[level]:
            case = Columns(
                n=n, law=law, inside="elastic", contact=PLASTIC, stiffness=1e5,
                steps_per_contact=STEPS,
            )  # fmt: skip
            runs = complete(run_columns(engine, [case.replace(angle=a) for a in SCAN], "passage"))
            moves = [r.case.angle for r in runs if r.motion is Motion.MOVES_ON]
            trapped = [r.case.angle for r in runs if r.motion is Motion.TRAPPED]
            low, high = min(moves, default=SCAN[-1]), max(trapped, default=SCAN[0])
            step = SCAN[1] - SCAN[0]
            yield _angle(case, 0.5 * (low + high), 0.5 * (abs(high - low) + step))


def _angle(case: Columns, value: float, uncertainty: float) -> Angle:
    return Angle(case.n, case.law, case.inside, case.stiffness, value, uncertainty)
