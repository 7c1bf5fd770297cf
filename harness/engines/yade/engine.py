"""Yade as an engine of the harness: generated scripts that it runs in its own Python.

A script takes its runs as a list in a JSON file, and writes what each left when it is over.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import ClassVar

from harness.engines.contract import Job
from harness.engines.process import first_text, first_words
from harness.engines.programs import (
    OF_PYTHON,
    RUNS,
    ScriptedEngine,
    program_files,
    tree_files,
    with_libraries,
)
from harness.engines.provenance import Provenance
from harness.engines.scripts import Task
from harness.engines.traits import Traits
from harness.engines.yade import scenes
from harness.errors import EngineError, EngineMissingError
from harness.model.conventions import Rules
from harness.model.motion import Motion
from harness.model.scene import Scene


class Yade(ScriptedEngine):
    """Yade as packaged: a process runs its share of the jobs of a script, one after the other."""

    name = "yade"
    traits = Traits(
        install_hint="apt install yade (Debian, Ubuntu), or --program yade=PATH",
        versions=("2023.02a",),
        integrator="mfix-euler",
        microseconds_per_step=5.0,
        title="Yade",
        caveats=(
            "Against a wall its MindlinPhys takes half the sphere's radius for R*, unless "
            "Ig2_Wall_Sphere_ScGeom is told hertzian=True: forces are then too small by sqrt(1/2).",
            "Its own formulas for tc and en, and for young and en, take m/2 for the effective "
            "mass against a fixed sphere.",
            "With young and en near 0 its search for the dashpot fails: it warns and leaves "
            "the dashpot out, and the contact is elastic.",
            "NewtonIntegrator damps every force by 0.2 unless damping=0 is given.",
            "Coefficients of two materials act in series: each needs twice those of the contact.",
            "CohFrictPhys resists rolling and twisting only with momentRotationLaw=True in both "
            "materials and always_use_moment_law=True in its law; without useIncrementalForm=True "
            "what slid beyond its limits turns back as if it had not.",
            "CohFrictPhys takes twice the sphere's radius for a facet, and the radius for a box: "
            "with one material a facet is a third stiffer, and 8/3 times as stiff in rolling.",
        ),
    )
    programs = ("yade",)
    unused_values = frozenset(
        (
            "interface",
            "room",
            "rolling_damping",
            "twisting_damping",
        )
    )
    """Of contacts with friction: refused unless they say nothing."""
    jinja: ClassVar[Mapping[str, bool]] = {"trim_blocks": False, "keep_trailing_newline": False}

    deciding_variables = (*OF_PYTHON, "YADE_PREFIX")

    @classmethod
    def installed_files(cls, program: Path) -> list[Path]:
        """Return the program, a script of Python, the libraries that it names, and theirs."""
        text = first_text(program, 10_000)
        named = re.search(r"^sys\.path\.insert\(1, *'(/[^']+)/py'\)", text, re.MULTILINE)
        python = re.match(r"#!(/\S+)$", text, re.MULTILINE)
        if (
            named is None
            or python is None
            or not (library := Path(named[1], "libyade.so")).exists()
        ):
            return []
        loaded = with_libraries(library)
        interpreter = program_files(Path(python[1]))
        if not loaded or not interpreter:
            return []
        return [program, *interpreter, *tree_files(library.parent), *loaded]

    def rules(self, scene: Scene) -> Rules:
        """Return the conventions by which a scene is run; raise Unsupported."""
        return scenes.rules(scene)

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of the scene of each job, or the error of its run, in order."""
        return scenes.motions(
            self.program, [self.scene_of(job) for job in jobs], workers=self.workers,
            limits=self.limits, processes=self.processes,
        )  # fmt: skip

    def script_text(self, job: Job) -> str:
        """Return the plain script of a job: of its template, else of its scene."""
        if job.scene is None or self.has_template(job.template):
            task = self.task(job)
            return f"# {self.command_line(task)}\n{task.script.text}"
        return scenes.script(self.scene_of(job))

    def ask_version(self) -> Provenance:
        """Return the version that the program names."""
        output, _ = self.ask([self.program, "--version"])
        named = re.search(r"^Yade version: (\S+)", output, re.MULTILINE)
        if named is None:
            raise EngineMissingError(
                f"{self.program} is not Yade: it names no version{first_words(output)}"
            )
        return Provenance(self.name, named[1], (), self.program, "executable")

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run a list of runs without a window, and end then."""
        return [self.program, "-n", "-x", tasks[0].script.name, RUNS]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        return f"yade -n -x {task.script.name} {self.words(task)}"

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return the environment of a Yade that keeps to its own Python and writes here only."""
        return scenes.environment(folder)
