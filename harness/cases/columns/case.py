"""The case ``columns``: its checks, and what it expects."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.base import Case, Check, Level, Quantity, Value
from harness.cases.bench import Bench
from harness.cases.columns.runs import critical_angle, read_run, run_at_equal_steps
from harness.cases.columns.system import Columns, Inside, job_of
from harness.cases.incline.case import ANGLE, Search
from harness.cases.incline.case import CASE as INCLINE
from harness.cases.incline.system import Incline
from harness.cases.incline.system import job_of as incline_job
from harness.cases.plane import path_in
from harness.cases.tower.impulse import READINGS, source_angles
from harness.cases.tower.parameters import LAWS, Law
from harness.engines.base import Engine, Job, Output
from harness.engines.jobs import cores, parallel_map
from harness.errors import EngineOutputError
from harness.model.contact import CONTACTS, SOURCE
from harness.report.content import Section
from harness.results.limits import Limit, limit
from harness.results.rows import Kind, Tolerance
from harness.theory.incline import critical_angle as rigid_angle

if TYPE_CHECKING:
    from harness.theory.chain import Reading

INSIDE: tuple[Inside, ...] = ("damped", "elastic")
PATH_EVERY, LEAST_PATH = 50, 100  # steps between samples of a path, samples that are compared
HEIGHTS: dict[int, Level] = {2: "quick", 4: "default", 8: "full"}
LADDER = (100.0, 200.0, 400.0, 800.0)  # steps per contact time
STIFFNESSES = tuple(10.0 ** (5.5 + 0.5 * i) for i in range(4))  # [N/m]
STIFFNESS_EXPONENTS = (0.5, 1.0)

SAME_PATH = Tolerance(
    absolute=1e-11, reason="columns of one particle are the incline's row: round-off of 1e4 steps"
)
SAME_STEPS: dict[Inside, Tolerance] = {
    "damped": Tolerance(absolute=1e-11, reason="the same steps: round-off of 1e3 steps"),
    "elastic": Tolerance(
        absolute=1e-8, reason="the same steps: round-off, which the rattling magnifies"
    ),
}


def _incline_size(quantity: Quantity[Incline], parameters: Columns) -> float:
    return quantity.size(parameters.incline)


class ColumnsCase(Case[Columns]):
    """The incline's grain on columns of n particles, the last one fixed: critical angle."""

    name = "columns"
    group = "incline"
    summary = "The incline's grain on columns of n particles, the last one fixed: critical angle."
    parameters = Columns
    quantities = tuple(
        replace(quantity, scale=partial(_incline_size, quantity)) for quantity in INCLINE.quantities
    )
    search_options = Search
    presets = {  # noqa: RUF012 - as the base declares it
        "plastic": Columns(),
        **{
            f"{contact.name}, {law}": Columns(contact=contact, law=law)
            for law in ("overlap", "deformable")
            for contact in CONTACTS.values()
            if (contact.name, law) != ("plastic", "overlap")
        },
    }

    def job(self, parameters: Columns) -> Job:
        """Return the job of one passage."""
        return job_of(parameters)

    def measure(self, parameters: Columns, output: Output) -> Mapping[str, float]:
        """Return the outcome of one passage."""
        return read_run(parameters, "passage", output).quantities

    def exact(self, parameters: Columns) -> Mapping[str, float]:
        """Return the values of rigid spheres; none for columns that rebound."""
        rebounds = parameters.n > 1 and parameters.inside == "elastic"
        return {} if rebounds else INCLINE.exact(parameters.incline)

    def search(
        self, names: Sequence[str], parameters: Columns, bench: Bench, **options: Any
    ) -> Mapping[str, Value]:
        """Search for the critical angle; ``options`` as of the incline's."""
        found = critical_angle(parameters, bench, **options)
        values = (
            Value(found.value, found.uncertainty),
            Value(found.uncertainty),
            Value(float(found.monotone)),
            Value(float(len(found.runs))),
        )
        return {name: v for name, v in zip(ANGLE, values, strict=True) if name in names}

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the path over one particle, and margins at equal steps."""
        return engine_checks()

    def own_checks(self) -> Iterable[Check]:
        """Return critical angles in the reference, compared with those of the source."""
        return solver_checks()

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return what to expect of columns."""
        return [Section("Columns: the grain on particles that give way", EXPECTED)]


# ---- checks


def engine_checks() -> Iterator[Check]:
    """Yield the path over one particle, and margins over three at equal steps."""
    yield _one_particle()
    for law, inside in product(LAWS, INSIDE):
        # soft and with the source's contact: an external force costs a millisecond a step
        case = Columns(
            n=3, law=law, inside=inside, contact=SOURCE, steps_per_contact=50.0, stiffness=2e3,
            angle=10.6,
        )  # fmt: skip
        yield Check(
            setup=f"{law} law, {inside}, n = {case.n}, k = 2e3 N/m",
            quantity="margin_over_mgd",
            unit="1",
            check="equal steps",
            measure=partial(_margin, case),
            expected=partial(_reference_margin, case),
            tolerance=SAME_STEPS[inside],
            jobs=[job_of(case)],
        )


