"""The case ``columns``: the incline's grain over columns of particles that give way.

Each sphere of the incline's row is the top of a column normal to it, of n particles that move along
its axis; the last one is fixed. The source explains the lower angle of thick layers by the impulse
that such a column takes. But without friction every impulse on the grain is normal to the
sphere ahead: the half of the velocity along it survives the shock whatever the column does. Stiff
columns that damp as the grain's contact does give nothing back, and leave the 10.2078 deg of one
sphere; elastic ones give part of it back, which can only raise the angle.

At rest the grain presses a top with N along the contact's normal, at an angle beta to the column,
which bears L = N cos(beta) besides its own weight. Its contacts are the grain's (0) and those below
its particles 1 ... n - 1; compressions are c_0 = N/k and c_i = (L + i w)/k with the weight
w = m g cos(theta) of a particle along the column. Overlaps are c (overlap law) or T c (deformable
law, T = tridiag(1/2, 1, 1/2)). All is linear in the loads: above the columns' rest without a grain
the energy is (N delta_0 + L s) / 2, with the overlap delta_0 and the sinking s of the top.

A run is judged at the crest ahead by the grain's own energy. What the columns hold is not counted:
at rest on a crest they hold the same each time. That is why a passage goes on to the crest itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from harness import __version__
from harness.cases.base import Check, Level, Value, path_in
from harness.cases.bench import OWN, Bench
from harness.cases.checks import with_digits
from harness.cases.incline import runs
from harness.cases.incline.case import CASE as INCLINE
from harness.cases.incline.case import OverRowCase
from harness.cases.incline.search import Measure
from harness.cases.incline.system import Floats, Incline, OverRow, Route
from harness.engines.base import Engine, Job, Output, Template
from harness.engines.base import Value as ScriptValue
from harness.engines.output import STAGES, Provenance
from harness.engines.process import cores, parallel_map
from harness.errors import EngineOutputError
from harness.model.base import ZERO, allowed_in
from harness.model.law import CONTACTS, SOURCE
from harness.model.law import Law as ContactLaw
from harness.model.scene import STAGE_COLUMNS, Body, Scene
from harness.results.rows import Kind, Tolerance
from harness.theory.chain import LAWS, Law, compliance
from harness.theory.incline import critical_angle as rigid_angle

Inside = Literal["damped", "elastic"]
CHAIN = Provenance("harness", __version__, how="compiled")
MOST_SUNK = 0.1  # [d] of a column under its own weight: more is another geometry
PATH_EVERY, LEAST_PATH = 50, 100  # steps between samples of a path, samples that are compared
LEAST_WAY = 2.0  # [m] along the row: the grain passes three wells, of a diameter of 1 m each
HEIGHTS: dict[int, Level] = {2: "quick", 4: "default", 8: "full"}
# [deg] the source's angle of a tower of n contacts by law, where the impulse rescales the velocity
# kept or lost (`dem-harness impulse`; a test computes them again)
SOURCE_ANGLES: dict[tuple[Law, int], dict[str, float]] = {
    ("overlap", 2): {"kept": 15.956349693142592, "lost": 5.695374311336745},
    ("overlap", 4): {"kept": 17.109059806204137, "lost": 5.014130101617324},
    ("overlap", 8): {"kept": 17.109451943338847, "lost": 5.01390789497349},
    ("deformable", 2): {"kept": 10.933001044140903, "lost": 9.506874102424511},
    ("deformable", 4): {"kept": 17.627495660015608, "lost": 4.725687899522059},
    ("deformable", 8): {"kept": 17.6016086468081, "lost": 4.7398419351556775},
}
SAME_PATH = Tolerance(
    1e-11, reason="columns of one particle are the incline's row: round-off of 1e4 steps"
)
SAME_STEPS: dict[Inside, Tolerance] = {
    "damped": Tolerance(1e-11, reason="the same steps: round-off of 1e3 steps"),
    "elastic": Tolerance(1e-8, reason="the same steps: round-off, which the rattling magnifies"),
}


class Columns(OverRow):
    """One run of a grain over columns of ``n`` particles, in SI units.

    With ``n`` = 1 it is the incline. The contact of the grain with a top is the incline's,
    coefficient by coefficient, whatever ``n``.
    """

    # fmt: off
    spheres: int = Field(4, ge=4, le=100_000, description="[-] columns in the periodic row")
    n: int = Field(4, ge=1, le=100, strict=True, description="[-] particles of a column")
    law: Law = Field(
        "overlap", description="[-] contact law, the source's or that of DEM codes")
    inside: Inside = Field(
        "damped", description="[-] contacts within columns: with the grain's dashpot or without")
    # fmt: on

    counts_springs: ClassVar[bool] = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        case = self.incline  # raises RequestError for what the incline refuses
        pairs = 0.5 * self.n * (self.n - 1) * (2.0 if self.deformable else 1.0)
        if (sunk := pairs * case.static_overlap) > MOST_SUNK:
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft for columns of n = {self.n}: "
                f"under their own weight they would sink by {sunk:.3g} diameters; must be at "
                f"least {self.stiffness * sunk / MOST_SUNK:.4g} N/m ({MOST_SUNK:g} diameters)"
            )
        self.check_step()
        return self

    @property
    def incline(self) -> Incline:
        """Return the incline with the same parameters."""
        return Incline(**{n: v for n, v in self if n in Incline.model_fields})

    @property
    def deformable(self) -> bool:
        """Return whether the source's law couples the contacts of a particle."""
        return self.law == "deformable" and self.n > 1

    @property
    def ends_on_crest(self) -> bool:
        """Return True: up to there columns hold an energy that is not known."""
        return True

    @property
    def stiffest_motion(self) -> tuple[float, float]:
        """Return spring and dashpot [-] of the fastest motion, over those of one contact.

        Both are 4 over columns, the largest sum of a row of D M^-1 D^T (of the contacts of a grain
        in a well: 2 + 1/2 + 1). The deformable law divides the spring by the lowest eigenvalue of
        T, tau = 2 sin^2(pi / (2 (n + 1))): D M^-1 D^T <= 4 - 2 T + 1/2, hence 4.5 / tau - 2.
        """
        if self.n == 1:
            return super().stiffest_motion
        lowest = 2.0 * math.sin(math.pi / (2.0 * (self.n + 1))) ** 2
        return (4.5 / lowest - 2.0 if self.deformable else 4.0), 4.0

    def rest_overlaps(self, force: float, load: float) -> Floats:
        """Return the overlaps [m] at rest of the grain's contact and of those below, (n,)."""
        weights = np.arange(1, self.n) * self.weight * math.cos(self.tilt)
        press = np.concatenate([[force], load + weights]) / self.stiffness
        return np.asarray(compliance(self.n, self.deformable) @ press)


