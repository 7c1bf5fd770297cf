"""The case ``incline``: one passage, its closed form, and the critical angle as a search."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pydantic import Field

from harness.cases.base import Case, Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.incline import checks
from harness.cases.incline.angle import engine_measure
from harness.cases.incline.closed_form import ONE_SHOCK, expected_angle, rebound
from harness.cases.incline.runs import read
from harness.cases.incline.search import PHASES, CriticalAngle, Measure, prepared, search
from harness.cases.incline.system import Incline, Route, expected_steps, job_of, scene_of
from harness.engines.base import Engine, Job, Output
from harness.errors import RequestError
from harness.model.base import Parameters
from harness.model.law import CONTACTS, PLASTIC, SOURCE
from harness.theory.incline import kept_speed, passage_margin

if TYPE_CHECKING:
    from harness.model.scene import Scene
    from harness.report.content import Discs, Section

HARD_SPHERE = "hard-sphere"


class Search(Parameters):
    """How a critical angle is searched for."""

    # fmt: off
    method: Route = Field(
        "passage", description="[-] root of the energy over one well, or smallest moving angle")
    tolerance: float | None = Field(
        None, ge=1e-9, le=1.0,
        description="[deg] resolution of the search; none: 0.001 by passage, 0.005 by steady")
    starts: int = Field(
        PHASES, ge=1, le=1000, description="[-] starts within a step, a passage is their mean")
    # fmt: on

    def angle(self, measure: Measure, case: Incline) -> CriticalAngle:
        """Return the critical angle of a case; raise RequestError for what it cannot measure."""
        case = prepared(case, self.method)
        return search(measure, case, self.method, self.tolerance, self.starts)


def searched(names: Sequence[str], angle: CriticalAngle) -> dict[str, Value]:
    """Return the quantities of a search, by name."""
    values = {
        "critical_angle_deg": Value(angle.value, angle.uncertainty),
        "uncertainty_deg": Value(angle.uncertainty),
        "monotone": Value(float(angle.monotone)),
        "runs": Value(float(len(angle.runs))),
    }
    return {name: value for name, value in values.items() if name in names}


class InclineCase(Case[Incline]):
    """A grain on a tilted row of fixed spheres: the critical angle, with and without friction."""

    name = "incline"
    group = "incline"
    summary = "A grain on a tilted row of fixed spheres: the critical angle of steady motion."
    parameters = Incline
    search_options = Search
    quantities = (
        Quantity("margin_over_mgd", "1", "energy left after one well, less that of a grain at rest "
                 "on the next crest, in m g d", 0.05),
        Quantity("moves_on", "1", "1 where the grain passes the well, 0 where it is trapped"),
        Quantity("touching", "1", "1 where the grain is in contact at the end"),
        Quantity("time_s", "s", "duration of the motion", lambda p: p.unit_of_time),
        Quantity("steps", "1", "time steps that were taken", lambda p: p.unit_of_time / p.step),
        Quantity("critical_angle_deg", "deg", "smallest angle at which the grain keeps moving",
                 10.0, varies=("angle", "phase")),
        Quantity("uncertainty_deg", "deg", "of the critical angle: range of single runs, and of "
                 "the search", 1e-3, varies=("angle", "phase")),
        Quantity("monotone", "1", "1 where no angle above a moving one was trapped, 0 where one "
                 "was", varies=("angle", "phase")),
        Quantity("runs", "1", "runs behind the critical angle", 10.0, varies=("angle", "phase")),
    )  # fmt: skip
    presets = {  # noqa: RUF012 - as the base declares it
        name: Incline(contact=contact, steps_per_contact=100.0 if contact is PLASTIC else 50.0)
        for name, contact in CONTACTS.items()
    }
    sources = {SOURCE.name: "the source paper, arXiv 2409.13633"}  # noqa: RUF012
    solvers = (HARD_SPHERE,)

    def job(self, parameters: Incline) -> Job:
        """Return the job of one passage."""
        return job_of(parameters, "passage")

    def measure(self, parameters: Incline, output: Output) -> Mapping[str, float]:
        """Return the outcome of one passage."""
        return read(parameters, "passage", output).quantities

    def scene(self, parameters: Incline) -> Scene:
        """Return one passage as a scene."""
        return scene_of(parameters, "passage")

    def exact(self, parameters: Incline) -> Mapping[str, float]:
        """Return the margin and the critical angle of rigid grains, of contacts that allow it."""
        p, values = parameters, dict[str, float]()
        if rebound(p.contact) <= ONE_SHOCK and p.friction == 0.0:
            half = math.degrees(p.half_angle)
            margin = passage_margin(p.angle, kept_speed(half, 0.0) ** 2, half)
            values["margin_over_mgd"] = margin * p.arm / p.diameter
        if (angle := expected_angle(p)) is not None:
            values["critical_angle_deg"] = angle
        return values

    def cost(self, parameters: Incline) -> float:
        """Return the steps of a passage times the bodies, for an estimate of its time."""
        return expected_steps(parameters, "passage") * (parameters.spheres + 1)

    def solve(self, parameters: Incline, solver: str) -> Mapping[str, float]:
        """Follow the grain over rigid spheres from event to event, without friction."""
        if solver not in self.solvers:
            return super().solve(parameters, solver)
        if not parameters.is_plain:
            raise RequestError("hard-sphere: takes no friction, and a grain of the row's size")
        from harness.solvers import hard_sphere

        e = rebound(parameters.contact)
        fate, energy, _, slid, _ = hard_sphere.passage(parameters.angle, e)
        return {
            "margin_over_mgd": energy,
            "moves_on": float(fate == hard_sphere.MOVES_ON),
            "touching": float(slid),
            "critical_angle_deg": hard_sphere.critical_angle(e),
        }

    def search(
        self, names: Sequence[str], parameters: Incline, bench: Bench, **options: Any
    ) -> Mapping[str, Value]:
        """Search for the critical angle; ``options`` are those of :class:`Search`.

        Raise RequestError for a contact that the method cannot measure.
        """
        chosen = Search(**options)
        measure = engine_measure(bench, chosen.method)
        try:
            return searched(names, chosen.angle(measure, parameters))
        except RequestError as error:
            text = str(error).replace("use method 'steady'", "use --set method=steady")
            raise RequestError(text.replace("method = 'passage'", "--set method=passage")) from None

    # ---- verification and report

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return checks.checks(engine)

    def checks_up_to(self, engine: Engine, level: Level) -> Iterable[Check]:
        """Return the checks of an engine up to a level; those of longer ones are not made."""
        return checks.checks(engine, level)

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the sections of a report: angles, their extrapolation, friction."""
        from harness.cases.incline.show import sections

        return sections({name: bench for name, bench in benches.items() if name != OWN})

    def film_job(self, parameters: Incline, frames: int) -> Job:
        """Return the job of steady motion, with so many samples."""
        steps = expected_steps(parameters, "steady")
        return job_of(parameters, "steady", max(1, round(steps / max(1, frames - 1))))

    def discs(self, parameters: Incline, output: Output) -> Discs:
        """Return the grain over the row, tilted as it is, with its speed [m/s]."""
        from harness.cases.incline.show import discs

        return discs(parameters, output)


CASE = InclineCase()
