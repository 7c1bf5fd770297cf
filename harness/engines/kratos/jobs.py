"""One run of a generated script, and what it left."""

from __future__ import annotations

from dataclasses import dataclass

from harness.engines.input_values import Values
from harness.engines.kratos.scripts import Script, words_of


@dataclass(frozen=True)
class Job:
    """A script and the parameters that it is run with."""

    script: Script
    values: Values

    def headed(self, log: str) -> str:
        """Return a log below the command that runs the same again."""
        head = f"# python {self.script.name} {words_of(self.values)}"
        digest = f"# sha256 of the script: {self.script.sha256}"
        return f"{head}\n{digest}\n{log or 'Kratos left no log.'}\n"


@dataclass(frozen=True)
class Output:
    """What a finished run left: its RESULT lines, its series, and the wall time [s] it took."""

    log: str
    series: str
    seconds: float
