"""The frictionless incline: one grain on a row of fixed, touching spheres.

Parameters; the two routes of a grain (where it starts, where it ends, by what energy it is judged);
the values that scripts take, and the same system as a scene. The LAMMPS script judges a run in its
own language; for the other engines it is judged here, by the path of the grain. Nothing here is a
force: it is how a motion is measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass, field
from enum import StrEnum
from typing import Any, Literal, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from harness.cases.grain import Grain, path_in
from harness.engines.contract import Job, Template, Value
from harness.engines.output import Table
from harness.errors import RequestError
from harness.observables.provenance import Provenance
from harness.observables.reference import Trajectory
from harness.parameters.allowed import COUNT, Allowed, allowed_in
from harness.parameters.law import (
    CLIPPED,
    PLASTIC,
    SOURCE,
    contact_allowed,
    contact_of,
    contact_values,
)
from harness.parameters.plane_scene import Stage
from harness.parameters.scene import ContactScene


class Incline(Grain):
    """One run of a grain over the row, in SI units.

    The row is periodic; the grain is a sphere as large as the fixed ones.
    """

    angle: float = Field(10.2, ge=0.0, le=30.0, description="[deg] tilt of the row")
    spheres: int = Field(9, ge=4, le=100_000, description="[-] fixed spheres in the periodic row")
    wells: int = Field(10, ge=1, le=10_000, description="[-] wells to pass in the steady route")
    phase: float = Field(
        0.0, ge=0.0, le=1.0, description="[-] fraction of a step by which the start is shifted"
    )
    time_limit: float = Field(
        400.0, gt=0.0, description="[-] longest motion, in units of sqrt(diameter / gravity)"
    )

    @model_validator(mode="after")
    def _is_sound(self) -> Incline:
        if not 1e-99 < self.diameter * self.density ** (1 / 3) < 1e99:
            raise ValueError(
                f"diameter = {self.diameter:g} m with density = {self.density:g} kg/m3 gives a "
                "mass that is beyond floating point: must be from about 1e-297 to 1e297 kg"
            )
        if self.static_overlap > 0.01:
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft: the grain's weight would press "
                f"it {100 * self.static_overlap:.3g} % of a diameter into the row; must be at "
                f"least {100 * self.mass * self.gravity / self.diameter:.4g} N/m (1 %)"
            )
        if self.steps_per_contact <= self.fewest_steps_per_contact:
            raise ValueError(
                f"steps_per_contact = {self.steps_per_contact:g} is unstable at damping ratio "
                f"{self.contact.zeta:.4g}: must be greater than {self.fewest_steps_per_contact:.3f}"
            )
        return self

    @property
    def particles(self) -> int:
        """Return how many particles a run has, the grain among them."""
        return self.spheres + 1

    @property
    def weight_energy(self) -> float:
        """Return m g d [J], the unit of energy of this system."""
        return self.mass * self.gravity * self.diameter

    @property
    def static_overlap(self) -> float:
        """Return m g / (k d) [-], the relative overlap under the grain's weight."""
        return self.mass * self.gravity / (self.stiffness * self.diameter)

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable in the well.

        In the well the two contacts stand 60 deg apart, so motion normal to the
        row feels 3/2 of one contact's spring and dashpot. LAMMPS damps with the
        half-step velocity: v+ = v (1 - 3 zeta a) - 3/2 a^2 x / dt, x+ = x + dt v+,
        a = omega dt. Jury's criterion on trace and determinant then asks for
        a < 2 (sqrt(zeta^2 + 2/3) - zeta), and a = pi / steps per contact.
        """
        zeta = self.contact.zeta_against_full_mass
        return math.pi / (2.0 * (math.sqrt(zeta * zeta + 2.0 / 3.0) - zeta))


Number = TypeVar("Number", float, NDArray[np.float64])

STEADY_SPEED = 0.48
"""[sqrt(g d)] first speed of the steady route."""

BEHIND_CREST = math.radians(10.0)
"""Where the passage route starts, behind the crest, and the latest place before one to end."""

SETTLED = 8.0
"""Times of the contact's slowest rate, at 0.35 sqrt(g d), for it to settle after a shock."""

SPEED_AFTER_SHOCK = 0.35
"""[sqrt(g d)] along the sphere ahead."""


