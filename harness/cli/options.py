"""Options that commands share, and engines as they name them: opened with programs and the cache.

Options are fields of frozen dataclasses, of which cyclopts makes options and help.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter, Token

from harness.cli.output import show, tell
from harness.errors import HarnessError, RequestError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from harness.engines.base import Engine
    from harness.store.cache import Entries
    from harness.workflows import Progress

ENGINE, KEPT = Group("Engine", sort_key=2), Group("Kept results", sort_key=3)
OWN_OPTIONS = {"lammps": {"lmp": "--lmp", "launcher": "--mpirun"},
               "reference": {"integrator": "--integrator"}}  # fmt: skip
"""Options of engines' classes that the command line has a word of its own for."""
UNQUALIFIED = ("lammps", "reference")  # need not qualify: one is tested, one is held against
MOST_SECONDS = 600.0  # longer runs are refused without --force
STATED_SECONDS = 60.0  # the expected time of longer runs is printed before they begin
MOST_NUMBER = 10_000  # of a range
SMALLER = "a coarser step, a softer contact or a smaller system"


def whole_number(_: Any, tokens: Sequence[Token]) -> int:
    """Return a whole number; cyclopts would round 1.5. Raise RequestError for anything else."""
    try:
        return int(tokens[0].value)
    except ValueError:
        option = f"{tokens[0].keyword or ''} {tokens[0].value!r}".strip()
        raise RequestError(f"{option}: must be a whole number") from None


def numbers(_: Any, tokens: Sequence[Token]) -> list[float]:
    """Return numbers with commas between, each once. Raise RequestError for anything else."""
    text = ",".join(token.value for token in tokens)
    try:
        return list(dict.fromkeys(map(float, text.split(","))))
    except ValueError:
        option = f"{tokens[0].keyword} {text!r}"
        raise RequestError(f"{option}: must be a number, or several with commas") from None


def whole_numbers(_: Any, tokens: Sequence[Token]) -> list[int]:
    """Return whole numbers of a text as 1-19 or 1,2,5, each once; raise RequestError for others."""
    text, chosen = ",".join(token.value for token in tokens), dict[int, None]()
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip(), re.ASCII)
        first, last = (int(ends[1]), int(ends[2] or ends[1])) if ends else (0, 0)
        if not 1 <= first <= last <= MOST_NUMBER:
            must = f"must be whole numbers or ranges that rise, as 1-19, within 1 to {MOST_NUMBER}"
            raise RequestError(f"{tokens[0].keyword} {text!r}: {must}")
        chosen |= dict.fromkeys(range(first, last + 1))
    return list(chosen)


Json = Annotated[bool, Parameter(help="Print one JSON object on stdout, and nothing else.")]
Folder = Annotated[Path | None, Parameter(metavar="DIR")]
File = Annotated[Path | None, Parameter(metavar="FILE")]
Name = Annotated[str | None, Parameter(metavar="NAME")]
NewFolder = Annotated[
    Path | None, Parameter(metavar="DIR", help="A new folder for the report and its tables.")
]
Cases = Annotated[
    str | None,
    Parameter(
        metavar="NAME[,NAME...]",
        help="Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and "
        "tower]",
    ),
]
Only = Annotated[
    str,
    Parameter(
        metavar="PATTERN",
        help="Run what matches case/setup/quantity, its start or its end, in all cases unless "
        "--cases names some, as 'oblique/hertz*' or '*rim_speed_ratio'.",
    ),
]
Settings = Annotated[list[str] | None, Parameter(name="--set", metavar="NAME=VALUE")]
Whole = Annotated[int, Parameter(converter=whole_number)]
MaybeWhole = Annotated[int | None, Parameter(converter=whole_number)]
Number = float | None
Numbers = Annotated[list[float] | None, Parameter(converter=numbers, metavar="NUMBERS")]
WholeNumbers = Annotated[list[int] | None, Parameter(converter=whole_numbers, metavar="NUMBERS")]
Force = Annotated[
    bool, Parameter(help="Run also what is expected to take more than ten minutes of a core.")
]


