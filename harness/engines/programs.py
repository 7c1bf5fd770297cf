"""Find the programs that a user names: on PATH, or beside this Python."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from harness.errors import RequestError


def find_program(option: str, name: str) -> str:
    """Return the absolute path of a program, on PATH or beside this Python.

    Raise RequestError naming the option, such as ``lmp`` or ``program NAME=``.
    """
    beside = str(Path(sys.executable).parent)
    path = shutil.which(name) or shutil.which(name, path=beside)
    if path is None:
        option += "" if option.endswith("=") else " "
        raise RequestError(
            f"--{option}{name!r}: no such executable; give a path, or a name found on PATH"
        )
    return str(Path(path).absolute())
