"""Yade as an engine of the harness: generated scripts that it runs in its own Python.

A script takes its runs as a list in a JSON file, and writes the results of each.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.base import Traits
from harness.engines.output import Provenance
from harness.engines.process import first_text, first_words
from harness.engines.programs import OF_PYTHON, program_files, tree_files, with_libraries
from harness.engines.scripts import ScriptedEngine
from harness.engines.yade import scenes
from harness.errors import EngineMissingError


class Yade(ScriptedEngine):
    """Yade as packaged: a process runs its share of the jobs of a script, one after the other."""

    name = "yade"
    scenes: ClassVar[Any] = scenes
    traits = Traits(
        install_hint="apt install yade (Debian, Ubuntu), or --program yade=PATH",
        versions=("2023.02a",),
        integrator="mfix-euler",
        microseconds_per_step=5.0,
        title="Yade",
    )
    programs = ("yade",)
    command_name = "yade -n -x"
    options = ("-n", "-x")  # without a window, and to end after a script
    unused_values = frozenset(
        (
            "interface",
            "room",
            "rolling_damping",
            "twisting_damping",
        )
    )
    """Of contacts with friction: refused unless they say nothing."""

    deciding_variables = (*OF_PYTHON, "YADE_PREFIX")

    def installed_files(self) -> list[Path]:
        """Return the program, a script of Python, the libraries that it names, and theirs."""
        program = Path(self.program)
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

    def ask_version(self) -> Provenance:
        """Return the version that the program names."""
        output, _ = self.ask([self.program, "--version"])
        named = re.search(r"^Yade version: (\S+)", output, re.MULTILINE)
        if named is None:
            raise EngineMissingError(
                f"{self.program} is not Yade: it names no version{first_words(output)}"
            )
        return Provenance(self.name, named[1], (), self.program, "executable")

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return the environment of a Yade that keeps to its own Python and writes here only."""
        return scenes.environment(folder)
