"""MFiX-DEM as an engine of the harness: the batch solver that a user builds, and its runs.

``scenes.py`` has a scene in MFiX's terms, and reads the motion from what it writes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from harness.engines.base import Job, Traits
from harness.engines.mfix.scenes import (
    KEYWORDS,
    Scheme,
    System,
    motion,
    read_frames,
    rules,
    system_of,
)
from harness.engines.output import Provenance
from harness.engines.process import (
    Ended,
    Limits,
    first_words,
    fresh_folder,
    parallel_map,
    way_of_death,
)
from harness.engines.registry import program_files
from harness.engines.scenes import decided
from harness.engines.scripts import ProgramEngine
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)
from harness.model.conventions import Rules
from harness.model.scene import Motion, Scene

STRETCHES = (8.0, 32.0, 128.0, 512.0)  # [sqrt(d/g)] to run first: MFiX cannot stop early
REFUSAL = re.compile(r"(?im)^.*\berror \d+:.*$|^ *(?:Illegal|Invalid|Required input)\b.*$")


class Mfix(ProgramEngine):
    """The batch solver of MFiX at ``program``, by default ``mfixsolver`` on PATH.

    ``scheme`` is MFiX's integrator. Raise EngineMissingError without a program.
    """

    name = "mfix"
    programs = ("mfixsolver",)
    traits = Traits(
        install_hint="build it (mfix.netl.doe.gov, MFiX 21.3.2, batch solver, "
        "cmake -DVERSION=21.3.2) and give --program mfix=PATH",
        versions=("21.3.2",),
        integrator="mfix-euler",
        microseconds_per_step=32.0,
        digits=7,
        title="MFiX",
    )

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        scheme: Scheme = "EULER",
    ) -> None:
        super().__init__(program, workers, limits)
        self._scheme: Scheme = scheme
        self.deciding_options = {"scheme": scheme}
        self.traits = replace(self.traits, integrator=f"mfix-{scheme.lower().replace('_', '-')}")

    def installed_files(self) -> list[Path]:
        """Return the program and its libraries."""
        return program_files(Path(self.program))

    def ask_version(self) -> Provenance:
        """Return the version; raise EngineMissingError for another program, known by its help."""
        usage, _ = self.ask([self.program, "--help"])
        if not ("mfix.dat" in usage and "<KEYWORD>=<VALUE>" in usage):
            raise EngineMissingError(
                f"--program mfix={self.program} is not an MFiX solver{first_words(usage)}"
            )
        version = self.ask([self.program, "--version"])[0].strip().removeprefix("v")
        if version == "0.0" or not re.match(r"\d+\.\d+", version):
            version = "unversioned"  # a build without -DVERSION calls itself 0.0, or nothing
        return Provenance(self.name, version, (), self.program, "executable", KEYWORDS)

    def rules(self, scene: Scene) -> Rules:
        """Return the conventions by which a scene is run; raise Unsupported."""
        return rules(scene, self._scheme)

    def script_text(self, job: Job) -> str:
        """Return the inputs of a job, one after the other: of its longest run."""
        return "" if job.scene is None else self._systems(self.scene_of(job))[-1].text

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of each scene, a process for each, or the error of its run."""
        return parallel_map(lambda job: self._motion(self.scene_of(job)), jobs, self.workers)

    def _systems(self, scene: Scene) -> list[System]:
        """Return ever longer stretches of a scene; raise Unsupported where it cannot be run."""
        stretches, gravity = {scene.steps}, math.hypot(*scene.gravity)
        if scene.stages and gravity > 0.0:
            unit = math.sqrt(2.0 * scene.bodies[0].radius / gravity) / scene.step
            stretches |= {min(math.ceil(s * unit), scene.steps) for s in STRETCHES}
        return [system_of(scene, steps, self._scheme) for steps in sorted(stretches)]

    def _motion(self, scene: Scene) -> Motion | EngineError:
        """Run ever longer stretches, until a look at the first body ends the run."""
        try:
            for system in self._systems(scene):
                path = self._solve(system)
                if path.stages is None or decided(scene, path.stages):
                    break
        except EngineError as error:
            return error
        return path

    def _solve(self, system: System) -> Motion:
        """Run a system in a fresh folder, where no restart file stops it."""
        with fresh_folder() as folder:
            for file, text in system.inputs.items():
                (folder / file).write_text(text, encoding="utf-8")
            ended = self.start([self.program, "-f", KEYWORDS], folder, self.limits.seconds)
            try:
                return self._read(system, folder, ended)
            except EngineError as error:
                raise error.with_log(system.text + ended.output) from None

    def _read(self, system: System, folder: Path, ended: Ended) -> Motion:
        """Return the motion of a run; raise EngineError for one that failed."""
        wrote, refusal = any(folder.glob("GRAIN_*.vtp")), REFUSAL.search(ended.output)
        if refusal and (ended.code or not wrote) and not ended.timed_out:
            raise EngineInputError(f"MFiX refused its input: {refusal[0].strip()[:160]}")
        if way_of_death(ended.code) == "signal SIGFPE":
            raise EngineNaNError("MFiX died: signal SIGFPE: an overflow, or not a number")
        if error := ended.error(f"MFiX ({self.program})"):
            raise error
        if not wrote:
            raise EngineOutputError(f"MFiX wrote no particles{first_words(ended.output)}")
        return motion(system, read_frames(folder, "GRAIN"), read_frames(folder, "FORCE"))
