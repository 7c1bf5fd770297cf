"""Engines as options name them: opened with their programs, the cache, or a cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.cli.app import CacheOptions, ProgramOptions
from harness.cli.output import print_json, tell
from harness.errors import EngineError, HarnessError, RequestError

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.store.entries import Entries
    from harness.workflows.progress import Progress

MOST_SECONDS, TOLD_SECONDS = 600.0, 60.0  # expected time on one core: refused, told


@dataclass
class Opener:
    """Opens engines by name; counts their runs. ``option`` is the option that names engines."""

    programs: ProgramOptions
    kept: CacheOptions
    executor: Executor | None = None
    option: str = "--engine"
    engines: dict[str, Engine] = field(default_factory=dict)
    qualification: dict[str, Any] = field(default_factory=dict)

    def check(self, names: Iterable[str]) -> None:
        """Raise RequestError for a program or option whose engine does not run."""
        from harness.engines import registry

        names = list(names)
        programs = registry.named_values(self.programs.program or (), "--program")
        registry.check_known(programs, "--program")
        settings = registry.engine_settings(self.programs.engine_option or ())
        registry.check_names(programs, settings, names, self.option)
        for option, value, engine in (
            ("--lmp", self.programs.lmp, "lammps"),
            ("--mpirun", self.programs.mpirun, "lammps"),
            ("--integrator", self.programs.integrator, "reference"),
        ):
            if value is not None and engine not in names:
                raise RequestError(f"{option} {value!r}: goes with {self.option} {engine} only")
        registry.check_launcher(self.programs.mpirun)

    def options(self, name: str) -> dict[str, Any]:
        """Return what opens an engine. Raise RequestError for an option that it does not take."""
        from harness.engines import registry

        programs = registry.named_values(self.programs.program or (), "--program")
        settings = registry.engine_settings(self.programs.engine_option or ()).get(name, {})
        own: dict[str, str | None] = {}
        if name == "lammps":
            own = {"lmp": self.programs.lmp, "launcher": self.programs.mpirun}
        elif name == "reference":
            own = {"integrator": self.programs.integrator}
        return registry.chosen_options(name, programs.get(name), settings, **own)

    @contextmanager
    def __call__(self, name: str) -> Iterator[Engine]:
        """Yield an engine, which keeps its runs where there is a cache; close it after use."""
        from harness.engines.registry import engine_class
        from harness.store.cache import CachedEngine
        from harness.workflows.executors import ExecutorEngine

        options, entries = self.options(name), self.entries()
        with engine_class(name)(**options) as opened:
            engine: Engine = opened
            if self.executor is not None:
                engine = ExecutorEngine(engine, self.executor, name, options)
            if entries is not None:
                engine = CachedEngine(engine, entries, fresh=self.kept.fresh)
            self.engines[name] = engine
            yield engine

    @contextmanager
    def qualified(self, name: str, *, progress: Progress) -> Iterator[Engine]:
        """Yield an engine; after its use keep in ``qualification`` whether it qualifies.

        A wrong request is refused before.
        """
        with self(name) as engine:
            yield engine
            self.qualification = qualified(engine, progress)

    def entries(self) -> Entries | None:
        """Return the cache; None, with a note, where the default place cannot be written.

        Raise RequestError for a named place that cannot.
        """
        from harness.files import cache_place
        from harness.store.entries import Entries

        place = cache_place(self.kept.cache)
        try:
            return Entries(place.path)
        except OSError as error:
            reason = error.strerror or str(error)
            if place.named_by:
                raise place.refused(reason) from None
            tell(f"cache {place.path} cannot be written ({reason}); nothing is kept")
            return None

    def runs(self) -> dict[str, int]:
        """Return the numbers of runs that were made and that were kept."""
        kept = [engine for engine in self.engines.values() if hasattr(engine, "ran")]
        if not kept:
            return {}
        ran, read = sum(e.ran for e in kept), sum(e.read for e in kept)  # type: ignore[attr-defined]
        return {"engine_runs": ran, "engine_runs_from_cache": read}


@contextmanager
def executor_of(dask: str | None) -> Iterator[Executor | None]:
    """Yield the executor of ``--dask``; None without."""
    if dask is None:
        yield None
        return
    from harness.workflows.executors import dask_executor

    with dask_executor(dask, tell) as executor:
        yield executor


def duration_check(force: bool, work: str, instead: str = "") -> Callable[[float], None]:
    """Return a check of an expected time [s]: it prints a long one, and refuses one too long."""

    def check(seconds: float) -> None:
        from harness.engines.cost import check_duration, in_words

        if not force:
            check_duration(seconds, work, instead)
        if seconds > TOLD_SECONDS:
            tell(f"{work}: an estimated {in_words(seconds)} on one core")

    return check


def qualified(engine: Engine | None, progress: Progress) -> dict[str, Any]:
    """Return whether an engine qualifies; nothing for LAMMPS, the reference and solvers."""
    from harness.workflows.session import qualification

    if engine is None or engine.name in ("lammps", "reference"):
        return {}
    progress(f"qualification of {engine.name}", 0, 1)
    try:
        reason = qualification(engine)
    except EngineError as error:
        reason = str(error)
    return {"qualified": not reason, "qualification_failures": reason}


def answer(
    record: Mapping[str, Any], engine: str, json: bool, show: Callable[[Mapping[str, Any]], None]
) -> int:
    """Print a record; return 0, or 3, with the reason, where its engine did not qualify."""
    (print_json if json else show)(record)
    if record.get("qualified", True):
        return 0
    reason = record["qualification_failures"]
    tell(f"engine {engine!r} did not qualify, its result is not to be used: {reason}")
    return HarnessError.exit_status


@contextlib.contextmanager
def closed_pipe_allowed() -> Iterator[None]:
    """Go on where the reader of stdout has seen enough: the exit status is still to come."""
    try:
        yield
    except BrokenPipeError:
        pass
    except SystemExit as ending:  # as rich ends then
        if not isinstance(ending.__context__, BrokenPipeError):
            raise
