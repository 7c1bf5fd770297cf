"""A test of LAMMPS's ``unittest/granular``: its YAML file, the script that runs it, and a run.

A file has the commands that build a system, the steps of each segment, and the recorded
positions, velocities, torques and angular velocities at the end of each.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from harness.engines.lammps_language import error_of
from harness.engines.process import Limits, Processes, fresh_folder, text_of
from harness.engines.registry import program_words
from harness.errors import EngineNaNError, EngineOutputError, RequestError

Floats = NDArray[np.float64]
State = Mapping[str, Floats]  # columns of a dump, and "period" of the box [length], NaN without

RECORDED = {"run_pos": ("x", "y", "z"), "run_vel": ("vx", "vy", "vz"),
            "run_torque": ("tqx", "tqy", "tqz"),
            "run_omega": ("omegax", "omegay", "omegaz")}  # fmt: skip
# recorded tables, and the columns of a dump with the same quantity
COLUMNS = ("id", "type", *(name for names in RECORDED.values() for name in names), "fx", "fy",
           "fz", "radius", "mass")  # fmt: skip
MEMBER = "dem_harness_member_"  # column that is 1 for the atoms of a group


@dataclass(frozen=True)
class UpstreamTest:
    """A test: its commands, segments in steps, and its record.

    ``recorded`` maps ``run_pos`` and the like to rows (segment, atom, x, y, z), shape (M, 5).
    ``tolerance`` is that of upstream's closed form ``model`` after segment ``judged_segment``; NaN
    without one.
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
        members = [name for name in self.columns if name.startswith(MEMBER)]
        lines += [f"variable {name} atom gmask({name.removeprefix(MEMBER)})" for name in members]
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
        groups = [words for words in map(str.split, self.commands) if words[:1] == ["group"]]
        names = dict.fromkeys(["all", *(w[1] for w in groups if re.fullmatch(r"\w+", w[1]))])
        deleted = {words[1] for words in groups if words[2:3] == ["delete"]}
        return [*COLUMNS, *(f"{MEMBER}{name}" for name in names if name not in deleted)]


@dataclass(frozen=True)
class RunOutput:
    """The dump before the first step and after each segment, the log, and the step [time]."""

    states: tuple[State, ...]
    log: str
    timestep: float


def run_test(
    test: UpstreamTest, lmp: str, *, newton: str = "off", limits: Limits | None = None
) -> RunOutput:
    """Run a test once; ``newton`` is on or off. Raise EngineError for a run that failed."""
    bounds = limits or Limits()
    with fresh_folder() as folder:
        (folder / "in.lmp").write_text(test.script(newton), encoding="utf-8")
        options = ["-in", "in.lmp", "-log", "log.lammps", "-echo", "log", "-nocite"]
        ended = Processes().run([*program_words("lmp", lmp), *options], folder,
                                seconds=bounds.seconds, memory=bounds.memory)  # fmt: skip
        log = text_of(folder / "log.lammps")
        if (error := error_of(ended, log)) is not None:
            raise error.with_log(f"{log}\n{ended.output}")
        numbers = range(len(test.segments) + 1)
        states = tuple(read_state(folder / f"state.{n}", test.columns) for n in numbers)
    step = re.search(r"^TIMESTEP (\S+)$", log, flags=re.MULTILINE)
    if step is None:
        raise EngineOutputError("LAMMPS's log has no timestep")
    return RunOutput(states, log, float(step[1]))


def read_state(file: Path, columns: Sequence[str] = COLUMNS) -> State:
    """Return the columns of a dump, (N,) each.

    Raise EngineError for a dump that is cut or has a value that is not finite.
    """
    try:
        lines = file.read_text("utf-8").splitlines()
        rows = np.array([[float(word) for word in line.split()] for line in lines[9:]])
        box = np.array([[float(word) for word in line.split()] for line in lines[5:8]])
        rows = rows.reshape(len(lines) - 9, len(columns))
    except (OSError, ValueError):
        raise EngineOutputError(f"LAMMPS left no {file.name} that can be read") from None
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"LAMMPS wrote {file.name} with a value that is not a number")
    periodic = [flags == "pp" for flags in lines[4].split()[-3:]]
    length = box[:, 1] - box[:, 0] if box.shape[1] == 2 else np.inf  # of a box that is not tilted
    state = dict(zip(columns, rows.T, strict=True))
    return {**state, "period": np.where(periodic, length, np.nan)}


# ---- files


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
        return _test(yaml.load(file.read_text("utf-8"), Loader=yaml.BaseLoader), file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RequestError(f"{file}: cannot be read: {' '.join(str(error).split())}") from None
    except (ValueError, AttributeError, TypeError) as error:
        raise RequestError(f"{file}: must be a test of unittest/granular: {error}") from None


def _test(values: Any, file: Path) -> UpstreamTest:
    if not isinstance(values, dict):
        raise ValueError("it has no keys")

    def lines(name: str) -> list[str]:
        """Return the lines of a block without comments."""
        text = values.get(name, "").splitlines()
        return list(filter(None, (re.sub(r"#[^\"']*$", "", line).strip() for line in text)))

    def numbers(name: str, columns: int = 1, default: str = "") -> Floats:
        """Return the finite numbers of a block, shape (M, columns)."""
        text = " ".join(lines(name)) or default
        try:
            rows = np.array(text.split(), float).reshape(-1, columns)
        except ValueError:
            rows = np.array([[math.nan]])
        if not np.isfinite(rows).all():
            raise ValueError(f"{name} = {text[:60]!r}: must be finite numbers, {columns} in a row")
        return rows

    segments = " ".join(lines("run_segments")).split()
    if not segments or not all(map(str.isdecimal, segments)):
        text = " ".join(segments)[:60]
        raise ValueError(f"run_segments = {text!r}: must be whole numbers of steps, 0 or more")
    if not values.get("pair_style"):
        raise ValueError("pair_style is missing")
    judged = values.get("analytic_enable", "").strip() in ("yes", "true", "on", "1")
    at = int(numbers("analytic_segment", default="-1")[0, 0])
    variables = [line.partition(" ") for line in lines("variables")]
    return UpstreamTest(
        name=file.stem,
        commands=(
            f"variable input_dir index {file.parent.resolve()}",
            *(f"variable {name} index {value.strip()}" for name, _, value in variables),
            *lines("pre_commands"),
            f"pair_style {values['pair_style'].strip()}",
            *(f"pair_coeff {text}" for text in lines("pair_coeff")),
            *lines("post_commands"),
        ),
        segments=tuple(map(int, segments)),
        epsilon=float(numbers("epsilon", default="1e-10")[0, 0]),
        recorded={name: numbers(name, 5) for name in RECORDED if values.get(name)},
        model=values.get("analytic_model", "").strip() if judged else "",
        tolerance=float(next(numbers("analytic_tol").flat, math.nan)) if judged else math.nan,
        judged_segment=at if 0 <= at < len(segments) else len(segments) - 1,
    )
