"""A test of LAMMPS's ``unittest/granular``: its YAML file, and the script that runs it.

A file holds the commands that build a system, the steps of each segment, and the recorded
positions, velocities, torques and angular velocities at the end of each.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from harness.errors import RequestError

Floats = NDArray[np.float64]
State = Mapping[str, Floats]  # columns of a dump, and "period" of the box [length], NaN without

RECORDED = {"run_pos": ("x", "y", "z"), "run_vel": ("vx", "vy", "vz"),
            "run_torque": ("tqx", "tqy", "tqz"),
            "run_omega": ("omegax", "omegay", "omegaz")}  # fmt: skip
# recorded tables, and the columns of a dump that they are held against
COLUMNS = ("id", "type", *(name for names in RECORDED.values() for name in names), "fx", "fy",
           "fz", "radius", "mass")  # fmt: skip
MEMBER = "dem_harness_member_"  # column that is 1 for the atoms of a group
BLOCKS = ("variables", "pre_commands", "pair_coeff", "post_commands", "run_segments")


@dataclass(frozen=True)
class UpstreamTest:
    """A test: its commands, segments in steps, and what was recorded.

    ``recorded`` maps ``run_pos`` and the like to rows (segment, atom, x, y, z). ``tolerance`` is
    that of upstream's closed form ``model`` after segment ``judged_segment``; NaN without one.
    """

    name: str
    commands: tuple[str, ...]
    segments: tuple[int, ...]
    epsilon: float = 1e-10
    recorded: Mapping[str, Floats] = field(default_factory=dict, compare=False)
    model: str = ""
    tolerance: float = math.nan
    judged_segment: int = 0

    def script(self, newton: str = "off") -> str:
        """Return the LAMMPS input: the driver's commands, each after its number, and dumps."""
        lines = [f"newton {newton}"]
        for number, command in enumerate(self.commands):
            lines += [f'print "COMMAND {number}"', command]
        lines += ['print "COMMAND end"', 'print "TIMESTEP $(dt:%.17g)"']
        lines += [f"variable {MEMBER}{group} atom gmask({group})" for group in self._groups]
        columns = " ".join(self.columns).replace(MEMBER, f"v_{MEMBER}")
        for number, steps in enumerate((0, *self.segments)):
            lines += [
                f"run {steps} post no",
                f"write_dump all custom state.{number} {columns} modify sort id format float %.17g",
            ]
        return "\n".join([*lines, 'print "RESULT verdict = finished"', ""])

    @property
    def columns(self) -> list[str]:
        """Return the columns of its dumps: of the motion, and the members of each group."""
        return [*COLUMNS, *(f"{MEMBER}{group}" for group in self._groups)]

    @property
    def _groups(self) -> list[str]:
        rows = [words for words in map(str.split, self.commands) if words[:1] == ["group"]]
        names = dict.fromkeys(words[1] for words in rows if re.fullmatch(r"\w+", words[1]))
        deleted = {words[1] for words in rows if words[2:3] == ["delete"]}
        return ["all", *(name for name in names if name not in deleted)]


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
    if "pair_style" not in values:
        raise RequestError(f"{file}: pair_style is missing")
    variables, before, coefficients, after, runs = (_lines(values, name, file) for name in BLOCKS)
    segments = " ".join(runs).split()
    if not segments or not all(word.isdigit() for word in segments):
        raise RequestError(
            f"{file}: run_segments = {' '.join(segments)!r}: must be numbers of steps"
        )
    named = [line.partition(" ") for line in variables]
    judged = values.get("analytic_enable", "").strip() in ("yes", "true", "on", "1")
    at = int(_number(values, "analytic_segment", file, -1.0))
    return UpstreamTest(
        name=file.stem,
        commands=(
            f"variable input_dir index {file.parent.resolve()}",
            *(f"variable {name} index {value.strip()}" for name, _, value in named),
            *before,
            f"pair_style {values['pair_style'].strip()}",
            *(f"pair_coeff {text}" for text in coefficients),
            *after,
        ),
        segments=tuple(map(int, segments)),
        epsilon=_number(values, "epsilon", file, 1e-10),
        recorded={name: _rows(values[name], name, file) for name in RECORDED if values.get(name)},
        model=values.get("analytic_model", "").strip() if judged else "",
        tolerance=_number(values, "analytic_tol", file, math.nan) if judged else math.nan,
        judged_segment=at if 0 <= at < len(segments) else len(segments) - 1,
    )


def _lines(values: Mapping[str, Any], name: str, file: Path) -> list[str]:
    """Return the lines of a block without comments."""
    text = values.get(name, "")
    if not isinstance(text, str):
        raise RequestError(f"{file}: {name}: must be lines of text")
    stripped = (re.sub(r"#[^\"']*$", "", line).strip() for line in text.splitlines())
    return [line for line in stripped if line]


def _number(values: Mapping[str, Any], name: str, file: Path, default: float) -> float:
    text = values.get(name) or default
    try:
        return float(text)
    except (TypeError, ValueError):
        raise RequestError(f"{file}: {name} = {text!r}: must be a number") from None


def _rows(text: str, name: str, file: Path) -> Floats:
    """Return rows (segment, atom, x, y, z), shape (M, 5)."""
    lines = [line.split() for line in text.splitlines() if not line.strip().startswith("#")]
    try:
        rows = np.array([[float(word) for word in words] for words in lines]).reshape(-1, 5)
    except ValueError:
        raise RequestError(
            f"{file}: {name}: must be rows of segment, atom and three numbers"
        ) from None
    return rows
