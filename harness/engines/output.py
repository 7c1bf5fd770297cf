"""What a run leaves: named numbers, tables of samples, log, provenance; and how they are read.

Scripts print the numbers as lines ``RESULT name = value``. A name comes once, or is that of rows,
with several numbers to a line. The tables that they write are CSV with a header, or dumps with a
block for each sample.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from harness.errors import EngineNaNError, EngineOutputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from harness.model.scene import Motion, Scene

# numpy is imported where arrays are made: a kept verification is answered without it
Table: TypeAlias = "Mapping[str, NDArray[np.float64]]"
"""Columns by names that end in the unit (``x_m``), each (M,), or (M, N) for N particles."""

SERIES, STAGES = "series", "stages"  # the tables of samples, and of the stages of a path
COLUMNS = {  # of the parts of a motion
    "position": ("x_m", "y_m", "z_m"),
    "velocity": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "angular_velocity": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force": ("fx_N", "fy_N", "fz_N"),
    "torque": ("tx_N_m", "ty_N_m", "tz_N_m"),
}
TEMPERATURE = "temperature_K"
CLOCKS = ("time_s", "step")  # columns that rise from row to row
ROUNDING = 1e-12  # relative, of a number printed with 15 digits
LONGEST = 80  # characters of a value that a message repeats
_RESULT = re.compile(r"^RESULT (\w+) = (.*)$", re.MULTILINE)
_PARTICLE = re.compile(r"(\w+)\[(\d+)\]")
_HEADER = 9  # lines above the particles of a frame of a dump
_UNITS = {  # columns of a dump in SI units, by their names there
    name.format(axis=axis, k=k): unit.format(axis=axis)
    for name, unit in {
        "{axis}u": "{axis}_m",
        "{axis}": "{axis}_m",
        "v{axis}": "v{axis}_m_per_s",
        "f{axis}": "f{axis}_N",
        "f_contact[{k}]": "f{axis}_N",
        "omega{axis}": "w{axis}_rad_per_s",
        "tq{axis}": "t{axis}_N_m",
    }.items()
    for k, axis in enumerate("xyz", 1)
} | {"radius": "radius_m", "c_warmth": "temperature_K"}
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_DATE = re.compile(rf"(\d{{1,2}}) ?({'|'.join(_MONTHS)}) ?(20\d\d)")
# columns of a dump that are the same to the last digit where a run is taken up
_STATE = ("xu", "yu", "zu", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "radius")


def finished(log: str) -> bool:
    """Return whether a log has the line that a script prints last, not only echoes it."""
    return any(name == "verdict" for name, _ in results_in(log))


def results_in(text: str) -> tuple[tuple[str, str], ...]:
    """Return the pairs of name and value of all lines ``RESULT name = value``, in order."""
    return tuple(_RESULT.findall(text))


def release_of(version: str) -> tuple[int, ...]:
    """Return the numbers by which releases are in order: of a date year, month, day, then others.

    >>> release_of("22 Jul 2025 - Update 4")
    (2025, 7, 22, 4)
    >>> release_of("2025.7.22.4.0")
    (2025, 7, 22, 4, 0)
    """
    date = _DATE.search(version)
    rest = version[date.end() :] if date else version
    numbers = tuple(int(n) for n in re.findall(r"\d+", rest))
    if date is None:
        return numbers
    return (int(date[3]), 1 + _MONTHS.index(date[2]), int(date[1]), *numbers)


@dataclass(frozen=True)
class Provenance:
    """Identify the engine behind a result.

    ``how`` is ``in-process``, ``executable`` or the launcher that started it, with the arguments
    of the executable, ``worker`` (a Python that has it), or ``compiled``.
    """

    engine: str
    engine_version: str
    packages: tuple[str, ...] = field(default=(), repr=False)
    executable: str = ""
    how: str = ""
    script: str = ""
    script_sha256: str = ""
    integrator: str = ""

    @property
    def label(self) -> str:
        """Return the engine with its version, and how it was run."""
        return ", ".join(filter(None, (f"{self.engine} {self.engine_version}".strip(), self.how)))


@dataclass(frozen=True)
class Output:
    """The output of one job.

    ``results`` are pairs of name and text, in order; ``tables`` map a name to columns;
    ``seconds`` is the wall time [s] of the run; ``title`` is the engine's name in messages, that of
    the provenance unless given. Raise TypeError for a table that is none. Methods raise
    EngineOutputError for a value that is missing or cannot be read, and EngineNaNError for one that
    is not finite.
    """

    results: tuple[tuple[str, str], ...]
    provenance: Provenance
    tables: Mapping[str, Table] = field(default_factory=dict, repr=False)
    log: str = field(default="", repr=False)
    seconds: float = 0.0
    title: str = ""

    def __post_init__(self) -> None:
        for name, table in self.tables.items():
            _check_table(name, table)

    @property
    def engine(self) -> str:
        """Return the engine's name as messages write it."""
        return self.title or self.provenance.engine

    def has(self, name: str) -> bool:
        """Return whether there is a result of this name."""
        return any(key == name for key, _ in self.results)

    def text(self, name: str) -> str:
        """Return the result of this name as text; it may come again, but not with another one."""
        values = [*dict.fromkeys(value for key, value in self.results if key == name)]
        if not values:
            raise EngineOutputError(f"{self.engine} left an incomplete result ({name!r})")
        if len(values) > 1:
            first, second = (value[:LONGEST] for value in values[:2])
            raise EngineOutputError(
                f"{self.engine} left two results {name!r}: {first} and {second}"
            )
        return values[0]

    def number(self, name: str) -> float:
        """Return the result of this name as a finite number."""
        return self._number(name, self.text(name))

    def check_numbers(self, expected: Mapping[str, float], source: str = "was requested") -> None:
        """Raise EngineOutputError where a result differs from a number derived from the run.

        ``expected`` are numbers by the names of results, and ``source`` is their origin; a missing
        result is not checked. It may differ by the rounding of 15 printed digits.
        """
        for name, value in expected.items():
            if self.has(name) and abs(self.number(name) - value) > ROUNDING * abs(value):
                raise EngineOutputError(
                    f"{self.engine} says that it ran with {name} = {self.text(name)[:LONGEST]}, "
                    f"where {value:.15g} {source}"
                )

    def rows(self, name: str, columns: int) -> NDArray[np.float64]:
        """Return all results of this name, shape (rows, columns)."""
        import numpy as np

        texts = [value.split() for key, value in self.results if key == name]
        if any(len(words) != columns for words in texts):
            raise EngineOutputError(f"{self.engine} left an incomplete result ({name!r})")
        rows = [[self._number(name, word) for word in words] for words in texts]
        return np.array(rows, dtype=np.float64).reshape(-1, columns)

    def table(self, columns: Sequence[str], rows: int | None = None, name: str = SERIES) -> Table:
        """Return a table that has at least these columns, finite, ``rows`` of them if given.

        Raise EngineOutputError also where the first column is a clock and does not rise.
        """
        import numpy as np

        table = self.tables.get(name, {})
        if missing := [column for column in columns if column not in table]:
            raise EngineOutputError(
                f"{self.engine} left no table with {', '.join(missing)}: run must return them in "
                f"tables[{name!r}], which has {', '.join(table) or 'no columns'}"
            )
        count = table[columns[0]].shape[0]
        if rows is not None and count != rows:
            raise EngineOutputError(f"{self.engine} left {count} rows of a series of {rows}")
        if count == 0 or any(table[column].shape[0] != count for column in columns):
            raise EngineOutputError(f"{self.engine} left an incomplete series")
        if not all(np.isfinite(table[column]).all() for column in columns):
            raise EngineNaNError(f"{self.engine} wrote a series with values that are not numbers")
        if columns[0] in CLOCKS and np.any(np.diff(table[columns[0]], axis=0) <= 0.0):
            raise EngineOutputError(f"{self.engine} wrote a series that is out of order")
        return table

    def _number(self, name: str, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise EngineOutputError(
                f"{self.engine} left an incomplete result ({name} = {text[:LONGEST]!r})"
            ) from None
        if not math.isfinite(value):
            raise EngineNaNError(f"{self.engine} returned {name} = {text[:LONGEST]}")
        return value


def _check_table(name: str, table: Any) -> None:
    import numpy as np

    if not isinstance(table, Mapping):
        raise TypeError(f"table {name!r} is no mapping of columns: {type(table).__name__}")
    lengths = set()
    for column, values in table.items():
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiub":
            raise TypeError(f"column {column!r} of table {name!r} is no array of numbers")
        if values.ndim not in (1, 2):
            raise TypeError(f"column {column!r} of table {name!r} is not of shape (M,) or (M, N)")
        lengths.add(len(values))
    if len(lengths) > 1:
        raise TypeError(f"table {name!r} has columns of several lengths: {sorted(lengths)}")


# ---- motions as tables: ``series`` of all bodies, ``stages`` of the first one, each (K,)


def motion_tables(motion: Motion, scene: Scene, *, sampled: bool = True) -> dict[str, Table]:
    """Return the tables of a motion; without samples where they are not wanted."""
    import numpy as np

    from harness.model.scene import STAGE_COLUMNS

    tables: dict[str, Table] = {}
    if sampled:
        steps = scene.every * np.arange(len(motion), dtype=np.float64)
        columns = {"step": steps, "time_s": motion.time}
        for part, names in COLUMNS.items():
            columns |= zip(names, np.moveaxis(getattr(motion, part), 2, 0), strict=True)
        if motion.temperature is not None:
            columns[TEMPERATURE] = motion.temperature
        tables[SERIES] = columns
    if motion.stages is not None:
        tables[STAGES] = dict(zip(STAGE_COLUMNS, motion.stages.T, strict=True))
    return tables


# ---- files of tables


def read_csv(text: str, program: str) -> Table:
    """Return the columns of a series by its header, each (M,); the first one is its clock.

    Columns ``x_m[1]``, ``x_m[2]``, ... of N particles are one, ``x_m`` (M, N). A row that repeats
    the one before is dropped: some codes print a row twice where two stretches of a run meet.
    Raise EngineOutputError for a text without rows, cut within its last row, or that cannot be
    read, and for rows of one time that differ or a time that falls; EngineNaNError for values that
    are not finite.
    """
    import numpy as np

    header, _, body = text.partition("\n")
    if not body.strip() or not text.endswith("\n"):
        raise EngineOutputError(f"{program} left a series without rows, or cut in its last row")
    names = [name.strip().strip('"') for name in header.lstrip("# ").split(",")]
    try:
        rows = np.loadtxt(body.splitlines(), delimiter=",", ndmin=2)
        if rows.shape[1] != len(names):
            raise ValueError(f"{rows.shape[1]} columns under {len(names)} names")
    except ValueError as error:
        raise EngineOutputError(f"{program} left an incomplete series ({error})") from None
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"{program} wrote a series with values that are not numbers")
    return _columns(names, rows[_new_rows(rows, names[0], program)], program)


