"""Engines as options name them: opened with their programs, the cache, or a cluster.

Options are fields of frozen dataclasses, of which cyclopts makes options and help.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.app import ENGINE, KEPT, Folder, Name
from harness.cli.output import print_json, tell
from harness.errors import EngineError, HarnessError, RequestError

if TYPE_CHECKING:
    from harness.engines.base import Engine
    from harness.store.cache import CachedEngine
    from harness.store.entries import Entries
    from harness.workflows.progress import Progress

OWN_OPTIONS = {"lammps": {"lmp": "--lmp", "launcher": "--mpirun"},
               "reference": {"integrator": "--integrator"}}  # fmt: skip
"""Options of engines' classes that the command line has a word of its own for."""
UNQUALIFIED = ("lammps", "reference")  # need not qualify: one is tested, one is held against


@Parameter(name="*", group=KEPT)
@dataclass(frozen=True, kw_only=True)
class CacheOptions:
    """Where results are kept, and whether they are used."""

    cache: Annotated[Folder, Parameter(group=KEPT)] = None
    """Where results are kept, up to 2 GiB. [default: DEM_HARNESS_HOME/cache, else
    ~/.cache/dem-harness]"""
    fresh: Annotated[bool, Parameter(group=KEPT)] = False
    """Run everything again, whatever is kept."""


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

    def check(self, names: Iterable[str], option: str) -> None:
        """Raise RequestError for a program or option whose engine ``option`` does not name."""
        from harness.engines import registry

        names = list(names)
        programs = registry.named_values(self.program or (), "--program")
        settings = registry.engine_settings(self.engine_option or ())
        registry.check_options(programs, settings, names, option)
        for engine, words in OWN_OPTIONS.items():
            for word in words.values():
                value = getattr(self, word.removeprefix("--"))
                if value is not None and engine not in names:
                    raise RequestError(f"{word} {value!r}: goes with {option} {engine} only")

    def opening(self, name: str) -> dict[str, Any]:
        """Return what opens an engine. Raise RequestError for an option that it does not take."""
        from harness.engines import registry

        programs = registry.named_values(self.program or (), "--program")
        settings = registry.engine_settings(self.engine_option or ()).get(name, {})
        words = OWN_OPTIONS.get(name, {})
        texts = {key: getattr(self, word.removeprefix("--")) for key, word in words.items()}
        spelled = {key: value for key, value in texts.items() if value is not None}
        options = {**settings, **spelled, "program": programs.get(name)}
        return registry.chosen_options(name, options, {key: words[key] for key in spelled})


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class EngineOptions(ProgramOptions, CacheOptions):
    """Programs of engines, kept results, and a cluster."""

    dask: Annotated[str | None, Parameter(metavar="ADDRESS|slurm")] = None
    """Run in the workers of a Dask cluster, at its scheduler's address; or in SLURM with the
    settings of your jobqueue.yaml, slurm:JOBS in so many jobs (8). Needs dem-harness[dask]."""

    @contextmanager
    def executor(self) -> Iterator[Executor | None]:
        """Yield the executor of the cluster; None without one."""
        from harness.workflows.executors import dask_executor

        with nullcontext() if self.dask is None else dask_executor(self.dask, tell) as executor:
            yield executor


@dataclass
class Opener:
    """Opens engines by name, qualifies them, and counts their runs.

    ``failures`` has the reason why an engine does not qualify, empty where it does, by name.
    """

    options: EngineOptions
    executor: Executor | None = None
    engines: dict[str, CachedEngine] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)

    @contextmanager
    def __call__(self, name: str) -> Iterator[Engine]:
        """Yield an engine, which keeps its runs where there is a cache; close it after use."""
        from harness.engines.registry import new_engine
        from harness.store.cache import CachedEngine
        from harness.workflows.executors import ExecutorEngine

        options, entries = self.options.opening(name), self.entries()
        with new_engine(name, options) as bare:
            engine: Engine = bare
            if self.executor is not None:
                engine = ExecutorEngine(engine, self.executor, name, options)
            if entries is not None:
                engine = CachedEngine(engine, entries, fresh=self.options.fresh)
                self.engines[name] = engine
            yield engine

    @contextmanager
    def qualified(self, name: str, *, progress: Progress) -> Iterator[Engine]:
        """Yield an engine; after its use find out whether it qualifies, where it needs to."""
        from harness.workflows.verification import qualification

        with self(name) as engine:
            yield engine
            if engine.name in UNQUALIFIED:
                return
            progress(f"qualification of {engine.name}", 0, 1)
            try:
                self.failures[name] = qualification(engine)
            except EngineError as error:
                self.failures[name] = str(error)

    @contextmanager
    def measuring(
        self, name: str, title: str, *, quiet: bool, solvers: Sequence[str] = ()
    ) -> Iterator[dict[str, Any]]:
        """Yield a qualified engine, or the name of a solver, and progress, for a workflow."""
        from harness.workflows.progress import progress_bars

        with progress_bars(title, quiet=quiet) as progress:
            if name in solvers:
                yield {"solver": name, "progress": progress}
                return
            with (
                self.options.executor() as self.executor,
                self.qualified(name, progress=progress) as engine,
            ):
                yield {"engine": engine, "progress": progress}

    def entries(self) -> Entries | None:
        """Return the cache; None, with a note, where the default place cannot be written.

        Raise RequestError for a named place that cannot.
        """
        from harness.files import cache_place
        from harness.store.entries import Entries

        place = cache_place(self.options.cache)
        try:
            return Entries(place.path)
        except OSError as error:
            reason = error.strerror or str(error)
            if place.named_by:
                named = f"{place.named_by} {place.path}"
                raise RequestError(f"{named}: cannot be used ({reason})") from None
            tell(f"cache {place.path} cannot be written ({reason}); nothing is kept")
            return None

    def runs(self) -> dict[str, int]:
        """Return the numbers of runs that were made and that were kept."""
        if not self.engines:
            return {}
        engines = self.engines.values()
        counts = sum(engine.ran for engine in engines), sum(engine.read for engine in engines)
        return {"engine_runs": counts[0], "engine_runs_from_cache": counts[1]}

    def answer(
        self,
        record: Mapping[str, Any],
        json: bool,
        show: Callable[[Mapping[str, Any]], object],
    ) -> int:
        """Print the record of an engine; return 0, or 3, with the reason, if it did not qualify."""
        record = dict(record)
        for reason in self.failures.values():
            record |= {"qualified": not reason, "qualification_failures": reason}
        record |= self.runs()
        (print_json if json else show)(record)
        for name, reason in self.failures.items():
            if reason:
                tell(f"engine {name!r} did not qualify, its result is not to be used: {reason}")
                return HarnessError.exit_status
        return 0


MOST_SECONDS = 600.0  # longer runs are refused without --force
STATED_SECONDS = 60.0  # the expected time of longer runs is printed before they begin
SMALLER = "a coarser step, a softer contact or a smaller system"


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