@dataclass(frozen=True)
class Start:
    """Position [m] and velocity [m/s] of the grain; x from the centre of a fixed sphere."""

    x_m: float
    y_m: float
    vx_m_per_s: float
    vy_m_per_s: float

    def state(self) -> tuple[float, float, float, float]:
        """Return (x, y, vx, vy); raise RequestError when one is not finite."""
        values = tuple(float(value) for value in astuple(self))
        if not all(math.isfinite(value) for value in values):
            raise RequestError(f"start = {values}: must be finite numbers, in m and m/s")
        x, y, vx, vy = values
        return x, y, vx, vy


def start_of(case: Incline, route: str) -> Start:
    """Return the start of a route, ``passage`` or ``steady``."""
    return start_behind_crest(case) if route == "passage" else start_in_well(case)


def start_in_well(case: Incline, speed: float | None = None) -> Start:
    """Return a start touching both spheres of a well, along the tangent of the one ahead.

    ``speed`` [m/s] is 0.48 sqrt(g d) unless given.
    """
    if speed is None:
        speed = STEADY_SPEED * math.sqrt(case.gravity * case.diameter)
    return Start(
        0.5 * case.diameter, math.sqrt(0.75) * case.diameter, speed * math.sqrt(0.75), 0.5 * speed
    )


def start_behind_crest(case: Incline) -> Start:
    """Return the start of the passage route: just the energy of the crest, in balance.

    The overlap at an angle phi from the crest bears m g (3 cos phi - 2), the weight
    less the centrifugal force; the rate of phi follows from
    the energy. The case's phase shifts phi by a fraction of a step's way.
    """
    weight, d = case.mass * case.gravity, case.diameter
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(BEHIND_CREST)) / d)
    phi = BEHIND_CREST + case.phase * rate * case.step
    force = weight * (3.0 * math.cos(phi) - 2.0)
    overlap = force / case.stiffness
    slope = 3.0 * weight * math.sin(phi) / case.stiffness
    r = d - overlap
    spring = 0.5 * case.stiffness * overlap**2
    kinetic = crest_energy(case) - weight * r * math.cos(phi) - spring
    omega = math.sqrt(2.0 * kinetic / case.mass / (r * r + slope * slope))
    beta = phi - math.radians(case.angle)
    return Start(
        r * math.sin(beta),
        r * math.cos(beta),
        omega * (r * math.cos(beta) + slope * math.sin(beta)),
        omega * (slope * math.cos(beta) - r * math.sin(beta)),
    )


def crest_energy(case: Incline) -> float:
    """Return the energy [J] of a grain at rest on the first sphere's crest, pressed in."""
    weight = case.mass * case.gravity
    return weight * _crest_radius(case) + 0.5 * weight**2 / case.stiffness


def overlaps(case: Incline, x: Number, y: Number) -> tuple[Number, Number]:
    """Return the overlaps [m] with the spheres behind and ahead; negative is a gap."""
    d = case.diameter
    behind = d * np.floor(x / d)
    return d - np.hypot(x - behind, y), d - np.hypot(x - behind - d, y)


def energy(case: Incline, x: Number, y: Number, vx: Number, vy: Number) -> Number:
    """Return the mechanical energy [J]: motion, height over the first sphere, springs."""
    tilt = math.radians(case.angle)
    height = y * math.cos(tilt) - x * math.sin(tilt)
    behind, ahead = (np.maximum(overlap, 0.0) for overlap in overlaps(case, x, y))
    springs = 0.5 * case.stiffness * (behind**2 + ahead**2)
    motion = 0.5 * case.mass * (vx * vx + vy * vy)
    total: Number = motion + case.mass * case.gravity * height + springs
    return total


def margin(case: Incline, well: int, x: Number, y: Number, vx: Number, vy: Number) -> Number:
    """Return the energy [J] above that of a grain at rest on the crest after ``well`` wells."""
    return energy(case, x, y, vx, vy) - crest_energy(case) + margin_offset(case, well)


def margin_offset(case: Incline, well: int) -> float:
    """Return the energy [J] by which the crest after ``well`` wells lies below the first one."""
    return case.mass * case.gravity * well * case.diameter * math.sin(math.radians(case.angle))


def end_of(case: Incline, route: str, well: int) -> float:
    """Return the x [m] whose passage ends a well: a crest, or where a passage has settled."""
    return settled_place(case) if route == "passage" else crest_place(case, well)


def crest_place(case: Incline, well: int) -> float:
    """Return the x [m] of the crest after ``well`` wells."""
    tilt = math.radians(case.angle)
    return well * case.diameter - _crest_radius(case) * math.sin(tilt)


