"""The ledger: what a publication states, what we compute, and whether it holds.

``source.toml`` is read into frozen objects, in the order of the publication.
Every status follows from numbers of the run. Three of them meet in a row:
*printed*, what the statement gives when taken as it stands; *found*, the same
quantity by an independent route; *corrected*, the statement with one named
correction.

Where two ledgers differ: statuses exactly, numbers up to round-off.
"""

from __future__ import annotations

import math
import string
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from importlib import resources
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from harness.comparison import compare as rows
from harness.comparison.compare import Change
from harness.observables.row import Row, by_name
from harness.shown import Record

_NUMPY = ("abs", "cos", "exp", "isfinite", "nan", "pi", "radians", "sin", "sqrt", "sum")
_BUILT_IN = (all, bool, len, max, min, range, round, zip)
_FUNCTIONS = {name: getattr(np, name) for name in _NUMPY} | {f.__name__: f for f in _BUILT_IN}

DIGITS = 7
"""Significant digits of a recorded number: round-off of other machines stays below them."""

ROUND_OFF = 1e-12
"""Of numbers of about 1: a difference below it is written as a bound, not as a number."""


def rounded(value: float, tolerance: float = 0.0) -> float:
    """Return a number to :data:`DIGITS` digits, 0 for one below a hundredth of a tolerance.

    A residual of round-off thus becomes 0, and other machines record the same number.
    """
    if abs(value) < 0.01 * tolerance:
        return 0.0
    return float(f"{value:.{DIGITS}g}") + 0.0  # no minus before a zero


def evaluated(formula: str, numbers: Mapping[str, Any]) -> Any:
    """Return the value of a formula of ``source.toml``, a file of this package, by numpy."""
    return eval(formula, {"__builtins__": {}, **_FUNCTIONS, **numbers})


def fill_in(sentence: str, numbers: Mapping[str, Any]) -> str:
    """Put numbers into a sentence of ``source.toml``: ``{x:.3f}``, of a list one by one.

    What stands in the braces is a formula; ``{x:bound}`` is what :func:`bounded` says, and what
    holds or not is yes or no.
    """
    return _Sentences().vformat(sentence, (), numbers)


class _Sentences(string.Formatter):
    def get_field(self, field_name: str, _: Any, kwargs: Any) -> Any:
        return evaluated(field_name, kwargs), field_name

    def format_field(self, value: Any, format_spec: str) -> str:
        if isinstance(value, (list, tuple, np.ndarray)):
            return ", ".join(self.format_field(item, format_spec) for item in value)
        if isinstance(value, (bool, np.bool_)):
            return "yes" if value else "no"
        return bounded(value) if format_spec == "bound" else format(value, format_spec)


def bounded(value: float, bound: float = ROUND_OFF) -> str:
    """Return the size of a difference in words: ``less than 1e-12`` where it is round-off."""
    return f"less than {bound:.0e}" if abs(value) < bound else f"{value:.0e}"


_REASONS = {
    "round-off": "two routes in double precision, numbers of about 1: round-off",
    "last digit": "half of the last digit printed",
}


@dataclass(frozen=True)
class Source:
    """A place in the publication, and what stands there.

    ``key`` is unique (``eq-6``, ``table-1-well``, ``text-t-c``, ``fig-4``, ``erratum-13``);
    ``where`` names section and number; ``says`` is one sentence or formula. ``formula`` computes
    what it gives exactly as it is printed, right or wrong, or ``holds`` is a condition on the
    numbers of a run; ``repaired`` is the same once it is corrected. ``finds`` is what a run finds,
    with its numbers in braces, and ``facts`` are
    the conditions and sentences of its parts. ``tolerance``
    [``unit``] is how far printed and found may lie apart, ``why`` where it comes from.
    ``evidence`` are links, relative to the report's folder or the repository
    (``figures/x.svg``, ``tests/theory/test_shock.py``). ``title`` is that of a figure.
    """

    key: str
    where: str
    says: str
    formula: str = ""
    holds: str = ""
    repaired: str = ""
    finds: str = "{computed}"
    facts: tuple[tuple[str, str], ...] = ()
    tolerance: float = math.nan
    unit: str = ""
    why: str = ""
    correction: str = ""
    evidence: tuple[str, ...] = ()
    untestable: str = ""
    title: str = ""
    picture: str = ""

    def printed(self, **numbers: Any) -> Any:
        """Return what the formula gives as it is printed, of numbers and arrays alike."""
        return evaluated(self.formula, numbers)

    def corrected(self, **numbers: Any) -> Any:
        """Return what the formula gives once it is corrected; NaN without a correction."""
        return evaluated(self.repaired or "nan", numbers)