# ---- jobs and runs


def job_of(case: Columns, route: Route = "passage", every: int | None = None) -> Job:
    """Return the job of a run: of one particle that of the incline's row, too."""
    scene = None if case.deformable else scene_of(case, route, every)
    steps, values = runs.expected_steps(case, route), values_of(case, route, every)
    return Job(TEMPLATE, values, sampled=every is not None, scene=scene, steps=steps)


def values_of(case: Columns, route: Route, every: int | None = None) -> dict[str, ScriptValue]:
    """Return the values of the script: those of any row, and the columns'."""
    of_columns = {"n": case.n, "law": case.law, "inside": case.inside}
    return {**runs.row_values(case, route, every), **of_columns}


_DEFAULTS = values_of(Columns(), "passage")
_ALLOWED = {**runs.allowed_values(OverRow, _DEFAULTS), **allowed_in(Columns)}
TEMPLATE = Template("columns", {"": _DEFAULTS}, allowed=_ALLOWED)


def scene_of(case: Columns, route: Route = "passage", every: int | None = None) -> Scene:
    """Return the grain, the first body, over columns, with a stage for each well.

    Its laws are those of the overlap law; under the deformable law the columns rest elsewhere.
    """
    law = ContactLaw(
        normal_stiffness=case.stiffness,
        damping="velocity",
        damping_coefficient=case.contact.dashpot(case.stiffness, case.mass),
        clipped=case.contact.clipped,
    )
    # the grain with each top, and the neighbours within a column
    places = product(range(case.spheres), range(case.n))
    pairs = tuple((i * case.n + j if j else 0, i * case.n + j + 1) for i, j in places)
    return runs.scene_over(
        case, route, every, case.spheres,
        bodies=_bodies(case, route),
        law=law,
        laws={(1, 1): law.replace(damping="none")} if case.inside == "elastic" else {},
        pairs=pairs if case.n > 1 else None,
    )  # fmt: skip


