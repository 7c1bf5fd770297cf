"""The critical angle as a quantity of a case: several runs for a value, a search in the angle.

Of the incline, and of what is an incline with more to it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from harness.cases.contract import Case, Measured, Reference
from harness.cases.incline.levels import RUNS_BY_PASSAGE, angle_seconds
from harness.cases.incline.system import Incline, Route
from harness.engines.contract import Engine, Job, Output
from harness.engines.traits import Traits
from harness.errors import EngineOutputError, RequestError
from harness.observables.provenance import numbers
from harness.parameters.base import Parameters

if TYPE_CHECKING:
    from harness.cases.incline.angle import CriticalAngle

NO_REBOUND = 1e-6
"""Restitution below which the angle of rigid spheres is the closed form, to 1e-10 deg."""

STARTS = 8
"""Of them the first runs of a passage are no part: two angles, and a root found in two more."""


class Search(Parameters):
    """How a critical angle is searched for, besides the system."""

    method: Literal["passage", "steady"] = Field(
        "passage", description="[-] root of the energy over one well, or smallest moving angle"
    )
    tolerance: float | None = Field(
        None, ge=1e-9, le=1.0,
        description="[deg] resolution of the search; none: 0.001 by passage, 0.005 by steady",
    )  # fmt: skip
    starts: int = Field(
        STARTS, ge=1, le=1000, description="[-] starts within a step, a passage is their mean"
    )


class InclineSearch(Incline, Search):
    """The incline, its angle searched for."""


Searching = Callable[..., "CriticalAngle"]
"""Takes an incline and ``method``, ``tolerance_deg``, ``phases`` and ``engine``."""


class SearchedAngle(Case[InclineSearch]):
    """The critical angle of a case ``of`` inclines, by passage or by steady motion.

    ``kind`` are the parameters of the case with those of :class:`Search`; ``job_of`` makes the
    job of one run by a route, ``search`` finds the angle.
    """

    quantities = numbers(
        critical_angle_deg="[deg] smallest angle at which the grain keeps moving",
        uncertainty_deg="[deg] of the critical angle: range of single runs, and of the search",
        monotone="[-] 1 where no angle above a moving one was trapped, 0 where one was",
        runs="[-] runs behind the critical angle",
    )
    varied = ("angle", "phase")

    def __init__(
        self,
        of: Case[Any],
        kind: type[Any],
        job_of: Callable[[Any, Route], Job],
        search: Searching,
        solvers: tuple[str, ...] = (),
    ) -> None:
        self.of, self.kind, self.job_of, self.search = of, kind, job_of, search
        self.name, self.group, self.template = of.name, of.group, of.template  # type: ignore[misc]
        self.parameters, self.solvers = kind, solvers  # type: ignore[misc]

    @property
    def presets(self) -> Mapping[str, Any]:
        """Return the presets of the case."""
        return {name: self.kind(**dict(values)) for name, values in self.of.presets.items()}

    def source_of(self, preset: str) -> str:
        """Return where the values of a preset were published."""
        return self.of.source_of(preset)

    def job(self, parameters: InclineSearch) -> Job:
        """Return the job of one of the runs, at the angle that the parameters have."""
        return self.job_of(parameters, parameters.method)

    def read(
        self, parameters: InclineSearch, output: Output, traits: Traits
    ) -> Mapping[str, float]:
        """Raise EngineOutputError: one output is no critical angle."""
        raise EngineOutputError("one run gives no critical angle")

    def measure(self, parameters: InclineSearch, engine: Engine) -> Measured:
        """Search for the angle; raise RequestError for a contact that the method cannot measure."""
        try:
            match = self.search(
                parameters,
                method=parameters.method,
                tolerance_deg=parameters.tolerance,
                phases=parameters.starts,
                engine=engine,
            )
        except RequestError as error:
            text = str(error).replace("use method 'steady'", "use --set method=steady")
            raise RequestError(text.replace("method = 'passage'", "--set method=passage")) from None
        values = {
            "critical_angle_deg": match.value_deg,
            "uncertainty_deg": match.uncertainty_deg,
            "monotone": float(match.monotone),
            "runs": float(len(match.samples)),
        }
        return Measured(values, match.provenance, match.seconds, match.ranks)

    def seconds(self, parameters: InclineSearch, rules: Traits | None, solver: str = "") -> float:
        """Return what the runs of a search are expected to take [s]."""
        if rules is None:
            return 0.0
        from harness.cases.incline.angle import passing

        if parameters.method == "steady":
            return angle_seconds(passing(parameters, None), "steady", rules)
        some = (RUNS_BY_PASSAGE - STARTS + parameters.starts) / RUNS_BY_PASSAGE
        return some * angle_seconds(parameters, "passage", rules)

    def references(self, parameters: InclineSearch, traits: Traits) -> Mapping[str, Reference]:
        """Return the angle of rigid spheres, from event to event where a contact rebounds.

        Of another system than the incline only where the case expects that of rigid spheres.
        """
        from harness.cases.incline.closed_forms import rebound
        from harness.solvers.hard_sphere import MOST_RESTITUTION
        from harness.solvers.hard_sphere import critical_angle as of_rigid_spheres
        from harness.theory.incline import critical_angle

        e = rebound(parameters.contact)
        if e <= NO_REBOUND or not self.solvers:
            if not self.of.references(parameters, traits):
                return {}
            return {"critical_angle_deg": Reference(critical_angle(), "closed form")}
        if e > MOST_RESTITUTION:
            return {}
        return {"critical_angle_deg": Reference(of_rigid_spheres(e), "integrated", quick=True)}

    def solve(self, parameters: InclineSearch, solver: str) -> Measured:
        """Return the angle of rigid spheres; RequestError where they fly over the crest."""
        from harness.cases.incline.closed_forms import rebound
        from harness.solvers.hard_sphere import critical_angle

        if solver not in self.solvers:
            return super().solve(parameters, solver)
        return Measured({"critical_angle_deg": critical_angle(rebound(parameters.contact))})
