"""Start ESyS-Particle under an MPI launcher: one master that reads the script, one worker.

A process runs one model: a second one in the same process waits for ever.
"""

from __future__ import annotations

import os
import shlex
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from harness.engines.esys.scripts import SERIES, Script
from harness.engines.input_values import Value
from harness.engines.process import Ended, Limits, Processes, last_words, text_of
from harness.engines.programs import find_program
from harness.errors import EngineCrashError, EngineMissingError, RequestError
from harness.observables.provenance import Provenance

PROGRAM = "esysparticle"
LAUNCHERS = ("mpirun.openmpi", "mpirun")
"""Debian's ESyS-Particle belongs to Open MPI, whose launcher has this name there."""

RANKS = ("-np", "2")

OPEN_MPI = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
"""Runs go side by side on few cores: a rank that waits gives way, and none is bound to a core."""

TEMPORARY = ("OMPI_MCA_orte_tmpdir_base", "OMPI_MCA_btl_vader_backing_directory")
"""Where Open MPI keeps its files; a process that is killed leaves them, in its folder here."""

AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
"""In a container there is nobody else."""

GREETING = """from esys.lsm import LsmMpi
sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
print("RESULT version =", sim.getLsmVersion())
sim.exit()
"""
GREETING_SECONDS = 60.0


class Finished(NamedTuple):
    """What a run left: how it ended, and the text of its series."""

    ended: Ended
    series: str


class Launcher:
    """Runs scripts in folders of their own under limits of time and memory.

    Raise EngineMissingError with ``install_hint`` where the program or a launcher is not here,
    RequestError for one that is named and not found.
    """

    def __init__(
        self, program: str | None, launcher: str | None, limits: Limits, install_hint: str
    ) -> None:
        self.program = _program(program, install_hint)
        self._launcher = _launcher(launcher)
        self.limits = limits
        self._processes = Processes()
        self._folder = tempfile.TemporaryDirectory(prefix="dem-harness-")

    def identify(self) -> Provenance:
        """Return the version that a short run names.

        Raise EngineMissingError when there is none, as with another MPI's launcher.
        """
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        ended = self._execute("version.py", GREETING, [], folder, GREETING_SECONDS)
        found = [line for line in ended.said.splitlines() if line.startswith("RESULT version = ")]
        how = shlex.join(self._launcher)
        if len(found) != 1:
            reason = "it gave no answer" if ended.timed_out else f"exit status {ended.code}"
            raise EngineMissingError(
                f"{how} does not run {self.program}: {reason}{last_words(ended.said)}; it needs "
                "the launcher of the Open MPI that it was built with"
            )
        version = found[0].removeprefix("RESULT version = ")
        return Provenance("esys", version, (), self.program, Path(self._launcher[0]).name)

    def run(self, script: Script, values: Mapping[str, Value]) -> Finished:
        """Run a script to its end and return what it left; its folder is removed.

        Raise EngineCrashError after :meth:`close`.
        """
        if self._processes.closed:
            raise EngineCrashError("ESyS-Particle was closed")
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        words = script.arguments({**values, "series": SERIES})
        try:
            ended = self._execute(script.name, script.text, words, folder, self.limits.seconds)
            return Finished(ended, text_of(folder / SERIES))
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._processes.close()
        self._folder.cleanup()

    def _execute(
        self, name: str, text: str, words: Sequence[str], folder: Path, seconds: float
    ) -> Ended:
        (folder / name).write_text(text, encoding="utf-8")
        environment = {**os.environ, **OPEN_MPI, **dict.fromkeys(TEMPORARY, str(folder))}
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            environment |= AS_ROOT
        command = [*self._launcher, *RANKS, self.program, name, *words]
        ended = self._processes.run(
            command, folder, seconds=seconds, memory=self.limits.memory, environment=environment
        )
        # the launcher frames what it says in dashes
        said = (line for line in ended.said.splitlines() if line.strip("-"))
        return replace(ended, said="\n".join(said) + "\n")


def _program(name: str | None, install_hint: str) -> str:
    if name is not None:
        return find_program("esys", name)
    try:
        return find_program("esys", PROGRAM)
    except RequestError:
        raise EngineMissingError(f"ESyS-Particle is not here: {install_hint}") from None


def _launcher(words: str | None) -> list[str]:
    """Return the launcher's words, its program as a path."""
    if words is not None:
        first, *options = shlex.split(words) or [""]
        return [find_program("mpirun", first), *options]
    for name in LAUNCHERS:
        path = shutil.which(name)
        if path is not None:
            return [path]
    raise EngineMissingError(
        "ESyS-Particle needs the launcher of Open MPI, mpirun.openmpi: apt install openmpi-bin"
    )
