"""Kratos DEM as an engine of the harness: generated scripts that any Python with Kratos runs.

Kratos is never imported into the harness's own process: it prints, and it may crash.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.base import Traits
from harness.engines.kratos import scenes
from harness.engines.output import Provenance
from harness.engines.process import Ended, last_words
from harness.engines.programs import (
    ASK_SECONDS,
    OF_PYTHON,
    ask_program,
    program_files,
    tree_files,
)
from harness.engines.scripts import ScriptedEngine
from harness.errors import EngineError, EngineMissingError

RELEASES = ("10.2.3", "10.4.3", "10.4.4")  # with which the scripts were tried
HELLO = """
from importlib.metadata import PackageNotFoundError, version
import KratosMultiphysics, KratosMultiphysics.DEMApplication
try:
    release = version("KratosMultiphysics")
except PackageNotFoundError:
    release = KratosMultiphysics.KratosGlobals.Kernel.Version()
print("\\nKRATOS", release)
"""
# prints where Kratos is, without importing it
WHERE = 'from importlib.util import find_spec; print(find_spec("KratosMultiphysics").origin)'


class Kratos(ScriptedEngine):
    """Kratos DEM in worker processes of the Python ``program``, this one unless given."""

    name = "kratos"
    scenes: ClassVar[Any] = scenes
    traits = Traits(
        install_hint=scenes.INSTALL,
        versions=RELEASES,
        integrator="velocity-verlet",
        microseconds_per_step=10.0,
        digits=15,
        title="Kratos",
    )
    # of contacts: what no law of its takes
    unused_values = frozenset({"interface", "tangential_damping", "rolling", "twisting"})
    deciding_variables = OF_PYTHON
    options = ("-u",)

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the Python that is named, or of this one."""
        return sys.executable if program is None else super().find(program)

    def installed_files(self) -> list[Path]:
        """Return the Python, and the package of Kratos that it would import."""
        reply = ask_program([self.program, "-c", WHERE], ASK_SECONDS)
        if reply is None:
            return []
        package, interpreter = Path(reply.stdout.strip()), program_files(Path(self.program))
        if reply.returncode != 0 or not package.is_absolute() or not interpreter:
            return []
        return [*interpreter, *tree_files(package.parent)]

    def ask_version(self) -> Provenance:
        """Return Kratos's version; raise EngineMissingError where this Python has none."""
        _, ended = self.ask([self.program, "-c", HELLO])
        words = [line.split(maxsplit=1) for line in ended.output.splitlines()]
        releases = [word[1] for word in words if len(word) == 2 and word[0] == "KRATOS"]
        if not releases or ended.code != 0:
            message = last_words(ended.output)
            raise EngineMissingError(
                self.traits.missing(
                    f"{self.program} has no Kratos with its DEM application{message}"
                )
            )
        return Provenance(self.name, releases[-1], ("DEMApplication",), self.program, "worker")

    def error_of(self, ended: Ended, log: str) -> EngineError | None:  # noqa: ARG002
        """Return the error by the end of a process, or None where it ended well."""
        return scenes.error_of(ended)
