"""The border to engines: what runs cost is estimated before, what comes back is checked after.

An estimate is steps times particles times what a step costs: of an engine
:attr:`harness.engines.traits.Traits.microseconds_per_step`, of the solvers of towers
:mod:`harness.solvers.chain.motion`. It is good to a factor of a few; the limit is for runs that are
thousands of times longer than was thought.

An engine may belong to another package, and its ``run`` may return anything, or raise anything:
each job then has an EngineError in its place that names engine, package, call and what was
expected, and the others go on.
"""

from __future__ import annotations

import errno
import functools
import json
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.engines.output import SERIES, Output
from harness.engines.traits import Traits
from harness.errors import FULL, EngineError, EngineOutputError, HarnessError, RequestError
from harness.observables.provenance import Provenance

if TYPE_CHECKING:
    from harness.engines.contract import Engine, Job


MOST_SECONDS = 600.0
"""The expected time of a longer run is refused without --force."""

STATED_SECONDS = 60.0
"""The expected time of a longer run is printed before it begins."""

PARTICLES = 10
"""Of the system that the costs were measured on: one grain and nine fixed spheres."""

_UNITS = (("years", 31_557_600.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0))


def engine_seconds(steps: float, particles: int, rules: Traits) -> float:
    """Return what so many steps are expected to take an engine of these rules [s]."""
    return steps * max(1.0, particles / PARTICLES) * rules.microseconds_per_step * 1e-6


def job_seconds(job: Job, rules: Traits) -> float:
    """Return the expected time of a job's scene [s]; 0 for a job without a scene."""
    if job.template.scene is None:
        return 0.0
    scene = job.template.scene(job.values)
    return engine_seconds(scene.steps, len(scene.mass), rules)


SMALLER = "a coarser step, a softer contact or a smaller system"


def check_duration(seconds: float, work: str, instead: str = "") -> None:
    """Raise RequestError for work that is expected to take more than :data:`MOST_SECONDS`.

    ``instead`` is what to request in its place.
    """
    if not seconds <= MOST_SECONDS:
        raise RequestError(
            f"{work} would take an estimated {in_words(seconds)} on one core, "
            f"{in_words(MOST_SECONDS)} are the limit: {instead or SMALLER}, or --force"
        )


def in_words(seconds: float) -> str:
    """Return a time in the largest unit of which it is one or more."""
    if not seconds < 1000 * _UNITS[0][1]:
        return "more than 1000 years"
    unit, size = next(((unit, size) for unit, size in _UNITS if seconds >= size), ("s", 1.0))
    return f"{seconds / size:.3g} {unit}"


Outcomes = list[Output | EngineError]
Run = Callable[["Engine", Sequence["Job"]], Outcomes]

HARNESS = "harness"
"""The package whose errors are bugs of this project."""


EXPECTED: dict[str, tuple[str, tuple[type, ...]]] = {
    "identify": ("a Provenance", (Provenance,)),
    "refuses": ("a text, empty where it refuses nothing", (str,)),
    "fingerprint": ("a dictionary that is ready for JSON, or None", (Mapping, type(None))),
}
"""What methods of an engine beside ``run`` return: in words, and its types."""


@dataclass
class Pace:
    """What an engine's runs took: steps in all, and the cost of a step in the longest [s].

    A step of more particles than the costs of engines were measured with counts for more.
    """

    steps: float = 0.0
    longest: float = 0.0
    seconds_per_step: float = 0.0

    def add(self, steps: float, seconds: float) -> None:
        """Count a run of so many steps that took so long."""
        self.steps += steps
        if steps > self.longest:
            self.longest, self.seconds_per_step = steps, seconds / steps


def _reads_all(name: str) -> Any:
    """Return a method of a dictionary as one that counts for each of its names."""

    def method(self: ReadValues, *arguments: Any) -> Any:
        self.read.update(dict.keys(self))
        return getattr(dict(dict.items(self)), name)(*arguments)

    return method


class ReadValues(dict[str, Any]):
    """The values of a job, which record the names read; to read all of them counts for each."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        super().__init__(values)
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        self.read.add(name)
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        self.read.add(str(name))
        return super().__contains__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Return a value, as a dictionary does."""
        self.read.add(name)
        return super().get(name, default)

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (self.copy(),)

    __iter__, __or__, __ror__ = map(_reads_all, ("__iter__", "__or__", "__ror__"))
    keys, values, items, copy = map(_reads_all, ("keys", "values", "items", "copy"))


def engine_label(engine: Engine | type[Engine]) -> str:
    """Return an engine's name for a message, with its package where that is not the harness."""
    kind = engine if isinstance(engine, type) else type(engine)
    package = kind.__module__.partition(".")[0]
    of_package = "" if package == HARNESS else f" of package {package!r}"
    return f"engine {getattr(engine, 'name', kind.__name__)!r}{of_package}"


