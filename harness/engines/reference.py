"""The reference of this package as an engine: it runs any scene, under rules of its own.

So every case whose job carries a scene runs in it, and engines are tried without a code at hand.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Literal, get_args

from harness import __version__
from harness.engines.base import Engine, Job, Traits
from harness.engines.output import Provenance
from harness.engines.process import cores, parallel_map
from harness.errors import EngineError, EngineMemoryError, EngineTimeoutError, RequestError

if TYPE_CHECKING:
    from harness.model.conventions import Rules
    from harness.model.scene import Motion, Scene

Integrator = Literal["velocity-verlet", "mfix-euler", "mfix-adams-bashforth"]
DEFAULT: Integrator = "velocity-verlet"
STEPS_AT_ONCE = 10_000_000  # between two looks at the clock
# of r_i + r_j: a start that just touches is no contact by its last digit, as in MFiX
LEAST_OVERLAP = 1e-15


class Reference(Engine):
    """Equal steps by an ``integrator``: as LAMMPS takes them, or by MFiX's two schemes.

    ``workers`` scenes run side by side, each for at most ``seconds`` [s]. Raise RequestError for an
    integrator that it does not have.
    """

    name = "reference"
    traits = Traits(
        "comes with the harness", (__version__,), microseconds_per_step=0.05, title="reference DEM"
    )
    has_lj_units = True
    can_be_copied = True

    def __init__(
        self,
        integrator: Integrator = DEFAULT,
        *,
        workers: int | None = None,
        seconds: float = 300.0,
    ) -> None:
        if integrator not in get_args(Integrator):
            allowed = ", ".join(get_args(Integrator))
            raise RequestError(f"--integrator {integrator!r}: must be one of {allowed}")
        self.integrator, self._seconds = integrator, seconds
        self.workers = workers or cores()
        self.traits = replace(type(self).traits, integrator=integrator)

    def share_cores(self, processes: int) -> None:
        """Run fewer jobs at a time, as so many processes have this engine."""
        self.workers = max(1, self.workers // processes)

    def identify(self) -> Provenance:
        """Return the version, which is the harness's own, and the integrator."""
        return Provenance(self.name, __version__, how="compiled", integrator=self.integrator)

    def fingerprint(self) -> Mapping[str, Any]:
        """Return the integrator and the compiler; the sources of the harness are in every key."""
        packages = {"numba": version("numba")}
        return {"engine": self.name, "integrator": self.integrator, "packages": packages}

    def rules(self, scene: Scene) -> Rules:  # noqa: ARG002 - the same for all scenes
        """Return the conventions of its steps."""
        from harness.model.conventions import Rules

        return Rules(scheme=self.integrator.replace("-", "_"), least_overlap=LEAST_OVERLAP)

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of each job's scene, or the error of its run, in order."""
        return parallel_map(lambda job: self._motion(self.scene_of(job)), jobs, self.workers)

    def _motion(self, scene: Scene) -> Motion | EngineError:
        from harness.solvers.reference import Simulation

        end = time.monotonic() + self._seconds
        try:
            simulation = Simulation(scene, self.rules(scene))
            while not simulation.over:
                if time.monotonic() > end:
                    raise EngineTimeoutError(
                        f"reference: not finished after {self._seconds:g} s of wall time, at step "
                        f"{simulation.step_number} of {scene.steps}"
                    )
                simulation.advance(STEPS_AT_ONCE)
            return simulation.motion()
        except EngineError as error:
            return error
        except MemoryError:  # the samples of all steps are reserved at the start
            return EngineMemoryError(
                f"reference: out of memory for {scene.steps // scene.every + 1} samples of "
                f"{len(scene.bodies)} bodies"
            )