def settled_place(case: Incline) -> float:
    """Return the x [m] past the first well where the contact has settled: the passage's end.

    The energy left over the crest is the same there as on it, and the slow way
    to the crest need not be walked.
    """
    tilt = math.radians(case.angle)
    return case.diameter - _crest_radius(case) * math.sin(tilt + settled_before(case))


def settled_before(case: Incline) -> float:
    """Return how far before the crest [rad] the contact has settled after a shock.

    The slowest rate is that of x'' + 2 zeta omega x' + omega^2 x. The hops of contacts near
    critical damping are over by then.
    """
    d, zeta = case.diameter, case.contact.zeta_against_full_mass
    omega = math.sqrt(case.stiffness / case.mass)
    slowest = zeta + math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else 1.0 / (zeta + 1e-9)
    swept = SETTLED * slowest / omega * SPEED_AFTER_SHOCK * math.sqrt(case.gravity / d)
    return min(max(math.pi / 6.0 - math.radians(case.angle) - swept, 0.0), BEHIND_CREST)


def _crest_radius(case: Incline) -> float:
    """Return the distance [m] of the grain from the sphere on whose crest it rests."""
    return case.diameter * (1.0 - case.static_overlap)


class Motion(StrEnum):
    """The outcome of a run. Cut off by time is undecided, never trapped."""

    MOVES_ON = "moves_on"
    TRAPPED = "trapped"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Crests:
    """The crests that the grain passed, one entry each.

    ``time_s`` [s]; ``margin_J`` [J], the mechanical energy above that of a
    grain at rest on the crest; both of shape (crests,).
    """

    time_s: NDArray[np.float64]
    margin_J: NDArray[np.float64]


@dataclass(frozen=True)
class InclineRun:
    """One run of the grain over the row.

    ``margin_J`` [J] is the mechanical energy at the end above that of a grain
    at rest on the crest ahead (in the passage route: the one to pass);
    ``touching`` tells whether the grain was in contact then.
    """

    case: Incline
    motion: Motion
    margin_J: float
    touching: bool
    crests: Crests
    time_s: float
    steps: int
    seconds: float
    provenance: Provenance
    trajectory: Trajectory | None = field(default=None, repr=False)
    ranks: int | None = None

    @property
    def path(self) -> Trajectory:
        """Return the trajectory; raise ValueError for a run that kept none."""
        if self.trajectory is None:
            raise ValueError("this run kept no trajectory")
        return self.trajectory

    @property
    def margin(self) -> float:
        """Return the margin in units of m g d."""
        return self.margin_J / self.case.weight_energy

    @property
    def quantities(self) -> dict[str, float]:
        """Return what the case declares to measure, by name."""
        return {
            "margin_over_mgd": self.margin,
            "moves_on": float(self.motion is Motion.MOVES_ON),
            "touching": float(self.touching),
            "time_s": self.time_s,
            "steps": float(self.steps),
        }


class Judgement(NamedTuple):
    """The outcome of a path, decided at its sample ``row``; margin [J], time [s]."""

    motion: Motion
    margin_J: float
    touching: bool
    crests: Crests
    time_s: float
    row: int


class Looks(NamedTuple):
    """How the samples of a path are judged: (rows,) of the margin [J] over the crest after a well.

    ``end`` is the x [m] that ends a well; ``touching`` tells of a row whether the grain touches.
    """

    margin: Callable[[int], NDArray[np.float64]]
    end: Callable[[int], float]
    touching: Callable[[int], bool]
    allowed: float = 0.0
    """[J] margin up to which a grain that moves back is trapped."""


def judge(case: Incline, route: str, path: Trajectory) -> Judgement:
    """Return the outcome of a path, judged at its samples as LAMMPS's script judges."""
    state = (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)

    def touching(row: int) -> bool:
        return bool(max(overlaps(case, float(path.x_m[row]), float(path.y_m[row]))) > 0.0)

    looks = Looks(
        lambda well: margin(case, well, *state),
        lambda well: end_of(case, route, well),
        touching,
    )
    return judge_by(looks, case, route, path)


