"""A test of LAMMPS's ``unittest/granular``: its YAML file, and the script that runs it.

A file holds the commands that build a system, how many steps each segment takes, and the recorded
positions, velocities, torques and angular velocities at the end of each. LAMMPS's driver runs it
with newton on and off and compares component by component, to a relative ``epsilon``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from harness.errors import RequestError

Array = NDArray[np.float64]

RECORDED = {
    "run_pos": ("x", "y", "z"),
    "run_vel": ("vx", "vy", "vz"),
    "run_torque": ("tqx", "tqy", "tqz"),
    "run_omega": ("omegax", "omegay", "omegaz"),
}
"""Recorded tables, with the columns of a dump that they are held against."""

BLOCKS = ("pre_commands", "post_commands", "pair_coeff", "variables", "run_segments")

STATE = "state"
"""Dumps of a run: ``state.0`` before the first step, ``state.1`` after the first segment, ..."""

COLUMNS = (
    *("id", "type"),
    *("x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz"),
    *("fx", "fy", "fz", "tqx", "tqy", "tqz", "radius", "mass"),
)
"""Of a dump."""


@dataclass(frozen=True)
class UpstreamTest:
    """One test: commands, segments in steps, and what was recorded.

    ``recorded`` maps ``run_pos`` and the like to rows (segment, atom, x, y, z). ``tolerance`` is
    that of the closed form ``model``, looked at after segment ``at``; NaN without one. ``folder``
    holds further files that it reads.
    """

    name: str
    variables: tuple[tuple[str, str], ...]
    before_pair: tuple[str, ...]
    pair_style: str
    pair_coeff: tuple[str, ...]
    after_pair: tuple[str, ...]
    segments: tuple[int, ...]
    epsilon: float
    recorded: Mapping[str, Array] = field(default_factory=dict, compare=False)
    model: str = ""
    tolerance: float = float("nan")
    at: int = -1
    folder: Path = Path()

    @property
    def judged_segment(self) -> int:
        """Return the segment after which the closed form is looked at: the last unless given."""
        return self.at if 0 <= self.at < len(self.segments) else len(self.segments) - 1

    def script(self, newton: str = "off", finer: int = 1) -> str:
        """Return the LAMMPS input that runs the test, with its step divided by ``finer``."""
        lines = [f"newton {newton}", f"variable input_dir index {self.folder.resolve()}"]
        lines += [f"variable {name} index {value}" for name, value in self.variables]
        lines += [*self.before_pair, f"pair_style {self.pair_style}"]
        lines += [f"pair_coeff {text}" for text in self.pair_coeff]
        lines += self.after_pair
        if finer > 1:
            lines.append(f"timestep $(dt/{finer}:%.17g)")
        lines += ["run 0 post no", _dump(0)]
        for number, steps in enumerate(self.segments, 1):
            lines += [f"run {steps * finer} post no", _dump(number)]
        return "\n".join([*lines, 'print "RESULT verdict = finished"', ""])


def _dump(number: int) -> str:
    return (
        f"write_dump all custom {STATE}.{number} {' '.join(COLUMNS)} "
        "modify sort id format float %.17g"
    )


def read_tests(path: Path) -> list[UpstreamTest]:
    """Return the tests of a file, or of all ``*.yaml`` files of a folder, by name.

    Raise RequestError for a path without any, and for a file that is no test.
    """
    files = sorted(path.glob("*.yaml")) if path.is_dir() else [path]
    if not files or not files[0].is_file():
        raise RequestError(
            f"{path}: must be a test of LAMMPS's unittest/granular (demNN-*.yaml), or their folder"
        )
    return [read_test(file) for file in files]


def read_test(file: Path) -> UpstreamTest:
    """Return the test of a YAML file; raise RequestError, naming file and key, for another."""
    try:
        # every value as text: a driver in C++ reads them so
        values = yaml.load(file.read_text("utf-8"), Loader=yaml.BaseLoader)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RequestError(f"{file}: cannot be read: {' '.join(str(error).split())}") from None
    if not isinstance(values, dict):
        raise RequestError(f"{file}: must be a mapping of keys, as unittest/granular has them")
    blocks = {name: _lines(values, name, file) for name in BLOCKS}
    if "pair_style" not in values:
        raise RequestError(f"{file}: pair_style is missing")
    segments = " ".join(blocks["run_segments"]).split()
    if not segments or not all(word.isdigit() for word in segments):
        raise RequestError(
            f"{file}: run_segments = {' '.join(segments)!r}: must be numbers of steps"
        )
    judged = values.get("analytic_enable", "").strip() in ("yes", "true", "on", "1")
    return UpstreamTest(
        name=file.stem,
        variables=tuple(
            (name, value.strip())
            for name, _, value in (line.partition(" ") for line in blocks["variables"])
        ),
        before_pair=blocks["pre_commands"],
        pair_style=values["pair_style"].strip(),
        pair_coeff=blocks["pair_coeff"],
        after_pair=blocks["post_commands"],
        segments=tuple(map(int, segments)),
        epsilon=_number(values, "epsilon", file, 1e-10),
        recorded={name: _rows(values[name], name, file) for name in RECORDED if values.get(name)},
        model=values.get("analytic_model", "").strip() if judged else "",
        tolerance=_number(values, "analytic_tol", file, np.nan) if judged else np.nan,
        at=int(_number(values, "analytic_segment", file, -1.0)),
        folder=file.parent,
    )


def _lines(values: Mapping[str, Any], name: str, file: Path) -> tuple[str, ...]:
    text = values.get(name, "")
    if not isinstance(text, str):
        raise RequestError(f"{file}: {name}: must be lines of text")
    return tuple(line.strip() for line in text.splitlines() if line.strip())


def _number(values: Mapping[str, Any], name: str, file: Path, default: float) -> float:
    text = values.get(name) or default
    try:
        return float(text)
    except ValueError:
        raise RequestError(f"{file}: {name} = {text!r}: must be a number") from None


def _rows(text: str, name: str, file: Path) -> Array:
    """Return rows (segment, atom, x, y, z), shape (M, 5)."""
    try:
        rows = np.array([[float(word) for word in line.split()] for line in text.splitlines()])
    except ValueError:
        rows = np.zeros(0)
    if rows.ndim != 2 or rows.shape[1] != 5:
        raise RequestError(f"{file}: {name}: must be rows of segment, atom and three numbers")
    return rows
