"""The process that holds LAMMPS in-process, so that its death is not the harness's.

Started as ``python -m harness.engines.lammps.worker MEMORY_BYTES``. It reads
one order a line on stdin and writes one answer a line on stdout, both JSON.
Whatever LAMMPS or MPI prints goes to stderr. It imports as little as it can:
a start is paid per core.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from pathlib import Path
from typing import Any, TextIO

from harness.engines.lammps.external_forces import FORCES, run_with_force
from harness.engines.lammps.workers import open_lammps
from harness.files import end_with

FOLDER = ".dem-harness-"
"""How the name of a runner's temporary folder begins; each worker has a folder in it."""


def main() -> None:
    """Serve orders until stdin ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    _limit_memory(int(sys.argv[1]))
    end_with(os.getppid(), _clear_away)
    instance: Any = None
    try:
        instance = open_lammps("hello.log")
    except (ImportError, OSError) as error:
        _answer(answers, {"missing": str(error)})
        return
    _unlink_shared_memory()
    instance.command("log none")
    greeting = Path("hello.log").read_text(encoding="utf-8")
    _answer(answers, {"greeting": greeting, "packages": list(instance.installed_packages)})
    for line in sys.stdin:
        order = json.loads(line)
        try:
            _execute(instance, order)
            _answer(answers, {})
        except Exception as error:
            _answer(answers, {"error": str(error)})
            instance = open_lammps()
    _clear_away()


def _execute(lammps: Any, order: dict[str, Any]) -> None:
    """Run one script from a clean slate: variables of an earlier run would shadow defaults."""
    lammps.command(f'log "{order["log"]}"')
    lammps.command("clear")
    for name in order["forget"]:
        lammps.command(f"variable {name} delete")
    for name, value in order["variables"].items():
        lammps.command(f'variable {name} index "{value}"')
    if order["variables"].get("law") in FORCES:
        run_with_force(lammps, Path(order["script"]), order["variables"])
    else:
        lammps.file(order["script"])
    lammps.command("log none")


def _answer(stream: TextIO, answer: dict[str, Any]) -> None:
    stream.write(json.dumps(answer) + "\n")
    stream.flush()


def _limit_memory(limit: int) -> None:
    """Bound the address space, so that a runaway run fails here and not on the machine."""
    import resource

    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _unlink_shared_memory() -> None:
    """Take the name from MPICH's shared memory, which no other process will ask for.

    It stays mapped. MPICH itself unlinks it in MPI_Finalize only, and a worker is killed
    in the end: a megabyte of /dev/shm would be left of each.
    """
    with contextlib.suppress(OSError):
        for handle in Path("/proc/self/fd").iterdir():
            with contextlib.suppress(OSError):
                target = handle.readlink()
                if target.name.startswith("mpich_shm_"):
                    target.unlink()


def _clear_away() -> None:
    """Remove the runner's folder: who outlives the harness is the last that can."""
    import shutil

    with contextlib.suppress(FileNotFoundError):  # another worker was first
        folder = Path.cwd().parent
        if folder.name.startswith(FOLDER):
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
