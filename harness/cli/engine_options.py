"""Options that choose an engine, its program, its cache or a solver, and what they open.

The options that choose an engine, its program and its cache; open what they ask for.

The option ``--solver``: a solver of the harness, or an engine.

End a command that ran one engine: whether that qualifies is told beside what it measured.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from harness.cli.files import print_json
from harness.errors import EngineError, HarnessError, RequestError
from harness.report.plain import printable

if TYPE_CHECKING:
    from harness.cli.recording import Recording
    from harness.engines.contract import Engine
    from harness.store.entries import Entries


@dataclass(frozen=True)
class CacheOptions:
    """Where results are kept, and whether they are used."""

    cache: Path | None = None
    fresh: bool = False

    def entries(self) -> Entries | None:
        """Return the cache; None, with a note on stderr, where the default place is not writable.

        Raise RequestError for a place that was named.
        """
        from harness.files import cache_place
        from harness.store.entries import Entries, tell_stderr

        place = cache_place(self.cache)
        try:
            return Entries(place.path)
        except OSError as error:
            why = error.strerror or str(error)
            if place.named_by:
                raise place.refused(why) from None
            tell_stderr(f"cache {place.path} cannot be written ({why}); nothing is kept")
            return None


@dataclass(frozen=True)
class WhereOptions:
    """Where the programs of engines are."""

    lmp: str | None = None
    mpirun: str | None = None
    program: list[str] | None = None

    @property
    def programs(self) -> dict[str, str]:
        """Return the programs by the engines' names; raise RequestError for what is no pair."""
        from harness.engines.typed import named_values

        return named_values(self.program or (), "--program")


@dataclass(frozen=True)
class ProgramOptions(CacheOptions, WhereOptions):
    """How engines are run: programs, launcher, options of their classes."""

    engine_option: list[str] | None = None

    def opening(self, name: str, integrator: str | None = None) -> dict[str, Any]:
        """Return what opens an engine, as the functions of the registry take it.

        Raise RequestError for options that cannot be read.
        """
        from harness.engines.typed import check_launcher, engine_settings

        check_launcher(self.mpirun)
        return {
            "program": self.programs.get(name),
            "options": engine_settings(self.engine_option or ()).get(name, {}),
            "lmp": self.lmp,
            "launcher": self.mpirun,
            "integrator": integrator,
        }

    def check_names(self, asked: Iterable[str], option: str = "--engine") -> None:
        """Raise RequestError for a program or option whose engine is not asked for.

        ``asked`` are the engines that will run, ``option`` is how one is asked for.
        """
        from harness.engines import typed

        settings = typed.engine_settings(self.engine_option or ())
        typed.check_names(self.programs, settings, asked, option)

    @contextlib.contextmanager
    def open(self, name: str, integrator: str | None = None) -> Iterator[Engine]:
        """Yield an engine, keeping its runs where there is a cache; close it after use."""
        from harness.engines.registry import open_engine

        entries = self.entries()
        with open_engine(name, **self.opening(name, integrator)) as opened:
            yield cached(opened, entries, self.fresh)


Chosen = TypeVar("Chosen", bound=ProgramOptions)


def with_restarts(options: Chosen, engines: Iterable[str], seconds: float = math.inf) -> Chosen:
    """Return options with which long runs leave restart files in the cache, where there is one.

    ``seconds`` is the limit of time that engines are given, unless they are given one already.
    """
    from time import time_ns

    from harness.engines.registry import options_of
    from harness.engines.typed import engine_settings
    from harness.files import RESTARTS, cache_place

    place = cache_place(options.cache).path.absolute() / RESTARTS
    if options.fresh:  # these are runs of their own
        place /= f"fresh-{time_ns()}"
    given, known = list(options.engine_option or ()), engine_settings(options.engine_option or ())
    more = {"restarts": str(place), "limits": f"{seconds:g}" if math.isfinite(seconds) else None}
    for name in engines:
        taken = options_of(name)
        for key, value in more.items():
            if key in taken and value is not None and key not in known.get(name, {}):
                given.append(f"{name}.{key}={value}")
    return replace(options, engine_option=given)


@dataclass(frozen=True)
class IntegratorOptions(ProgramOptions):
    """How engines are run, the reference engine's integrator among it."""

    integrator: str | None = None