@Parameter(name="*", group=KEPT)
@dataclass(frozen=True, kw_only=True)
class CacheOptions:
    """Where results are kept, and whether they are used."""

    cache: Annotated[Folder, Parameter(group=KEPT)] = None
    """Where results are kept, up to 2 GiB. [default: DEM_HARNESS_HOME/cache, else
    ~/.cache/dem-harness]"""
    fresh: Annotated[bool, Parameter(group=KEPT)] = False
    """Run everything again, whatever is kept."""

    def entries(self) -> Entries | None:
        """Return the cache; None, with a note, where the default place cannot be written.

        Raise RequestError for a named place that cannot.
        """
        from harness.files import cache_place
        from harness.store.cache import Entries

        place = cache_place(self.cache)
        try:
            return Entries(place.path)
        except OSError as error:
            reason = error.strerror or str(error)
            if place.named_by:
                named = f"{place.named_by} {place.path}"
                raise RequestError(f"{named}: cannot be used ({reason})") from None
            tell(f"cache {place.path} cannot be written ({reason}); nothing is kept")
            return None


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class ProgramOptions:
    """Where the programs of engines are, and the options of their classes."""

    lmp: Annotated[str | None, Parameter(metavar="COMMAND")] = None
    """A LAMMPS executable of your own, with its arguments if need be, as in
    --lmp "lmp -sf omp"."""
    mpirun: Annotated[str | None, Parameter(metavar="COMMAND")] = None
    """An MPI launcher of LAMMPS with its options, as in --mpirun "mpirun -np 4"."""
    program: Annotated[list[str] | None, Parameter(metavar="NAME=PATH")] = None
    """The executable of an engine (of Kratos a Python that has it); repeat it for several."""
    engine_option: Annotated[list[str] | None, Parameter(metavar="NAME.KEY=VALUE")] = None
    """An option of an engine's class, as lammps.limits=60, the seconds a run may take (300);
    repeat it for several."""
    integrator: Name = None
    """Of the reference engine: velocity-verlet, as LAMMPS; mfix-euler, mfix-adams-bashforth, as
    MFiX. [default: velocity-verlet]"""

    def programs(self) -> dict[str, str]:
        """Return the executables by engine."""
        from harness.engines.registry import named_values

        return named_values(self.program or (), "--program")

    def check(self, names: Collection[str], option: str) -> None:
        """Raise RequestError for a program or option whose engine ``option`` does not name."""
        from harness.engines.registry import check_options, engine_settings

        check_options(self.programs(), engine_settings(self.engine_option or ()), names, option)
        for engine in OWN_OPTIONS:
            for word, value in self._words_of(engine).values():
                if engine not in names:
                    raise RequestError(f"{word} {value!r}: goes with {option} {engine} only")

    def opening(self, name: str) -> dict[str, Any]:
        """Return what opens an engine. Raise RequestError for an option that it does not take."""
        from harness.engines.registry import chosen_options, engine_settings

        words = self._words_of(name)
        options = {
            **engine_settings(self.engine_option or ()).get(name, {}),
            **{key: value for key, (_, value) in words.items()},
            "program": self.programs().get(name),
        }
        return chosen_options(name, options, {key: word for key, (word, _) in words.items()})

    def _words_of(self, engine: str) -> dict[str, tuple[str, str]]:
        """Return the word and value of each of an engine's own options that is given."""
        words = OWN_OPTIONS.get(engine, {})
        values = {key: getattr(self, word.removeprefix("--")) for key, word in words.items()}
        return {key: (words[key], v) for key, v in values.items() if v is not None}


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class EngineOptions(ProgramOptions, CacheOptions):
    """Programs of engines, kept results, and a cluster."""

    dask: Annotated[str | None, Parameter(metavar="ADDRESS|slurm")] = None
    """Run in the workers of a Dask cluster, at its scheduler's address; or in SLURM with the
    settings of your jobqueue.yaml, slurm:JOBS in so many jobs (8). Needs dem-harness[dask]."""


@dataclass
class Opener:
    """Opens engines by name for a command, qualifies them, and counts their runs.

    ``failures`` has the reason why an engine does not qualify, empty where it does, by name.
    """

    options: EngineOptions
    progress: Progress
    executor: Executor | None = None
    engines: list[Any] = field(default_factory=list)
    failures: dict[str, str] = field(default_factory=dict)

    @contextmanager
    def opened(self, name: str) -> Iterator[Engine]:
        """Yield an engine, which keeps its runs where there is a cache; close it after use."""
        from harness.store.cache import opened
        from harness.workflows.executors import remote_outcomes

        entries, fresh = self.options.entries(), self.options.fresh
        options = self.options.opening(name)
        remote = None if self.executor is None else partial(remote_outcomes, self.executor)
        with opened(name, fresh=fresh, options=options, entries=entries, remote=remote) as engine:
            if entries is not None:
                self.engines.append(engine)
            yield engine

    @contextmanager
    def qualified(self, name: str) -> Iterator[Engine]:
        """Yield an engine; after its use find out whether it qualifies, where it needs to."""
        with self.opened(name) as engine:
            yield engine
            if engine.name not in UNQUALIFIED:
                from harness.workflows.verification import qualification

                self.progress(f"qualification of {engine.name}", 0, 1)
                self.failures[name] = qualification(engine)

    def runs(self) -> dict[str, int]:
        """Return the numbers of runs that were made and that were kept."""
        ran, read = (sum(getattr(e, name) for e in self.engines) for name in ("ran", "read"))
        return {"engine_runs": ran, "engine_runs_from_cache": read} if self.engines else {}

    def answer(
        self, record: Mapping[str, Any], json: bool, text: Mapping[str, Any] | None = None
    ) -> int:
        """Print the record of an engine; return 0, or 3, with the reason, if it did not qualify."""
        record = dict(record)
        for reason in self.failures.values():
            record |= {"qualified": not reason, "qualification_failures": reason}
        show({**record, **self.runs()}, json, text)
        for name, reason in self.failures.items():
            if reason:
                tell(f"engine {name!r} did not qualify, its result is not to be used: {reason}")
                return HarnessError.exit_status
        return 0


@contextmanager
def opener(options: EngineOptions, title: str, quiet: bool) -> Iterator[Opener]:
    """Yield what opens the engines of a command, in a cluster if need be; show its progress."""
    from harness.workflows import progress_bars

    with progress_bars(title, quiet=quiet) as progress:
        if options.dask is None:
            yield Opener(options, progress)
            return
        from harness.workflows.executors import dask_executor

        with dask_executor(options.dask, tell) as executor:
            yield Opener(options, progress, executor)


def duration_check(force: bool, work: str, instead: str = SMALLER) -> Callable[[float], None]:
    """Return a check of an expected time [s]: it prints a long one, and refuses one too long.

    ``instead`` is what to request in place of the work.
    """

    def check(seconds: float) -> None:
        text = f"an estimated {seconds / 60.0:.3g} minutes on one core"
        if not force and not seconds <= MOST_SECONDS:
            limit = f"{MOST_SECONDS / 60.0:g} minutes are the limit"
            raise RequestError(f"{work} would take {text}, {limit}: {instead}, or --force")
        if seconds > STATED_SECONDS:
            tell(f"{work}: {text}")

    return check