def judge_by(looks: Looks, case: Incline, route: str, path: Trajectory) -> Judgement:
    """Return the outcome of a path by looks at its samples.

    A sample past the end of a well counts as its crest; one that moves back with
    less energy than the crest ahead asks for is trapped for good. The path may end as soon
    as that is decided.
    """
    t = path.time_s
    wells = 1 if route == "passage" else case.wells
    passed: list[tuple[float, float]] = []
    motion, row, well = Motion.MOVES_ON, 0, 0
    while motion is Motion.MOVES_ON and well < wells:
        well += 1
        margins = looks.margin(well)
        beyond = path.x_m > looks.end(well)
        back = (path.vx_m_per_s < 0.0) & (margins < looks.allowed)
        decided = np.flatnonzero((beyond | back)[row:])
        if decided.size == 0:
            motion, row = Motion.UNDECIDED, t.size - 1
        else:
            row += int(decided[0])
            short = route == "passage" and margins[row] < 0.0
            motion = Motion.MOVES_ON if beyond[row] and not short else Motion.TRAPPED
        if motion is Motion.MOVES_ON:
            passed.append((float(t[row]), float(margins[row])))
    crests = np.array(passed).reshape(-1, 2)
    return Judgement(
        motion,
        float(margins[row]),
        looks.touching(row),
        Crests(time_s=crests[:, 0], margin_J=crests[:, 1]),
        float(t[row]),
        row,
    )


Route = Literal["passage", "steady"]

NAME = "incline"
"""Name of the case, and of its template."""

NOTES = {
    "plastic": "overdamped and clipped: no tail, no rebound; the one to extrapolate.",
    "source": "e = 1e-20 with the attractive tail, as Harper, Dufek and Breard ran it.",
    "clipped": "critical damping, tail clipped; it rebounds with e = exp(-2) = 0.135.",
}


def values_of(case: Incline, route: Route, every: int | None = None) -> dict[str, Value]:
    """Return a script's values for a run; with ``every``, samples every so many steps."""
    sampled: dict[str, Value] = {} if every is None else {"series_every": every}
    names = ("angle", "stiffness", "steps_per_contact", "gravity", "diameter", "density", "wells")
    return {
        "route": route,
        **case.values(*names, "time_limit"),
        **contact_values(case.contact),
        **case.values("spheres", "phase"),
        **sampled,
    }


def case_of(values: Mapping[str, Any]) -> Incline:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    same = set(Incline.model_fields) - {"contact"}
    return Incline(
        contact=contact_of(values), **{name: values[name] for name in same if name in values}
    )


def scene_of(values: Mapping[str, Any]) -> ContactScene:
    """Return the grain, particle 1, and the row as arrays, with a stage for each well."""
    case, route = case_of(values), values["route"]
    d, tilt = case.diameter, math.radians(case.angle)
    wells = 1 if route == "passage" else case.wells
    return case.scene(
        start_of(case, route).state(),
        np.column_stack([np.arange(case.spheres) * d, np.zeros(case.spheres)]),
        gravity=(case.gravity * math.sin(tilt), -case.gravity * math.cos(tilt)),
        steps=math.ceil(case.time_limit * math.sqrt(d / case.gravity) / case.step),
        every=values.get("series_every"),
        period=case.spheres * d,
        stages=tuple(
            Stage(end_of(case, route, well), crest_energy(case) - margin_offset(case, well))
            for well in range(1, wells + 1)
        ),
        decided=_decided(case, route),
    )


_RANGES = allowed_in(Incline)

TEMPLATE = Template(
    name=NAME,
    variants={
        contact.name: values_of(Incline(contact=contact, steps_per_contact=steps), "steady")
        for contact, steps in ((PLASTIC, 100.0), (SOURCE, 50.0), (CLIPPED, 50.0))
    },
    notes=NOTES,
    scene=scene_of,
    allowed={
        "angle": _RANGES["angle"],  # what is changed the most is checked first
        **_RANGES,
        **contact_allowed(),
        "route": Allowed(words=get_args(Route)),
        # at 10 sqrt(g d) the softest contact is pressed in by a diameter, v sqrt(m / k)
        "speed": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 10}, unit="sqrt(g d)"),
        "start": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 30}, unit="deg"),
        "series_every": COUNT,
    },
)


def job_of(case: Incline, route: Route, every: int | None = None) -> Job:
    """Return the job of a run: in the script of its contact, a custom one in the main script."""
    has_variant = case.contact.name in TEMPLATE.variants
    variant = case.contact.name if has_variant else TEMPLATE.main
    return Job(TEMPLATE, values_of(case, route, every), variant, sampled=every is not None)


def _decided(case: Incline, route: Route) -> Callable[[Table], bool]:
    """Return a function that tests whether a path so far decides the outcome."""
    return lambda table: judge(case, route, path_in(table)).motion is not Motion.UNDECIDED
