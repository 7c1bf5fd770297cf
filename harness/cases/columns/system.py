"""A grain over columns of particles: parameters, rest, routes, scripts, runs, critical angle.

At rest the grain presses a top with N along the contact's normal, which stands at an angle beta to
the column; the column bears L = N cos(beta) besides its own weight. Its contacts are the grain's
(0) and those below its particles 1 ... n - 1; compressions c_0 = N/k, c_i = (L + i w)/k with the
weight w = m g cos(theta) of a particle along the column. Overlaps are c (overlap law) or
T c (deformable law, T = tridiag(1/2, 1, 1/2)). All of it is linear in the loads: above the
columns' rest without a grain, the energy is (N delta_0 + L s) / 2, with the overlap delta_0 and the
displacement s of the top that the load adds (the weights' work and the overlaps they make cancel).

A run is judged at the crest ahead by the grain's own energy. What the columns hold is not counted:
at rest on a crest they hold the same each time, so that the energy left over it has its root where
the grain just comes to rest there. That is why a passage goes on to the crest itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from harness.cases.grain import path_in, run_jobs
from harness.cases.incline.runs import read_by
from harness.cases.incline.system import (
    BEHIND_CREST,
    STEADY_SPEED,
    Incline,
    InclineRun,
    Judgement,
    Looks,
    Motion,
    Number,
    Route,
    Start,
    judge_by,
    margin_offset,
)
from harness.cases.incline.system import TEMPLATE as INCLINE
from harness.cases.incline.system import values_of as values_of_incline
from harness.engines.contract import Engine, Job, Output, Template, Value
from harness.engines.output import Table
from harness.errors import EngineError
from harness.observables.reference import Trajectory
from harness.parameters.allowed import allowed_in
from harness.parameters.law import PLASTIC, contact_of
from harness.parameters.plane_scene import Columns as Held
from harness.parameters.plane_scene import Stage
from harness.parameters.scene import ContactScene
from harness.parameters.tower import Law

if TYPE_CHECKING:
    from harness.cases.incline.angle import CriticalAngle


Inside = Literal["damped", "elastic"]

MOST_SUNK = 0.1
"""[d] by which a column may sink under its own weight: more is another geometry."""


class Columns(Incline):
    """One run of a grain over columns of ``n`` particles, in SI units.

    The fixed spheres of the incline's row are the tops of columns normal to it, whose particles
    move along the column's axis alone and whose last one is fixed: with ``n`` = 1 it is the
    incline. The contact of the grain with a top is the incline's, coefficient by coefficient,
    whatever ``n``.
    """

    n: int = Field(4, ge=1, le=100, strict=True, description="[-] particles of a column")
    law: Law = Field("overlap", description="[-] contact law, the source's or that of DEM codes")
    inside: Inside = Field(
        "damped", description="[-] contacts within columns: with the grain's dashpot or without"
    )
    spheres: int = Field(4, ge=4, le=100_000, description="[-] columns in the periodic row")

    @model_validator(mode="after")
    def _columns_stand(self) -> Columns:
        if self.sunk > MOST_SUNK:
            least = self.stiffness * self.sunk / MOST_SUNK
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft for columns of n = {self.n}: "
                f"under their own weight they would sink by {self.sunk:.3g} diameters; must be at "
                f"least {least:.4g} N/m ({MOST_SUNK:g} diameters)"
            )
        return self

    @property
    def particles(self) -> int:
        """Return how many particles a run has, the grain among them."""
        return self.spheres * self.n + 1

    @property
    def deformable(self) -> bool:
        """Return whether the source's law couples the contacts of a particle."""
        return self.law == "deformable" and self.n > 1

    @property
    def sunk(self) -> float:
        """Return by how much columns sink under their own weight [d], upright."""
        pairs = 0.5 * self.n * (self.n - 1) * (2.0 if self.deformable else 1.0)
        return pairs * self.static_overlap

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable.

        As for the incline, where the spring of the fastest motion is ``lambda`` contacts' and its
        dashpot ``mu`` contacts': Jury's criterion asks for lambda a^2 + 4 zeta mu a < 4 with
        a = omega dt = pi / steps per contact. One sphere: 3/2 both. Columns: 4 both, the largest
        sum of a row of D M^-1 D^T (contacts of a grain in a well: 2 + 1/2 + 1). The deformable law
        divides the spring by the lowest eigenvalue of T, tau = 2 sin^2(pi / (2 (n + 1))):
        D M^-1 D^T <= 4 - 2 T + 1/2, hence lambda = 4.5 / tau - 2.
        """
        zeta = self.contact.zeta_against_full_mass
        if self.n == 1:
            return super().fewest_steps_per_contact
        spring = 4.0
        if self.deformable:
            spring = 4.5 / (2.0 * math.sin(math.pi / (2.0 * (self.n + 1))) ** 2) - 2.0
        dashpot = 2.0 * zeta * 4.0 / spring
        return math.pi / (math.sqrt(dashpot**2 + 4.0 / spring) - dashpot)


class Loaded(NamedTuple):
    """A grain's contact and the column below: overlap [m], sinking of the top [m], energy [J]."""

    overlap: float
    sunk: float
    energy: float