@dataclass(frozen=True)
class CostOptions:
    """What a long run needs."""

    force: bool = False

    def agree(self, seconds: float, what: str, most: float | None = None, *instead: str) -> None:
        """State a long run's expected time; raise RequestError above ``most`` unless forced.

        That is the limit of engines unless given [s]; ``instead`` is what could be asked for.
        """
        from harness.engines.border import STATED_SECONDS, in_words, refuse_endless
        from harness.store.entries import tell_stderr

        if not self.force:
            refuse_endless(seconds, what, most, *instead)
        if seconds > STATED_SECONDS:
            tell_stderr(f"{what}: an estimated {in_words(seconds)} on one core")


@dataclass(frozen=True)
class EngineOptions(IntegratorOptions):
    """One engine of the user's choice."""

    engine: str = "lammps"

    def run(self) -> contextlib.AbstractContextManager[Engine]:
        """Return the engine to be entered, after a look at the options that go with it."""
        self.check_names([self.engine])
        return self.open(self.engine, self.integrator)

    def without_launcher(self) -> EngineOptions:
        """Return the same options for engines beside the main one: its executable is not theirs."""
        return replace(self, lmp=None, mpirun=None)


def cached(opened: Engine, entries: Entries | None, fresh: bool) -> Engine:
    """Return an open engine as one that keeps its runs, where there is a cache."""
    from harness.store.cache import CachedEngine

    return opened if entries is None else CachedEngine(opened, entries, fresh=fresh)


def runs_made(engine: Engine | None) -> dict[str, int]:
    """Return how many runs an engine made and how many were kept ones, where it counts them."""
    from harness.store.cache import CachedEngine

    if not isinstance(engine, CachedEngine):
        return {}
    return {"engine_runs": engine.ran, "engine_runs_from_cache": engine.read}


OWN = ("rk4", "exact")
"""Solvers of the harness, spelled out: --help must not wait for numba."""


@dataclass(frozen=True)
class SolverOptions(ProgramOptions):
    """What runs the towers."""

    solver: str = "rk4"

    @property
    def own(self) -> str | None:
        """Return the solver of the harness that is asked for, None for an engine."""
        return self.solver if self.solver in OWN else None

    @contextmanager
    def run(self) -> Iterator[Engine | None]:
        """Yield the engine that is asked for; None for a solver of the harness.

        Raise RequestError for a name that is not known, and for options of another engine.
        """
        from harness.engines.registry import engine_class

        for name, value in (("--lmp", self.lmp), ("--mpirun", self.mpirun)):
            if value is not None and self.solver != "lammps":
                raise RequestError(f"{name} {value!r}: goes with --solver lammps only")
        self.check_names({self.solver} - set(OWN), "--solver")
        if self.own:
            yield None
            return
        try:
            engine_class(self.solver)
        except RequestError as error:
            text = str(error).replace("--engine", "--solver", 1)
            raise RequestError(f"{text}; or a solver of the harness: {', '.join(OWN)}") from None
        with self.open(self.solver) as engine:
            yield engine

    @property
    def own_record(self) -> dict[str, str]:
        """Return what the history is told of a solver of the harness, which has its version."""
        from harness import __version__

        return {"engine": self.solver, "engine_version": __version__, "how": "solver"}


def completed(record: Mapping[str, Any], engine: Engine | None, told: Recording) -> dict[str, Any]:
    """Return a record with whether its engine qualifies, and how many runs were made or kept.

    An engine that does not qualify sets the status to 3. Nothing is added for a solver of the
    harness. Ask after the result, which raises RequestError for a wrong request at once; kept
    runs are not repeated.
    """
    full = {**record, **qualification(engine, told), **runs_made(engine)}
    told.engine = full
    return full


def answer(
    record: Mapping[str, Any], engine: str, json: bool, show: Callable[[Mapping[str, Any]], None]
) -> None:
    """Print a record, and end with status 3 and the reason where its engine did not qualify."""
    import typer

    from harness.store.entries import tell_stderr

    (print_json if json else show)(record)
    if not record.get("qualified", True):
        reason = printable(record["qualification_failures"])
        tell_stderr(f"engine {engine!r} did not qualify, its result is not to be used: {reason}")
        raise typer.Exit(HarnessError.exit_status)


def qualification(engine: Engine | None, told: Recording) -> dict[str, Any]:
    """Qualify an engine and return what a record says of it; one that fails sets the status to 3.

    Nothing of those that others are held against.
    """
    from harness.cases.qualification import qualify
    from harness.engines.registry import ALWAYS
    from harness.store.entries import tell_stderr

    if engine is None or engine.name in ALWAYS:
        return {}
    told.progress(f"qualification of {engine.name}", 0, 1)
    try:
        reason = qualify(engine, tell=tell_stderr).reason
    except EngineError as error:
        reason = str(error)
    if reason:
        told.status = HarnessError.exit_status
    return {"qualified": not reason, "qualification_failures": reason}
