"""The case ``incline``: one passage, its closed form, and the critical angle as a search."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from pydantic import Field

from harness.cases.base import Case, Check, Level, Quantity, Value, path_in
from harness.cases.bench import OWN, Bench
from harness.cases.incline.angle import CriticalAngle
from harness.cases.incline.checks import checks
from harness.cases.incline.closed_form import (
    ONE_SHOCK,
    expected_angle,
    rebound,
)
from harness.cases.incline.routes import expected_steps, job_of, scene_of
from harness.cases.incline.runs import read
from harness.cases.incline.search import PHASES, Measure, engine_measure, prepared, search
from harness.cases.incline.sections import sections
from harness.cases.incline.system import Incline, OverRow, Route
from harness.engines.base import Engine, Job, Output
from harness.errors import RequestError
from harness.model.base import Parameters
from harness.model.law import CONTACTS, PLASTIC, SOURCE
from harness.model.scene import Scene
from harness.report.content import Discs, Section
from harness.theory.incline import kept_speed, passage_margin

HARD_SPHERE = "hard-sphere"
R = TypeVar("R", bound=OverRow)


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


class OverRowCase(Case[R]):
    """A grain on a tilted row: one passage, and the critical angle by a search."""

    group = "incline"
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

    @abstractmethod
    def measure_on(self, bench: Bench, route: Route) -> Measure:
        """Return a function that runs cases of a route on a bench."""

    def measure(self, parameters: R, output: Output) -> Mapping[str, float]:
        """Return the outcome of one passage."""
        return read(parameters, "passage", output).quantities

    def critical_angle(self, parameters: R, bench: Bench, **options: Any) -> CriticalAngle:
        """Return the critical angle [deg]; ``options`` are those of :class:`Search`.

        Raise RequestError for a contact that the method cannot measure.
        """
        chosen = Search(**options)
        method, measure = chosen.method, self.measure_on(bench, chosen.method)
        return search(measure, prepared(parameters, method), method, chosen.tolerance,
                      chosen.starts)  # fmt: skip

    def search(
        self, names: Sequence[str], parameters: R, bench: Bench, **options: Any
    ) -> Mapping[str, Value]:
        """Search for the critical angle, as :meth:`critical_angle` does."""
        try:
            angle = self.critical_angle(parameters, bench, **options)
        except RequestError as error:
            text = str(error).replace("use method 'steady'", "use --set method=steady")
            raise RequestError(text.replace("method = 'passage'", "--set method=passage")) from None
        values = {
            "critical_angle_deg": Value(angle.value, angle.uncertainty),
            "uncertainty_deg": Value(angle.uncertainty),
            "monotone": Value(float(angle.monotone)),
            "runs": Value(float(len(angle.runs))),
        }
        return {name: value for name, value in values.items() if name in names}


class InclineCase(OverRowCase[Incline]):
    """A grain on a tilted row of fixed spheres: the critical angle, with and without friction."""

    name = "incline"
    summary = "A grain on a tilted row of fixed spheres: the critical angle of steady motion."
    parameters = Incline
    presets = {  # noqa: RUF012 - as the base declares it
        name: Incline(contact=contact, steps_per_contact=100.0 if contact is PLASTIC else 50.0)
        for name, contact in CONTACTS.items()
    }
    sources = {SOURCE.name: "the source paper, arXiv 2409.13633"}  # noqa: RUF012
    solvers = (HARD_SPHERE,)

    def job(self, parameters: Incline) -> Job:
        """Return the job of one passage."""
        return job_of(parameters, "passage")

    def scene(self, parameters: Incline) -> Scene:
        """Return one passage as a scene."""
        return scene_of(parameters, "passage")

    def measure_on(self, bench: Bench, route: Route) -> Measure:
        """Return a function that runs cases in the engine of a bench."""
        return engine_measure(bench, route)

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

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return checks(engine)

    def checks_up_to(self, engine: Engine, level: Level) -> Iterable[Check]:
        """Return the checks of an engine up to a level; those of longer ones are not made."""
        return checks(engine, level)

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the sections of a report: the angle, the contacts, friction."""
        return sections([bench for name, bench in benches.items() if name != OWN])

    def film_job(self, parameters: Incline, frames: int) -> Job:
        """Return the job of steady motion, with so many samples."""
        steps = expected_steps(parameters, "steady")
        return job_of(parameters, "steady", max(1, round(steps / max(1, frames - 1))))

    def discs(self, parameters: Incline, output: Output) -> Discs:
        """Return the grain over the row, tilted as it is, with its speed [m/s]."""
        path, d = path_in(output), parameters.diameter
        sine, cosine = math.sin(parameters.tilt), math.cos(parameters.tilt)

        def tilted(along: Any, above: Any) -> tuple[Any, Any]:
            return along * cosine + above * sine, above * cosine - along * sine

        x, y = (path[name] for name in ("x_m", "y_m"))
        places = np.arange(math.floor(float(x.min()) / d), math.ceil(float(x.max()) / d) + 2) * d
        row = np.column_stack([*tilted(places, 0.0 * places), np.full(len(places), 0.5 * d)])
        grain_x, grain_y = tilted(x, y)
        return Discs(
            f"The grain over the bumps at {parameters.angle:g} deg",
            path["time_s"],
            grain_x[:, None],
            grain_y[:, None],
            np.array([0.5 * parameters.grain]),
            fixed=row,
            value=np.hypot(path["vx_m_per_s"], path["vy_m_per_s"])[:, None],
            value_label="speed (m/s)",
        )


CASE = InclineCase()