def _new_rows(rows: NDArray[np.float64], clock: str, program: str) -> NDArray[np.bool_]:
    """Return which rows (M, ...) do not repeat the one before; the first column is the clock.

    Raise EngineOutputError for another row of the same time, or of an earlier one.
    """
    import numpy as np

    later = np.diff(rows[:, 0], prepend=-np.inf) > 0.0
    same = np.concatenate([[False], (rows[1:] == rows[:-1]).all(axis=1)])
    for row in np.flatnonzero(~later & ~same):
        raise EngineOutputError(
            f"{program} wrote a series out of order: row {row + 1} is of {clock} = "
            f"{rows[row, 0]:.9g}, the row before of {rows[row - 1, 0]:.9g}, and differs"
        )
    return later


def _columns(names: list[str], rows: NDArray[np.float64], program: str) -> Table:
    """Return columns by name, those of particles side by side in the order of their numbers."""
    table: dict[str, NDArray[np.float64]] = {}
    particles: dict[str, dict[int, int]] = {}
    for index, name in enumerate(names):
        if (particle := _PARTICLE.fullmatch(name)) is None:
            table[name] = rows[:, index]
        else:
            particles.setdefault(particle[1], {})[int(particle[2])] = index
    for name, places in particles.items():
        if sorted(places) != list(range(1, len(places) + 1)):
            raise EngineOutputError(f"{program} left a series that lacks columns of {name}")
        # particles of a row side by side in memory: sums over them then round alike
        table[name] = rows[:, [places[number] for number in sorted(places)]].copy()
    return table


