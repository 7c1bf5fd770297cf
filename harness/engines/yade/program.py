"""Find Yade, and ask it who it is."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from harness.engines.process import first_words
from harness.engines.programs import find_program
from harness.engines.yade.batch import environment
from harness.errors import EngineMissingError

VERSION_SECONDS = 60.0


def find(program: str | None, install_hint: str) -> str:
    """Return the path of Yade: that of the program named, or of the one on PATH.

    Raise RequestError for a program that is not there, EngineMissingError, which says how to
    obtain Yade, when none is named nor found.
    """
    if program is not None:
        return find_program("yade", program)
    found = shutil.which("yade")
    if found is None:
        raise EngineMissingError(f"no Yade on PATH: {install_hint}")
    return str(Path(found).absolute())


def version(program: str) -> str:
    """Return the version that a program names; raise EngineMissingError when it is not Yade's."""
    with tempfile.TemporaryDirectory(prefix="dem-harness-") as home:
        try:
            answer = subprocess.run(
                [program, "--version"],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=VERSION_SECONDS,
                check=False,
                env=environment(os.environ, Path(home)),
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise EngineMissingError(f"{program} does not run: {error}") from None
    said = (answer.stdout + answer.stderr).decode(errors="replace")
    named = re.search(r"^Yade version: (\S+)", said, re.MULTILINE)
    if named is None:
        raise EngineMissingError(f"{program} is not Yade: it names no version{first_words(said)}")
    return named[1]