def _bodies(case: Columns, route: Route) -> tuple[Body, ...]:
    x, y, vx, vy, _ = runs.start_of(case, route)
    grain = Body(radius=0.5 * case.diameter, mass=case.mass, type=2, position=(x, y, 0.0),
                 velocity=(vx, vy, 0.0))  # fmt: skip
    guided = grain.replace(type=1, velocity=ZERO, axes=(False, True, False))
    fixed = grain.replace(type=1, velocity=ZERO, motion="frozen")
    force, phi = runs.start_load(case) if route == "passage" else (0.0, 0.0)
    sunk = [sinking(case, force, force * math.cos(phi - case.tilt)), sinking(case)]
    bodies = [grain]
    for i in range(case.spheres):
        depths = case.diameter * np.arange(case.n) + sunk[min(i, 1)]
        places = [(i * case.diameter, -float(depth), 0.0) for depth in depths]
        bodies += [guided.replace(position=place) for place in places[:-1]]
        bodies.append(fixed.replace(position=places[-1]))
    return tuple(bodies)


def sinking(case: Columns, force: float = 0.0, load: float = 0.0) -> Floats:
    """Return how deep the particles of a column at rest lie below touching [m], (n,), top first."""
    below = case.rest_overlaps(force, load)[1:]
    return np.append(np.cumsum(below[::-1])[::-1], 0.0)


def run_at_equal_steps(bench: Bench, case: Columns, route: Route = "passage") -> runs.Run:
    """Return a run at equal steps: by the reference, under the deformable law by the chain's."""
    scene = scene_of(case, route)
    if not case.deformable:
        return runs.read(case, route, bench.reference_output(scene))
    from harness.solvers.chain_stepped import run_columns

    stages = dict(zip(STAGE_COLUMNS, run_columns(scene, case.n).T, strict=True))
    return runs.read(case, route, Output((), CHAIN, {STAGES: stages}, title="the chain solver"))


# ---- the case