def weight_along(case: Columns) -> float:
    """Return the weight of a particle along its column [N]."""
    return case.mass * case.gravity * math.cos(math.radians(case.angle))


def loaded(case: Columns, force: float, beta: float) -> Loaded:
    """Return the contact and the column under a ``force`` [N] at ``beta`` [rad] to the column."""
    load, k = force * math.cos(beta), case.stiffness
    added, half = force / k, 0.5 if case.deformable else 0.0
    added += half * load / k
    top = _top_compliance(case) * load / k + half * force / k
    return Loaded(added + half * weight_along(case) / k, top, 0.5 * (force * added + load * top))


def sinking(case: Columns, force: float = 0.0, beta: float = 0.0) -> NDArray[np.float64]:
    """Return how deep the particles of a column at rest lie below touching [m], shape (n,).

    From the top down; under the columns' own weight, and a force on the top.
    """
    load, below = force * math.cos(beta), np.arange(1, case.n)
    press = np.concatenate([[force], load + below * weight_along(case)]) / case.stiffness
    overlap = press.copy()
    if case.deformable:
        overlap[1:] += 0.5 * press[:-1]
        overlap[:-1] += 0.5 * press[1:]
    return np.concatenate([np.cumsum(overlap[:0:-1])[::-1], [0.0]])


def crest_radius(case: Columns) -> float:
    """Return the distance [m] of a grain that rests on a crest from the top below it."""
    return case.diameter - _on_crest(case).overlap


def crest_energy(case: Columns) -> float:
    """Return the energy [J] of a grain at rest on the first crest: its height, no springs."""
    top = float(sinking(case)[0]) + _on_crest(case).sunk
    height = crest_radius(case) - top * math.cos(math.radians(case.angle))
    return case.mass * case.gravity * height


def allowed(case: Columns) -> float:
    """Return the margin [J] up to which a grain that moves back is trapped.

    The energy of the grain, without that stored in the column, is not highest at the crest: the
    displacement s of the column's top changes there as the load turns, by
    (compliance m g / k) sin(theta) per radian, which adds m g (s' cos(theta))^2 / 2 d. Four
    times this is allowed.
    """
    weight, tilt = case.mass * case.gravity, math.radians(case.angle)
    turn = _top_compliance(case) * weight / case.stiffness * math.sin(tilt) * math.cos(tilt)
    return 2.0 * weight / case.diameter * turn**2


def _top_compliance(case: Columns) -> int:
    """Return the displacement of a column's top under a load on it, in load / k."""
    return 2 * case.n - 3 if case.deformable else case.n - 1


def _on_crest(case: Columns) -> Loaded:
    return loaded(case, case.mass * case.gravity, math.radians(case.angle))


def start_of(case: Columns, route: str) -> Start:
    """Return the start of a route, ``passage`` or ``steady``, as that of the incline."""
    if route == "passage":
        return start_behind_crest(case)
    speed = STEADY_SPEED * math.sqrt(case.gravity * case.diameter)
    return Start(
        0.5 * case.diameter,
        math.sqrt(0.75) * case.diameter - float(sinking(case)[0]),
        speed * math.sqrt(0.75),
        0.5 * speed,
    )


def start_load(case: Columns) -> tuple[float, float]:
    """Return the force [N] of the grain on the first top where a passage starts, and its beta."""
    phi = _start_angle(case)
    return (case.mass * case.gravity * (3.0 * math.cos(phi) - 2.0), phi - math.radians(case.angle))


def _start_angle(case: Columns) -> float:
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(BEHIND_CREST)) / case.diameter)
    return BEHIND_CREST + case.phase * rate * case.step


def start_behind_crest(case: Columns) -> Start:
    """Return the start of a passage: the energy of the crest, contact and column in balance.

    As :func:`harness.cases.incline.system.start_behind_crest`, the springs' energy being that of
    the contact and the column; the column starts at rest (its speed is of order 1/k).
    """
    weight, tilt, d = case.mass * case.gravity, math.radians(case.angle), case.diameter
    phi, (force, beta) = _start_angle(case), start_load(case)
    here, crest = loaded(case, force, beta), _on_crest(case)
    change = -3.0 * weight * math.sin(phi)  # of the force, with phi
    half = 0.5 if case.deformable else 0.0
    load_change = change * math.cos(beta) - force * math.sin(beta)
    slope = -(change + half * load_change) / case.stiffness
    r = d - here.overlap
    kinetic = weight * (d - crest.overlap - r * math.cos(phi))
    kinetic += weight * (here.sunk - crest.sunk) * math.cos(tilt) + crest.energy - here.energy
    omega = math.sqrt(2.0 * kinetic / case.mass / (r * r + slope * slope))
    return Start(
        r * math.sin(beta),
        r * math.cos(beta) - float(sinking(case)[0]) - here.sunk,
        omega * (r * math.cos(beta) + slope * math.sin(beta)),
        omega * (slope * math.cos(beta) - r * math.sin(beta)),
    )