def _margin(case: Columns, bench: Bench) -> float:
    return read_run(case, "passage", bench.output(job_of(case))).margin


def _reference_margin(case: Columns, bench: Bench) -> float:
    return run_at_equal_steps(bench, case).margin


def _one_particle() -> Check:
    """Return the check of the path over columns of one particle against that on the incline."""
    case = Columns(n=1, stiffness=1e5, angle=10.6, wells=3)
    jobs = [
        job_of(case, "steady", PATH_EVERY),
        incline_job(case.incline, "steady", PATH_EVERY),
    ]

    def distance(bench: Bench) -> float:
        paths = [path_in(bench.output(job)) for job in jobs]
        rows = min(len(path["x_m"]) for path in paths)
        if rows < LEAST_PATH:
            raise EngineOutputError(f"paths of {rows} samples: {LEAST_PATH} are needed")
        x, y = (paths[0][name][:rows] - paths[1][name][:rows] for name in ("x_m", "y_m"))
        return float(np.hypot(x, y).max())

    return Check(
        setup="n = 1, three wells",
        quantity="path_difference_m",
        unit="m",
        measure=distance,
        expected=0.0,
        tolerance=SAME_PATH,
        jobs=jobs,
        note="largest distance from the path over the incline's row",
    )


def solver_checks() -> Iterator[Check]:
    """Yield angles over columns against the source's, and the limit of stiff ones."""
    yield _stiff_limit()
    for law in LAWS:
        for height, level in HEIGHTS.items():
            for reading in READINGS:
                yield _source_finding(law, height, level, reading)


def _stiff_limit() -> Check:
    """Return the critical angle with the step to zero and then the stiffness to infinity.

    A finding: the order k^(-1/2), which cancels on fixed spheres, does not over columns, and two
    terms from four stiffnesses leave it uncertain by 3e-4 deg.
    """

    def value(bench: Bench) -> Value:
        limits = [bench.once(step_limit, bench, k) for k in STIFFNESSES]
        errors = [one.uncertainty for one in limits]
        inverse = [1.0 / k for k in STIFFNESSES]
        found = limit(inverse, [one.value for one in limits], errors, STIFFNESS_EXPONENTS)
        return Value(found.value, found.uncertainty)

    return Check(
        setup="overlap law, damped, n = 4, stiff limit",
        quantity="critical_angle_deg",
        unit="deg",
        measure=value,
        expected=rigid_angle(),
        kind=Kind.FINDING,
        level="full",
        note="rigid spheres: the closed form of one fixed sphere",
    )


def step_limit(bench: Bench, stiffness: float) -> Limit:
    """Return the critical angle [deg] over four damped particles, with the step to zero."""
    cases = [Columns(stiffness=stiffness, steps_per_contact=steps) for steps in LADDER]
    angles = parallel_map(partial(critical_angle, bench=bench), cases, cores())
    steps, errors = [case.step for case in cases], [angle.mean_error for angle in angles]
    return limit(steps, [angle.value for angle in angles], errors)


def _source_finding(law: Law, height: int, level: Level, reading: Reading) -> Check:
    """Return the angle over damped columns against the source's for as many contacts."""
    case = Columns(n=height, law=law, stiffness=1e5, steps_per_contact=200.0)

    def angle(bench: Bench) -> Value:
        found = bench.once(critical_angle, case, bench, starts=4)
        return Value(found.value, found.uncertainty)

    return Check(
        setup=f"{law} law, damped, n = {height}, k = 1e5 N/m",
        quantity="critical_angle_deg",
        unit="deg",
        check=f"source, velocity {reading}",
        measure=angle,
        expected=lambda _: source_angles(height, law)[reading],
        kind=Kind.FINDING,
        level=level,
        note=f"{rigid_angle():.4f} deg over one fixed sphere",
    )


EXPECTED = """\
The source explains the lower angle of thick layers by deformation: of the impulse on a grain that
falls on a column of n particles, a part alpha(n) is left, and with it the shock. Here the column is
taken literally: each sphere of the row is the top of a column, whose particles move along it and
whose last one is fixed. All impulses on the grain during a shock are normal to the sphere ahead, so
the half of its velocity along that sphere survives, as on fixed ones. Columns that damp as the
grain's contact does give nothing back and leave 10.2078 deg at every n; elastic ones give a part
back, the grain hops, and the angle can only be higher, as with restitution."""

CASE = ColumnsCase()
