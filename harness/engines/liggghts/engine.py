"""LIGGGHTS as an engine of the harness.

LIGGGHTS's language is that of LAMMPS of about 2011: no words in conditions, no formats, no
``fix halt``. It is silent about an error where it has no log: every run writes its own.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.base import Traits
from harness.engines.lammps_language import LammpsLanguage
from harness.engines.liggghts import scenes
from harness.engines.output import Provenance
from harness.engines.process import first_words
from harness.engines.programs import program_files
from harness.engines.scripts import Task
from harness.errors import EngineMissingError

MODEL = "hooke/stiffness"
"""The one normal model whose spring and dashpot can be stated."""

_STRETCH = re.compile(r"\n? +Step \n +\d+ \n +\d+ \nLoop time of .*\n")
"""LIGGGHTS's message on each of the short runs of a script, which cannot be turned off."""


class Liggghts(LammpsLanguage):
    """LIGGGHTS-PUBLIC's executable, by default ``liggghts`` on PATH, or ``program``.

    It is started without an MPI launcher. ``workers`` processes run in parallel, by default as
    many as there are cores. Raise RequestError for a program that is not there,
    EngineMissingError where none was named and there is none.
    """

    name = "liggghts"
    scenes: ClassVar[Any] = scenes
    command_name = "liggghts"
    words_compare = False
    programs = ("liggghts",)
    unused_values = frozenset(("interface", "surface_energy"))
    """Of contacts with friction: refused but for one value."""
    traits = Traits(
        install_hint="apt install liggghts (Debian, Ubuntu), or --program liggghts=PATH",
        versions=("LIGGGHTS-PUBLIC 3.8.0",),
        integrator="velocity-verlet",
        microseconds_per_step=2.5,
        lineage="LAMMPS",
    )

    def ask_version(self) -> Provenance:
        """Return the version that ``liggghts -help`` names.

        Raise EngineMissingError when it is not LIGGGHTS, or lacks the contact model.
        """
        output, _ = self.ask([self.program, "-log", "none", "-help"])
        version = re.search(r"^LIGGGHTS \(Version ([^,)\n]+)", output, re.MULTILINE)
        program = f"--program liggghts={self.program}"
        if version is None:
            raise EngineMissingError(
                f"{program} is not LIGGGHTS: its -help names no version{first_words(output)}"
            )
        if MODEL not in output.split():
            raise EngineMissingError(
                f"{program} ({version[1]}) was built without the contact model {MODEL}"
            )
        return Provenance("liggghts", version[1], (), self.program, "executable")

    def installed_files(self) -> list[Path]:
        """Return the program and its libraries."""
        return program_files(Path(self.program))

    def command(self, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``.

        Its screen is a file: without one it crashes as it reports the triangles that it reads.
        """
        return [self.program, "-in", "batch.in", "-log", "none", "-screen", "screen.txt"]

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return the environment of a process."""
        return scenes.environment(folder)

    def log_of(self, folder: Path, index: int) -> str:
        """Return the log of a task without the messages of each short run."""
        return _STRETCH.sub("", super().log_of(folder, index))
