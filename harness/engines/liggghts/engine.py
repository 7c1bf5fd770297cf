"""LIGGGHTS as an engine of the harness: its command and its quirks.

LIGGGHTS's language is that of LAMMPS of about 2011: no words in conditions, no formats, no
``fix halt``. It is silent about an error where it has no log: every run writes its own.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from harness.engines.lammps.language import LammpsLanguage
from harness.engines.liggghts.contacts import CONTACTS
from harness.engines.process import first_words
from harness.engines.script import Task
from harness.engines.traits import Traits
from harness.errors import EngineMissingError
from harness.observables.provenance import Provenance

MODEL = "hooke/stiffness"
"""The one normal model whose spring and dashpot can be stated."""

ALONE = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
"""Open MPI for one process: no daemon that outlives it, no search for networks (0.3 s a start)."""

_STRETCH = re.compile(r"\n? +Step \n +\d+ \n +\d+ \nLoop time of .*\n")
"""What LIGGGHTS says of each of the short runs of a script, which cannot be turned off."""


class Liggghts(LammpsLanguage):
    """LIGGGHTS-PUBLIC's executable, ``liggghts`` on PATH unless ``program`` says otherwise.

    It is started without an MPI launcher. ``workers`` processes run side by side, as many as
    there are cores unless told otherwise. Raise RequestError for a program that is not there,
    EngineMissingError where none was named and there is none.
    """

    name = "liggghts"
    command_name = "liggghts"
    words_compare = False
    programs = ("liggghts",)
    self_contained = True
    unused_values = frozenset(("interface", "surface_energy"))
    """Of contacts with friction: refused but for one value."""
    traits = Traits(
        install_hint="apt install liggghts (Debian, Ubuntu), or --program liggghts=PATH",
        versions=("LIGGGHTS-PUBLIC 3.8.0",),
        integrator="velocity-verlet",
        microseconds_per_step=2.5,
        lineage="LAMMPS",
        contact_models=CONTACTS,
        caveats=(
            "In two dimensions (dimension 2) its particles are discs of unit height: 3/2 of the "
            "mass of spheres of 1 m.",
            "Clipping the tail (limitForce) is an option, off by default.",
            "Model hooke refuses restitutions up to 0.05, and its stiffness grows with the "
            "effective mass to the power 1/5: take hooke/stiffness.",
            "Words cannot be compared in its scripts, and errors are silent without a log.",
        ),
    )

    def ask_version(self) -> Provenance:
        """Return the version that ``liggghts -help`` names.

        Raise EngineMissingError when it is not LIGGGHTS, or lacks the contact model.
        """
        said, _ = self.ask([self.program, "-log", "none", "-help"])
        version = re.search(r"^LIGGGHTS \(Version ([^,)\n]+)", said, re.MULTILINE)
        program = f"--program liggghts={self.program}"
        if version is None:
            raise EngineMissingError(
                f"{program} is not LIGGGHTS: its -help names no version{first_words(said)}"
            )
        if MODEL not in said.split():
            raise EngineMissingError(
                f"{program} ({version[1]}) was built without the contact model {MODEL}"
            )
        return Provenance("liggghts", version[1], (), self.program, "executable")

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``."""
        return [self.program, "-in", "batch.in", "-log", "none", "-screen", "none"]

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return the environment of a process.

        Open MPI keeps its session files in TMPDIR, and leaves them when it is killed.
        """
        return {**os.environ, **ALONE, "TMPDIR": str(folder)}

    def log_of(self, folder: Path, index: int) -> str:
        """Return the log of a task without what is said of each short run."""
        return _STRETCH.sub("", super().log_of(folder, index))