def read_dump(text: str, program: str) -> Table:
    """Return the columns of a dump, ``step`` (M,) and the rest (M, N), sorted by id.

    ``x``, ``vx``, ``fx`` and so on are named with their SI units. A frame that comes again where a
    run was taken up is dropped. Raise EngineOutputError for a dump that is cut, whose frames have
    different particles, or are of one step with other velocities.
    """
    import numpy as np

    lines = text.splitlines()
    try:
        if not text.endswith("\n") or len(lines) < _HEADER:
            raise ValueError("it is cut")
        count, names = int(lines[3]), lines[_HEADER - 1].split()[2:]
        block = _HEADER + count
        if len(lines) % block:
            raise ValueError(f"{len(lines)} lines, not blocks of {block}")
        if any(line != lines[3] for line in lines[3::block]):
            raise ValueError("the number of particles changes")
        steps = np.array([float(line) for line in lines[1::block]])
        # the first line of each frame, then the second: there may be many frames of few particles
        texts = [text for first in range(_HEADER, block) for text in lines[first::block]]
        rows = np.loadtxt(texts, ndmin=2).reshape(count, len(steps), len(names)).swapaxes(0, 1)
        order = np.argsort(rows[:, :, names.index("id")], axis=1)
        rows = np.take_along_axis(rows, order[:, :, None], axis=1)
        if np.any(np.diff(rows[:, :, names.index("id")], axis=0)):
            raise ValueError("particles come or go")
    except ValueError as error:
        raise EngineOutputError(f"{program} wrote a dump that cannot be read ({error})") from None
    # forces are computed anew where a run is taken up, and places wrapped
    state = rows[:, :, [i for i, name in enumerate(names) if name in _STATE]]
    new = _new_rows(np.column_stack([steps, state.reshape(len(steps), -1)]), "step", program)
    rows = rows[new]
    columns = {_UNITS.get(n, n): rows[:, :, i] for i, n in enumerate(names) if n != "id"}
    return {"step": steps[new], **columns}