def _source(key: str, entry: dict[str, Any]) -> Source:
    fields: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items()}
    if "tolerance" in fields:
        fields["tolerance"], fields["unit"] = fields["tolerance"]
    if name := fields.pop("name", ""):
        fields["picture"] = f"fig-{int(key.removeprefix('fig-')):02d}-{name}"
        fields["evidence"] = (f"figures/{fields['picture']}.svg",)
        fields.setdefault("finds", "{facts}")
    elif "evidence" in fields:
        fields["evidence"] = tuple(f"tests/{test}.py" for test in fields["evidence"])
    why = fields.get("why", "")
    fields["why"] = _REASONS.get(why, why)
    return Source(key, **fields)


_TEXT = resources.files("harness.reproduction").joinpath("source.toml").read_text("utf-8")
SOURCES = {key: _source(key, entry) for key, entry in tomllib.loads(_TEXT).items()}
FIGURES = {key: source for key, source in SOURCES.items() if source.title}


def named_source(source: Source | str) -> Source:
    """Return the source of a key; raise KeyError for one that the publication has not."""
    return SOURCES[source] if isinstance(source, str) else source


Floats = NDArray[np.float64]


class ClaimStatus(StrEnum):
    """What became of a statement."""

    REPRODUCED = "reproduced"
    CORRECTED = "reproduced with a correction"
    NOT_REPRODUCED = "not reproduced"
    UNTESTABLE = "cannot be tested here"