class ColumnsCase(OverRowCase[Columns]):
    """The incline's grain on columns of n particles."""

    name = "columns"
    summary = "The incline's grain on columns of n particles, the last one fixed: critical angle."
    parameters = Columns
    presets = {  # noqa: RUF012 - as the base declares it
        "plastic": Columns(),
        **{
            f"{contact.name}, {law}": Columns(contact=contact, law=law)
            for law in LAWS
            for contact in CONTACTS.values()
            if (contact.name, law) != ("plastic", "overlap")
        },
    }

    run_job = staticmethod(job_of)

    def exact(self, parameters: Columns) -> Mapping[str, float]:
        """Return the values of rigid spheres; none for columns that rebound."""
        rebounds = parameters.n > 1 and parameters.inside == "elastic"
        return {} if rebounds else INCLINE.exact(parameters.incline)

    def measure_on(self, bench: Bench, route: Route) -> Measure:
        """Return a function that runs cases; on the bench of this package's solvers by those."""
        if bench.name != OWN:
            return super().measure_on(bench, route)
        at_equal_steps = partial(run_at_equal_steps, bench, route=route)
        return lambda cases: parallel_map(at_equal_steps, cases, cores())

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the path over one particle, and margins at equal steps."""
        return _engine_checks()

    def own_checks(self) -> Iterable[Check]:
        """Return critical angles in the reference, compared with those of the source."""
        return _solver_checks()


def _engine_checks() -> Iterator[Check]:
    single = Columns(n=1, stiffness=1e5, angle=10.6, wells=3)
    jobs = [job_of(single, "steady", PATH_EVERY),
            runs.job_of(single.incline, "steady", PATH_EVERY)]  # fmt: skip
    yield Check(
        setup="n = 1, three wells", quantity="path_difference_m", unit="m",
        measure=partial(_path_difference, single, jobs), expected=0.0, jobs=jobs,
        tolerance=partial(with_digits, SAME_PATH, LEAST_WAY),
        note="largest distance from the path over the incline's row and from the reference's",
    )  # fmt: skip
    # soft and with the source's contact: an external force costs a millisecond a step
    soft = Columns(n=3, contact=SOURCE, steps_per_contact=50.0, stiffness=2e3, angle=10.6)
    yield from (_same_margin(soft.replace(law=law, inside=inside))
                for law, inside in product(LAWS, SAME_STEPS))  # fmt: skip


def _same_margin(case: Columns) -> Check:
    job = job_of(case)
    return Check(
        setup=f"{case.law} law, {case.inside}, n = {case.n}, k = 2e3 N/m", check="equal steps",
        quantity="margin_over_mgd", unit="1", jobs=[job],
        measure=lambda bench: runs.read(case, "passage", bench.output(job)).margin,
        expected=lambda bench: run_at_equal_steps(bench, case).margin,
        tolerance=partial(with_digits, SAME_STEPS[case.inside], 1.0),
    )  # fmt: skip


def _path_difference(case: Columns, jobs: Sequence[Job], bench: Bench) -> float:
    """Return the largest distance [m] of the first path from the other ones, also in time."""
    reference = bench.reference_output(scene_of(case, "steady", PATH_EVERY))
    first, *others = map(path_in, (*map(bench.output, jobs), reference))
    rows = len(first["x_m"])
    if rows < LEAST_PATH or any(len(path["x_m"]) != rows for path in others):
        counts = " and ".join(str(len(path["x_m"])) for path in (first, *others))
        text = f"paths of {counts} samples: must be as many, {LEAST_PATH} at least"
        raise EngineOutputError(text)
    if np.ptp(first["x_m"]) < LEAST_WAY:
        raise EngineOutputError("paths that stay within a well")  # equal as they may be
    units = {"x_m": 1.0, "y_m": 1.0, "time_s": case.diameter / case.unit_of_time}
    errors = [k * np.abs(first[n] - path[n]).max() for path in others for n, k in units.items()]
    return float(np.max(errors))


def _solver_checks() -> Iterator[Check]:
    for (law, height), angles in SOURCE_ANGLES.items():
        for reading, expected in angles.items():
            yield Check(
                setup=f"{law} law, damped, n = {height}, k = 1e5 N/m",
                quantity="critical_angle_deg", unit="deg", check=f"source, velocity {reading}",
                measure=partial(_angle, law, height), expected=expected, kind=Kind.FINDING,
                level=HEIGHTS[height], note=f"{rigid_angle():.4f} deg over one fixed sphere",
            )  # fmt: skip


def _angle(law: Law, height: int, bench: Bench) -> Value:
    case = Columns(n=height, law=law, stiffness=1e5, steps_per_contact=200.0)
    angle = bench.once(CASE.critical_angle, case, bench, starts=4)
    return Value(angle.value, angle.uncertainty)


CASE = ColumnsCase()