def checked_run(run: Run) -> Run:
    """Return an engine's ``run`` with its outcomes checked against the contract.

    In another package's engine an exception becomes the error of its jobs, and a value that a
    job's template has an engine read must have been read.
    """

    @functools.wraps(run)
    def checked(self: Engine, jobs: Sequence[Job]) -> Outcomes:
        foreign = not type(self).__module__.startswith(f"{HARNESS}.")
        tracked = [replace(j, values=ReadValues(j.values)) for j in jobs] if foreign else jobs
        try:
            outcomes: Any = run(self, tracked)
        except Exception as error:
            full = isinstance(error, OSError) and error.errno in (*FULL, errno.EMFILE)
            if not foreign or isinstance(error, (HarnessError, MemoryError)) or full:
                raise
            return [_raised(self, "run", error) for _ in jobs]
        count = len(jobs)
        if not isinstance(outcomes, (list, tuple)) or len(outcomes) != count:
            result = f"a {type(outcomes).__name__}"
            if isinstance(outcomes, (list, tuple)):
                result = f"{len(outcomes)} outcomes"
            expected = f"a list with an Output or an EngineError for each of {count} jobs"
            return [_error(self, "run", f"returned {result}", expected) for _ in jobs]
        return [_checked(self, *pair) for pair in zip(tracked, outcomes, strict=True)]

    return checked


def checked_call(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of an engine with its result checked: it raises a HarnessError otherwise."""
    expected = EXPECTED[name]

    @functools.wraps(call)
    def checked(self: Engine, *arguments: Any) -> Any:
        if type(self).__module__.startswith(f"{HARNESS}."):
            return call(self, *arguments)
        try:
            value: Any = call(self, *arguments)
            ready = name != "fingerprint" or json.dumps(value)
        except HarnessError:
            raise
        except Exception as error:
            raise _raised(self, name, error) from error
        if not isinstance(value, expected[1]) or not ready:
            raise _error(self, name, f"returned a {type(value).__name__}", expected[0])
        return value

    return checked


def _error(engine: Engine, call: str, problem: str, expected: str) -> EngineOutputError:
    return EngineOutputError(f"{engine_label(engine)}: {call} {problem}, must return {expected}")


def _raised(engine: Engine, call: str, error: Exception) -> EngineError:
    """Return the error of a call that raised what no engine should, with its place in the code."""
    frames = traceback.extract_tb(error.__traceback__)
    file = getattr(sys.modules.get(type(engine).__module__), "__file__", "")
    of_engine = [frame for frame in frames if frame.filename == file]
    place = [*frames, *of_engine][-1]
    text = " ".join(f"{type(error).__name__}: {error}".split()).strip(": ")[:160]
    message = (
        f"{engine_label(engine)}: {call} raised {text} "
        f"({Path(place.filename).name}, line {place.lineno}), "
        "must raise an EngineError, or return one for the job"
    )
    return EngineError(message).with_log("".join(traceback.format_exception(error)))


def _checked(engine: Engine, job: Job, outcome: Any) -> Output | EngineError:
    """Return the outcome of a job, an error in place of one that is none or left values unread."""
    if isinstance(outcome, EngineError):
        return outcome
    flaw = _flaw(outcome)
    if flaw:
        return _error(engine, "run", f"returned {flaw[0]}", flaw[1])
    if ignored := _unread(job):
        pairs = ", ".join(f"{name} = {job.values.get(name)!r}" for name in ignored)
        return EngineOutputError(
            f"{engine_label(engine)}: run ignored {pairs} of template {job.template.name!r}, "
            "must read them, or refuse the job (refuses)"
        )
    output: Output = outcome
    engine.pace.add(_steps(job, output), output.seconds)
    return output


def _unread(job: Job) -> list[str]:
    """Return the values that change the motion and that were not read."""
    if not isinstance(job.values, ReadValues):
        return []
    read = set(job.values.read)
    neutral = job.template.neutral
    some = dict.items(job.values)
    return [n for n, v in some if n in neutral and v != neutral[n] and n not in read]


def _flaw(outcome: Any) -> tuple[str, str] | None:
    """Return what is wrong with an output, and what was expected; None where nothing is."""
    import numpy as np

    if not isinstance(outcome, Output):
        return f"a {type(outcome).__name__} for a job", "an Output or an EngineError"
    if not isinstance(outcome.provenance, Provenance):
        return f"an Output of {type(outcome.provenance).__name__}", "a Provenance in it"
    if not isinstance(outcome.tables, Mapping):
        return f"tables in a {type(outcome.tables).__name__}", "them by name, each columns by name"
    for name, table in outcome.tables.items():
        if not isinstance(table, Mapping):
            return f"table {name!r} as a {type(table).__name__}", "columns by name"
        lengths = {}
        for column, values in table.items():
            numbers = isinstance(values, np.ndarray) and values.dtype.kind in "fiub"
            if not numbers or values.ndim not in (1, 2):
                kind = f"{values.dtype} array" if isinstance(values, np.ndarray) else ""
                kind = kind or type(values).__name__
                expected = "an array of numbers, (M,) or (M, N)"
                return f"column {column!r} of table {name!r} as a {kind}", expected
            lengths[column] = len(values)
        if len(set(lengths.values())) > 1:
            sizes = ", ".join(f"{column}: {length}" for column, length in lengths.items())
            return f"table {name!r} with columns of several lengths ({sizes})", "one for all"
    if not isinstance(outcome.seconds, (int, float)):
        return f"seconds as a {type(outcome.seconds).__name__}", "a number"
    return None


def _steps(job: Job, output: Output) -> float:
    """Return the steps of a run as far as they are known, weighted by the particles."""
    table = output.tables.get(SERIES, {})
    if "step" in table and len(table["step"]):
        steps = float(table["step"][-1])
    elif output.has("steps"):
        steps = output.number("steps")
    else:
        steps = float(job.values.get("steps", 0.0))
    place = table.get("x_m")
    particles = place.shape[1] if place is not None and place.ndim == 2 else 1
    return steps * max(1.0, particles / PARTICLES)
