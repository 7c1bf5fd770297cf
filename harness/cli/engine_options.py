"""The options that choose an engine, its program and its cache; open what they ask for."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
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
        from harness.home import cache_place
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
    from harness.home import RESTARTS, cache_place

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
        from harness.engines.cost import STATED_SECONDS, in_words, refuse_endless
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
    from harness.store.cached_engine import CachedEngine

    return opened if entries is None else CachedEngine(opened, entries, fresh=fresh)


def runs_made(engine: Engine | None) -> dict[str, int]:
    """Return how many runs an engine made and how many were kept ones, where it counts them."""
    from harness.store.cached_engine import CachedEngine

    if not isinstance(engine, CachedEngine):
        return {}
    return {"engine_runs": engine.ran, "engine_runs_from_cache": engine.read}
