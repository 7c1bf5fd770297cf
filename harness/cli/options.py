"""Options that commands share, and the engines that they open.

Options are fields of frozen dataclasses, of which cyclopts makes options and help.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter, Token

from harness import workflows
from harness.cli.output import Record, show, tell
from harness.errors import HarnessError, RequestError
from harness.files import cache_place

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from harness.engines.base import Engine
    from harness.store.cache import Entries

ENGINE, KEPT = Group("Engine", sort_key=2), Group("Kept results", sort_key=3)
OWN_WORDS = {  # options of engines' classes with a word of their own, by engine
    "lammps": {"lmp": "--lmp", "launcher": "--mpirun"},
    "reference": {"integrator": "--integrator"},
}
UNQUALIFIED = ("lammps", "reference")  # need not qualify: one is tested, one is held against
MOST_SECONDS = 600.0  # longer runs are refused without --force
STATED_SECONDS = 60.0  # the expected time of longer runs is printed before they begin
SMALLER = "a coarser step, a softer contact or a smaller system"
MOST_NUMBER = 10_000  # of a range


# ---- values


def _read_by(read: Callable[[str], Any], must: str) -> Parameter:
    """Return an option that a function reads from its texts, with commas between.

    RequestError for a ValueError of the function: ``must`` is what is allowed.
    """

    def convert(_: Any, tokens: Sequence[Token]) -> Any:
        text = ",".join(token.value for token in tokens)
        try:
            return read(text)
        except ValueError:
            raise RequestError(f"{tokens[0].keyword} {text!r}: must be {must}") from None

    return Parameter(converter=convert)


def _ranges(text: str) -> list[int]:
    """Return the whole numbers of a text as 1-19 or 1,2,5, each once."""
    chosen = dict[int, None]()
    for part in text.split(","):
        start, dash, end = part.partition("-")
        first, last = int(start), int(end if dash else start)
        if not 1 <= first <= last <= MOST_NUMBER:
            raise ValueError
        chosen |= dict.fromkeys(range(first, last + 1))
    return list(chosen)


def _path(text: str) -> Path:
    """Return a path, which would be the current folder for an empty text."""
    if not text:
        raise ValueError
    return Path(text)


PATH = _read_by(_path, "a path")
Json = Annotated[bool, Parameter(help="Print one JSON object on stdout, and nothing else.")]
Folder = Annotated[Path | None, PATH, Parameter(metavar="DIR")]
File = Annotated[Path | None, PATH, Parameter(metavar="FILE")]
Name = Annotated[str | None, Parameter(metavar="NAME")]
Command = Annotated[str | None, Parameter(metavar="COMMAND")]
NewFolder = Annotated[
    Path | None, PATH, Parameter(metavar="DIR", help="A new folder for the report and its tables.")
]
CASES = "Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and tower]"
Cases = Annotated[str | None, Parameter(metavar="NAME[,NAME...]", help=CASES)]
ONLY = (
    "Run what matches case/setup/quantity, its start or its end, in all cases unless --cases "
    "names some, as 'oblique/hertz*' or '*rim_speed_ratio'."
)
Only = Annotated[str, Parameter(metavar="PATTERN", help=ONLY)]
Settings = Annotated[list[str] | None, Parameter(name="--set", metavar="NAME=VALUE")]
WHOLE = _read_by(int, "a whole number")  # cyclopts would round 1.5
Whole = Annotated[int, WHOLE]
MaybeWhole = Annotated[int | None, WHOLE]
Number = float | None
Numbers = Annotated[
    list[float] | None,
    _read_by(lambda text: [*dict.fromkeys(map(float, text.split(",")))],
             "a number, or several with commas"),
    Parameter(metavar="NUMBERS"),
]  # fmt: skip
RANGES = f"whole numbers or ranges that rise, as 1-19, within 1 to {MOST_NUMBER}"
WholeNumbers = Annotated[list[int] | None, _read_by(_ranges, RANGES), Parameter(metavar="NUMBERS")]


# ---- engines


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
        from harness.store.cache import Entries

        place, named_by = cache_place(self.cache)
        try:
            return Entries(place)
        except OSError as error:
            reason = error.strerror or str(error)
        if named_by:
            raise RequestError(f"{named_by} {place}: cannot be used ({reason})")
        tell(f"cache {place} cannot be written ({reason}); nothing is kept")
        return None


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class ProgramOptions:
    """Where the programs of engines are, and the options of their classes."""

    lmp: Command = None
    """A LAMMPS executable of your own, with its arguments if need be, as in
    --lmp "lmp -sf omp"."""
    mpirun: Command = None
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
        for engine in OWN_WORDS.keys() - set(names):
            for key, value in self._own_options(engine).items():
                word = OWN_WORDS[engine][key]
                raise RequestError(f"{word} {value!r}: goes with {option} {engine} only")

    def opening(self, name: str) -> dict[str, Any]:
        """Return what opens an engine. Raise RequestError for an option that it does not take."""
        from harness.engines.registry import chosen_options, engine_settings

        typed, settings = self._own_options(name), engine_settings(self.engine_option or ())
        options = {**settings.get(name, {}), **typed, "program": self.programs().get(name)}
        return chosen_options(name, options, {key: OWN_WORDS[name][key] for key in typed})

    def _own_options(self, engine: str) -> dict[str, str]:
        words = OWN_WORDS.get(engine, {})
        values = {key: getattr(self, word.removeprefix("--")) for key, word in words.items()}
        return {key: value for key, value in values.items() if value is not None}


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class EngineOptions(ProgramOptions, CacheOptions):
    """Programs of engines, kept results, a cluster, and how long runs may take."""

    dask: Annotated[str | None, Parameter(metavar="ADDRESS|slurm")] = None
    """Run in the workers of a Dask cluster, at its scheduler's address; or in SLURM with the
    settings of your jobqueue.yaml, slurm:JOBS in so many jobs (8). Needs dem-harness[dask]."""
    force: bool = False
    """Run also what is expected to take more than ten minutes of a core."""

    def check_no_cluster(self, solver: str) -> None:
        """Raise RequestError for a cluster, which a solver of this package does not use."""
        if self.dask is not None:
            raise RequestError(
                f"--dask {self.dask}: goes with engines; solver {solver!r} runs here"
            )

    def check_seconds(self, seconds: float, work: str, instead: str = SMALLER) -> None:
        """Print an expected time [s] that is long; raise RequestError for one that is too long.

        ``instead`` is what to request in place of the work.
        """
        text = f"an estimated {seconds / 60.0:.3g} minutes on one core"
        if not self.force and not seconds <= MOST_SECONDS:
            limit = f"{MOST_SECONDS / 60.0:g} minutes are the limit"
            raise RequestError(f"{work} would take {text}, {limit}: {instead}, or --force")
        if seconds > STATED_SECONDS:
            tell(f"{work}: {text}")


@dataclass
class Opener:
    """Opens engines by name for a command, qualifies them, and counts their runs.

    ``failures`` has the reason why an engine does not qualify, empty where it does, by name.
    """

    options: EngineOptions
    progress: workflows.Progress
    executor: Executor | None
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
            self.engines += [] if entries is None else [engine]
            yield engine

    @contextmanager
    def qualified(self, name: str) -> Iterator[Engine]:
        """Yield an engine; after its use find out whether it qualifies, where it needs to."""
        with self.opened(name) as engine:
            yield engine
            if engine.name not in UNQUALIFIED:
                from harness.workflows.session import qualification

                self.progress(f"qualification of {engine.name}", 0, 1)
                self.failures[name] = qualification(engine)

    def runs(self) -> dict[str, int]:
        """Return the numbers of runs that were made and that were kept."""
        ran, read = (sum(getattr(e, name) for e in self.engines) for name in ("ran", "read"))
        return {"engine_runs": ran, "engine_runs_from_cache": read} if self.engines else {}

    def show(self, record: Record, json: bool, text: Record | None = None) -> int:
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
    with workflows.progress_bars(title, quiet=quiet) as progress:
        if options.dask is None:
            yield Opener(options, progress, None)
            return
        from harness.workflows.executors import dask_executor

        with dask_executor(options.dask, tell) as executor:
            yield Opener(options, progress, executor)
