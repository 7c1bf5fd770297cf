"""Kratos DEM as an engine of the harness: generated scripts that any Python with Kratos runs.

Kratos is never imported into the harness's own process: it prints, and it may crash.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

from harness.engines.base import Job, Template, Traits, Values
from harness.engines.kratos import scenes
from harness.engines.process import Ended, Limits, last_words
from harness.engines.programs import (
    ASK_SECONDS,
    OF_PYTHON,
    RUNS,
    ScriptedEngine,
    ask_program,
    program_files,
    tree_files,
)
from harness.engines.provenance import Provenance
from harness.engines.scripts import Task
from harness.errors import (
    EngineError,
    EngineMissingError,
    Unsupported,
)
from harness.model.allowed import Allowed
from harness.model.conventions import Rules
from harness.model.scene import Scene

Scheme = Literal["Velocity_Verlet", "Symplectic_Euler"]
"""Kratos's names of its integrators."""

REFERENCE: dict[Scheme, str] = {
    "Velocity_Verlet": "velocity-verlet",
    "Symplectic_Euler": "mfix-euler",
}
"""The reference DEM's names of Kratos's integrators."""

RELEASES = ("10.2.3", "10.4.3", "10.4.4")
"""With which the scripts were tried."""

HELLO = """
from importlib.metadata import PackageNotFoundError, version
import KratosMultiphysics, KratosMultiphysics.DEMApplication
try:
    release = version("KratosMultiphysics")
except PackageNotFoundError:
    release = KratosMultiphysics.KratosGlobals.Kernel.Version()
print("\\nKRATOS", release)
"""


WHERE = 'from importlib.util import find_spec; print(find_spec("KratosMultiphysics").origin)'
"""Tells where Kratos is, without importing it."""


class Kratos(ScriptedEngine):
    """Kratos DEM in worker processes of the Python ``program``, this one unless given.

    ``scheme`` is Kratos's integrator.
    """

    name = "kratos"
    scenes: ClassVar[Any] = scenes
    traits = Traits(
        install_hint=scenes.INSTALL,
        versions=RELEASES,
        integrator=REFERENCE["Velocity_Verlet"],
        microseconds_per_step=10.0,
        digits=15,
        title="Kratos",
    )
    unused_values = frozenset({"interface", "tangential_damping", "rolling", "twisting"})
    """Of contacts: what no law of its takes."""
    allowed: ClassVar[Mapping[str, Allowed]] = {
        "scheme": Allowed(words=("Velocity_Verlet", "Symplectic_Euler"))
    }

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        scheme: Scheme = "Velocity_Verlet",
    ) -> None:
        super().__init__(program, workers, limits)
        self._scheme: Scheme = scheme
        self.opened_with["scheme"] = scheme
        self.traits = replace(type(self).traits, integrator=REFERENCE[scheme])

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the Python that is named, or of this one."""
        return sys.executable if program is None else super().find(program)

    deciding_variables = OF_PYTHON

    @classmethod
    def installed_files(cls, program: Path) -> list[Path]:
        """Return the Python, and the package of Kratos that it would import."""
        reply = ask_program([str(program), "-c", WHERE], ASK_SECONDS)
        if reply is None:
            return []
        package, interpreter = Path(reply.stdout.strip()), program_files(program)
        if reply.returncode != 0 or not package.is_absolute() or not interpreter:
            return []
        return [*interpreter, *tree_files(package.parent)]

    @classmethod
    def deciding(cls, **options: Any) -> Mapping[str, str]:
        """Return the integrator."""
        return {"scheme": options.get("scheme", "Velocity_Verlet")}

    @classmethod
    def context(cls, template: Template, variant: str) -> Mapping[str, Any]:  # noqa: ARG003
        """Return the releases that scripts were tried with."""
        return {"releases": ", ".join(RELEASES)}

    def settings(self, job: Job) -> Values:  # noqa: ARG002
        """Return the integrator, a setting of every script."""
        return {"scheme": self._scheme}

    def rules(self, scene: Scene) -> Rules:
        """Return Kratos's conventions, with the integrator Velocity_Verlet alone."""
        if self._scheme != "Velocity_Verlet":
            raise Unsupported(f"scheme = {self._scheme} runs no contacts: Velocity_Verlet does")
        return super().rules(scene)

    def ask_version(self) -> Provenance:
        """Return Kratos's version; raise EngineMissingError where this Python has none."""
        _, ended = self.ask([self.program, "-c", HELLO])
        words = [line.split(maxsplit=1) for line in ended.said.splitlines()]
        releases = [word[1] for word in words if len(word) == 2 and word[0] == "KRATOS"]
        if not releases or ended.code != 0:
            message = last_words(ended.said)
            raise EngineMissingError(
                self.traits.missing(
                    f"{self.program} has no Kratos with its DEM application{message}"
                )
            )
        return Provenance(self.name, releases[-1], ("DEMApplication",), self.program, "worker")

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run a file of runs."""
        return [self.program, "-u", tasks[0].script.name, RUNS]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        return f"python {task.script.name} {self.words(task)}"

    def error_of(self, ended: Ended, log: str) -> EngineError | None:  # noqa: ARG002
        """Return the error by the end of a process, or None where it ended well."""
        return scenes.error_of(ended)