@dataclass(frozen=True)
class Statement(Record):
    """One row of the ledger.

    ``computed`` says in words what this run found, with its numbers;
    ``correction`` names what has to be changed for the statement to hold. Numbers are
    NaN where the statement has none; ``tolerance`` is absolute, in the source's unit, and
    ``why`` says where it comes from, or why a statement cannot be tested.
    """

    source: Source
    status: ClaimStatus
    computed: str
    correction: str = ""
    evidence: tuple[str, ...] = ()
    printed: float = math.nan
    found: float = math.nan
    corrected: float = math.nan
    tolerance: float = math.nan
    why: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return the row as a flat JSON-ready mapping, its numbers as :func:`rounded` has them."""
        return {
            "key": self.source.key,
            "where": self.source.where,
            "says": self.source.says,
            "status": str(self.status),
            "computed": self.computed,
            "correction": self.correction,
            "evidence": " ".join(self.evidence),
            "printed": rounded(self.printed),
            "found": rounded(self.found, self.tolerance),
            "corrected": rounded(self.corrected, self.tolerance),
            "tolerance": self.tolerance,
            "unit": "" if math.isnan(self.printed) else self.source.unit,
            "why": self.why,
        }


def compare(
    source: Source | str,
    *,
    found: ArrayLike,
    printed: ArrayLike | None = None,
    corrected: ArrayLike | None = None,
    tolerance: float | None = None,
    **numbers: Any,
) -> Statement:
    """Return the row of a statement that gives a number, or of a formula tried at many samples.

    Reproduced if ``printed`` is ``found`` within the tolerance (the source's unless given), at
    every sample; with a correction if only ``corrected`` is; else not reproduced. NaN is never
    reproduced. Of samples, which have one length, the row shows that at which ``printed`` lies
    furthest off (the middle one where all agree), and its sentence ends with the largest
    differences. A correction that was not needed, or fails anywhere, is left out of the row.
    ``printed`` and ``corrected`` are what the source's formulas give for ``numbers``, unless
    given. ``numbers`` are also those of the sentence, with the three and ``samples``, how many
    there are.
    """
    named = named_source(source)
    printed = named.printed(**numbers) if printed is None else printed
    corrected = named.corrected(**numbers) if corrected is None else corrected
    width = named.tolerance if tolerance is None else tolerance
    right = np.ravel(np.asarray(found, float))
    as_printed, other = (
        np.broadcast_to(np.ravel(np.asarray(values, float)), right.shape)
        for values in (printed, corrected)
    )
    off = np.nan_to_num(np.abs(as_printed - right), nan=math.inf)
    repaired = bool(np.all(np.abs(other - right) <= width))
    holds = bool(off.max() <= width)
    at = right.size // 2 if holds else int(np.argmax(off >= off.max() * (1 - ROUND_OFF)))
    largest = ""
    if np.ndim(found):
        largest = f"; {_largest(off, other - right, width, named.unit)}"
        as_printed = np.where(np.abs(as_printed) < 1e-14 * np.abs(right).max(), 0.0, as_printed)
        other = other if repaired else np.full_like(right, math.nan)
    at_sample: dict[str, Any] = {
        "printed": float(as_printed[at]),
        "found": float(right[at]),
        "corrected": float(other[at]),
    }
    numbers |= {"samples": right.size}
    row = claim(named, holds=holds, corrected_holds=repaired, **at_sample, **numbers)
    return replace(row, computed=row.computed + largest, tolerance=width, **at_sample)


def _largest(printed: Floats, corrected: Floats, width: float, unit: str) -> str:
    """Say how far off a formula is at most, as printed and, if there is one, corrected."""
    bound = f"less than {width:.0e}"
    most = float(printed.max())
    # rounded first: what lies between two digits would be rounded up here and down there
    text = f"off by {bound}" if most <= width else f"off by at most {rounded(most):.1e}"
    text += "" if unit == "1" else f" {unit}"
    if not np.isfinite(corrected).all():
        return text
    most = float(np.abs(corrected).max())
    return f"{text} as printed, {bound if most <= width else f'{rounded(most):.1e}'} corrected"


def claim(
    source: Source | str,
    *,
    holds: bool | None = None,
    corrected_holds: bool | None = None,
    correction: str | None = None,
    **numbers: Any,
) -> Statement:
    """Return the row of a statement in words, judged by a condition on this run's numbers.

    ``numbers`` are those of its conditions and of its sentence in the source; conditions and
    correction are the source's unless given.
    """
    named = named_source(source)
    if holds is None:
        holds = bool(evaluated(named.holds, numbers))
    if corrected_holds is None:
        corrected_holds = bool(named.repaired and evaluated(named.repaired, numbers))
    status = ClaimStatus.CORRECTED if corrected_holds else ClaimStatus.NOT_REPRODUCED
    if holds:
        status, correction = ClaimStatus.REPRODUCED, ""
    elif correction is None:
        correction = fill_in(named.correction, numbers)
    return Statement(
        named,
        status,
        fill_in(named.finds, numbers),
        correction,
        named.evidence,
        why=named.why,
    )


Fact = tuple[bool, str]
"""Whether a part of a statement holds in this run, and what was found, with its numbers."""


def claim_of_facts(
    source: Source | str,
    facts: Sequence[Fact] = (),
    *,
    holds: bool | None = None,
    corrected_holds: bool | None = None,
    correction: str | None = None,
    **numbers: Any,
) -> Statement:
    """Return the row of a statement that holds if every fact does, unless ``holds`` is given.

    Its facts are those of the source, each a condition and a sentence, and the given ones. The
    row lists what agrees and what does not, in this order; the source's ``finds`` may add a
    remark.
    """
    named = named_source(source)
    every = [
        (bool(evaluated(test, numbers)), fill_in(sentence, numbers))
        for test, sentence in named.facts
    ]
    every += facts
    right, wrong = (
        "; ".join(text for held, text in every if bool(held) is side) for side in (True, False)
    )
    paragraphs = [
        f"Agrees: {right}." if right else "",
        f"Does not agree: {wrong}." if wrong else "",
    ]
    return claim(
        named,
        holds=not wrong if holds is None and not named.holds else holds,
        corrected_holds=corrected_holds,
        correction=correction,
        facts=" ".join(filter(None, paragraphs)),
        **numbers,
    )


def untestable(
    source: Source | str, why: str = "", computed: str = "not computed", **numbers: Any
) -> Statement:
    """Return the row of a statement that needs what is not here, with the reason.

    What was computed all the same is the source's sentence, with its ``numbers`` if there are any.
    """
    named = named_source(source)
    computed = fill_in(named.finds, numbers) if numbers else computed
    reason = why or named.untestable or named.why
    return Statement(named, ClaimStatus.UNTESTABLE, computed, why=reason)


@dataclass(frozen=True)
class Ledger(Record):
    """All statements, in the order of the publication."""

    statements: tuple[Statement, ...] = ()

    ROWS: ClassVar = "statements"

    def __post_init__(self) -> None:
        keys = [s.source.key for s in self.statements]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            raise ValueError(f"statements that are there twice: {', '.join(twice)}")

    def __getitem__(self, key: str) -> Statement:
        """Return the statement of a key; raise KeyError for one that is not there."""
        for statement in self.statements:
            if statement.source.key == key:
                return statement
        raise KeyError(key)

    def count(self, status: ClaimStatus) -> int:
        """Return how many statements have a status."""
        return sum(s.status is status for s in self.statements)


NUMBERS = ("printed", "found", "corrected", "tolerance")

RELATIVE = 1e-6
"""Round-off of another processor or library, carried through a run of 1e5 steps."""

OF_TOLERANCE = 0.01
"""A residual is round-off itself: what counts is its size against the row's tolerance."""


def ledger_differences(first: pd.DataFrame, second: pd.DataFrame) -> list[str]:
    """Return one line for each way in which ``second`` departs from ``first``.

    Both as of :meth:`Ledger.to_frame`; words are not
    compared, since they repeat the numbers.
    """
    a, b = first.set_index("key"), second.set_index("key")
    lines = [f"{key}: is not there any more" for key in a.index.difference(b.index, sort=False)]
    lines += [f"{key}: is new" for key in b.index.difference(a.index, sort=False)]
    for key in a.index.intersection(b.index, sort=False):
        was, now = (_numbers(frame.loc[key]) for frame in (a, b))
        if a.loc[key]["status"] != b.loc[key]["status"]:
            lines.append(f"{key}: was {a.loc[key]['status']}, is {b.loc[key]['status']}")
        room = OF_TOLERANCE * float(np.nan_to_num(was["tolerance"].value))

        def width(_: Row, row: Row, room: float = room) -> float:
            return room + RELATIVE * abs(row.value)

        pairs = rows.compare(was, now, width)
        lines += [
            f"{key}: {name} was {was[name].value:.10g}, is {now[name].value:.10g}"
            for name, pair in pairs.items()
            if pair.change is Change.MOVED
        ]
    return lines


def _numbers(row: pd.Series[Any]) -> dict[str, Row]:
    numbers = pd.to_numeric(row[[*NUMBERS]], errors="coerce")
    return by_name(*(Row(name, float(numbers[name]), math.nan, "") for name in NUMBERS))


@dataclass(frozen=True)
class Printed:
    """The numbers that the source prints, in the order of the text."""

    critical_angle_deg: float = 10.21
    simulated_within_deg: float = 0.01  # "to one-hundredth of a degree"
    rest_angle_deg: float = 30.0
    well_divisor: float = 4.0  # of theta in the steady-state condition, eq. (6)
    shock: float = 0.25
    diverges_above: float = 1.0  # "E > 1 ... will go to infinity"
    restitution: float = 1e-20
    gravity: float = 9.81  # [m/s2]
    glass_rigidity: float = 40_000.0
    glass_depth: float = 0.5  # [m]
    rigidities: tuple[float, float] = (1e4, 1e6)
    stiffnesses: tuple[float, float] = (1e5, 1e7)  # [N/m]
    orders_of_magnitude: float = 3.0  # that the rigidities are said to span
    median_rigidity: float = 1e5
    crest_time: float = 0.41  # [s]
    contact_time: float = 0.007  # [s]
    damping_factor: float = 1.0  # of (gamma/m_eff)^2, eq. (12)
    error_percent: float = 0.5  # of the peak deformation ...
    error_stiffness: float = 1e4  # [N/m] ... from here on
    joins: float = 0.5  # [t0] the third particle
    returns: float = 1.0  # [t0] the second contact of the grain
    leaves: float = 1.5  # [t0] the grain
    speeds: tuple[float, float] = (2.0, 4.0)  # [m/s]
    heights: tuple[int, int] = (1, 19)
    longest_chain: int = 10  # contacts
    halved: float = 0.5  # "can nearly halve the impulse"
    speed_exponent: float = 0.5  # v ~ sqrt(n)
    difference_percent: float = 1e-6  # of deformations at the largest rigidity
    search: float = 3.0  # [t0] bound of the largest compression
    structure_particles: tuple[int, int] = (2, 7)
    first_packet: float = 1.5  # [t0] end of grain-neighbour interactions
    window_figure: tuple[int, int] = (4, 3)  # particles: its caption, its text


PRINTED = Printed()