def crest_place(case: Columns, well: int) -> float:
    """Return the x [m] of the crest after ``well`` wells."""
    tilt = math.radians(case.angle)
    return well * case.diameter - crest_radius(case) * math.sin(tilt)


def margin(case: Columns, well: int, x: Number, y: Number, vx: Number, vy: Number) -> Number:
    """Return the energy [J] above that of a grain at rest on the crest after ``well`` wells."""
    tilt = math.radians(case.angle)
    height = y * math.cos(tilt) - x * math.sin(tilt)
    energy = 0.5 * case.mass * (vx * vx + vy * vy) + case.mass * case.gravity * height
    above: Number = energy - crest_energy(case) + margin_offset(case, well)
    return above


def judge(case: Columns, route: str, path: Trajectory, touching: ArrayLike) -> Judgement:
    """Return the outcome of a path, judged at its samples as LAMMPS's script judges.

    ``touching`` (rows,) is 1 where the grain is in contact.
    """
    state = (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
    touches = np.asarray(touching)
    looks = Looks(
        lambda well: margin(case, well, *state),
        lambda well: crest_place(case, well),
        lambda row: bool(touches[row]),
        allowed(case),
    )
    return judge_by(looks, case, route, path)


NAME = "columns"
"""Name of the case, and of its template."""

OWN = ("n", "law", "inside")
TOUCHING = "touching"
"""Column of an engine's table: 1 where the first particle is in contact."""


def values_of(case: Columns, route: Route, every: int | None = None) -> dict[str, Value]:
    """Return a script's values for a run; with ``every``, samples every so many steps."""
    return {**values_of_incline(case, route, every), **case.values(*OWN)}


def case_of(values: Mapping[str, Any]) -> Columns:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    same = set(Columns.model_fields) - {"contact"}
    return Columns(
        contact=contact_of(values), **{name: values[name] for name in same if name in values}
    )


def scene_of(values: Mapping[str, Any]) -> ContactScene:
    """Return the grain, particle 1, and the columns as arrays, with a stage for each well."""
    case, route = case_of(values), values["route"]
    d, tilt, n = case.diameter, math.radians(case.angle), case.n
    wells = 1 if route == "passage" else case.wells
    depth = np.tile(d * np.arange(n) + sinking(case), (case.spheres, 1))
    if route == "passage":
        depth[0] = d * np.arange(n) + sinking(case, *start_load(case))
    floor = crest_energy(case) + allowed(case)
    along = np.repeat(d * np.arange(case.spheres), n)
    scene = case.scene(
        start_of(case, route).state(),
        np.column_stack([along, -depth.ravel()]),
        gravity=(case.gravity * math.sin(tilt), -case.gravity * math.cos(tilt)),
        steps=math.ceil(case.time_limit * math.sqrt(d / case.gravity) / case.step),
        every=values.get("series_every"),
        period=case.spheres * d,
        stages=tuple(
            Stage(crest_place(case, well), floor - margin_offset(case, well))
            for well in range(1, wells + 1)
        ),
        decided=_decided(case, route),
        columns=Held(n, case.law, case.inside == "damped"),
    )
    number = np.arange(len(along) + 1)
    return scene.with_spheres(fixed=(number > 0) & (number % n == 0))


TEMPLATE = Template(
    name=NAME,
    variants={"": values_of(Columns(contact=PLASTIC, steps_per_contact=100.0), "passage")},
    scene=scene_of,
    allowed={**INCLINE.allowed, **allowed_in(Columns)},
)


def job_of(case: Columns, route: Route, every: int | None = None) -> Job:
    """Return the job of a run."""
    return Job(TEMPLATE, values_of(case, route, every), sampled=every is not None)


def _decided(case: Columns, route: str) -> Callable[[Table], bool]:
    """Return a function that tests whether a path so far decides the outcome."""

    def decided(table: Table) -> bool:
        judgement = judge(case, route, path_in(table), table[TOUCHING])
        return judgement.motion is not Motion.UNDECIDED

    return decided


def read(case: Columns, route: Route, output: Output, every: int | None = None) -> InclineRun:
    """Return the run in an output; errors as for the incline."""

    def judged(looks: Table) -> Judgement:
        return judge(case, route, path_in(looks), looks[TOUCHING])

    return read_by(judged, case, route, output, every)


def run_columns(
    engine: Engine, cases: Sequence[Columns], route: Route, *, every: int | None = None
) -> list[InclineRun | EngineError]:
    """Run the cases and return their results in order, errors in place."""
    return run_jobs(
        engine,
        cases,
        lambda case: job_of(case, route, every),
        lambda case, output: read(case, route, output, every),
    )


def critical_angle(
    case: Columns,
    engine: Engine,
    *,
    method: Route = "passage",
    tolerance_deg: float | None = 1e-3,
    phases: int = 2,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case, whose own angle is ignored.

    ``passage`` or ``steady`` motion, as for the incline. Raise EngineError when a run fails, and
    RequestError when a grain flies where a passage is judged.
    """
    from harness.cases.incline.angle import critical_angle as of_inclines

    return of_inclines(
        case, method=method, tolerance_deg=tolerance_deg, phases=phases, engine=engine,
        run=run_columns,
    )  # fmt: skip
