"""The options that choose an engine, its program and its cache; open what they ask for."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.lists import engine_settings, named_values

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.store.entries import Entries

_ENGINE, _KEPT = "Engine", "Kept results"

EngineName = Annotated[
    str,
    typer.Option(
        "--engine",
        metavar="NAME",
        help="The engine to run: a name that `dem-harness engines` lists, or `module:Class` of "
        "one of your own.",
        rich_help_panel=_ENGINE,
    ),
]
Lmp = Annotated[
    str | None,
    typer.Option(
        "--lmp",
        metavar="PATH",
        help="A LAMMPS executable of your own. Without it, LAMMPS runs in-process.",
        rich_help_panel=_ENGINE,
    ),
]
Mpirun = Annotated[
    str | None,
    typer.Option(
        "--mpirun",
        metavar="COMMAND",
        help='An MPI launcher of LAMMPS with its options, as in `--mpirun "mpirun -np 4"`.',
        rich_help_panel=_ENGINE,
    ),
]
Programs = Annotated[
    list[str] | None,
    typer.Option(
        "--program",
        metavar="NAME=PATH",
        help="The executable of an engine (of Kratos a Python that has it); repeat it for several.",
        rich_help_panel=_ENGINE,
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--engine-option",
        metavar="NAME.KEY=VALUE",
        help="An option of an engine's class; repeat it for several.",
        rich_help_panel=_ENGINE,
    ),
]
Integrator = Annotated[
    str | None,
    typer.Option(
        "--integrator",
        metavar="NAME",
        help="Of the reference engine. `velocity-verlet`: as LAMMPS. `mfix-euler`, "
        "`mfix-adams-bashforth`: as MFiX-DEM (with --half-mass). `rk4`: fourth order. `adaptive`: "
        "high order, contact changes located; has no step, --steps-per-contact is ignored.  "
        "[default: velocity-verlet]",
        rich_help_panel=_ENGINE,
    ),
]
Cache = Annotated[
    Path | None,
    typer.Option(
        "--cache",
        metavar="DIR",
        help="Where results are kept, up to 1 GiB.  [default: DEM_HARNESS_HOME/cache, "
        "else ~/.cache/dem-harness]",
        rich_help_panel=_KEPT,
    ),
]
Fresh = Annotated[
    bool,
    typer.Option("--fresh", help="Run everything again, whatever is kept.", rich_help_panel=_KEPT),
]


@dataclass(frozen=True)
class CacheOptions:
    """Where results are kept, and whether they are used."""

    cache: Cache = None
    fresh: Fresh = False

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
class ProgramOptions(CacheOptions):
    """How engines are run: programs, launcher, options of their classes."""

    lmp: Lmp = None
    mpirun: Mpirun = None
    program: Programs = None
    engine_option: Settings = None

    def chosen(self, name: str, integrator: str | None = None) -> Chosen:
        """Return how an engine is opened; raise RequestError for options that cannot be read."""
        _check_launcher(self.mpirun)
        programs = named_values(self.program or (), "--program")
        settings = engine_settings(self.engine_option or ())
        return Chosen(name, self.lmp, self.mpirun, integrator, programs, settings.get(name, {}))

    def check_names(self, asked: Iterable[str], option: str = "--engine") -> None:
        """Raise RequestError for a program or option whose engine is not asked for.

        ``asked`` are the engines that will run, ``option`` is how one is asked for.
        """
        from harness.engines.programs import find_program
        from harness.errors import RequestError

        names = set(asked)
        programs = named_values(self.program or (), "--program")
        for name, path in programs.items():
            if name not in names:
                raise RequestError(f"--program {name}={path}: goes with {option} {name} only")
            find_program(f"program {name}", path)
        for name in engine_settings(self.engine_option or ()):
            if name not in names:
                raise RequestError(f"--engine-option {name}: goes with {option} {name} only")

    @contextlib.contextmanager
    def open(self, name: str, integrator: str | None = None) -> Iterator[Engine]:
        """Yield an engine, keeping its runs where there is a cache; close it after use."""
        from harness.engines.registry import open_engine

        entries = self.entries()
        with (
            open_engine(name, **self.chosen(name, integrator).arguments()) as opened,
            cached(opened, entries, self.fresh) as engine,
        ):
            yield engine


@dataclass(frozen=True)
class EngineOptions(ProgramOptions):
    """One engine of the user's choice."""

    engine: EngineName = "lammps"
    integrator: Integrator = None

    def main(self) -> Chosen:
        """Return how the engine is opened."""
        return self.chosen(self.engine, self.integrator)

    def run(self) -> contextlib.AbstractContextManager[Engine]:
        """Return the engine to be entered, after a look at the options that go with it."""
        self.check_names([self.engine])
        return self.open(self.engine, self.integrator)

    def without_launcher(self) -> EngineOptions:
        """Return the same options for engines beside the main one: its executable is not theirs."""
        return replace(self, lmp=None, mpirun=None)


@dataclass(frozen=True)
class Chosen:
    """How one engine is opened: as :func:`harness.engines.registry.open_engine` takes it."""

    name: str
    lmp: str | None = None
    launcher: str | None = None
    integrator: str | None = None
    programs: Mapping[str, str] | None = None
    settings: Mapping[str, str] | None = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the registry's functions beside the name."""
        return {
            "program": (self.programs or {}).get(self.name),
            "options": self.settings,
            "lmp": self.lmp,
            "launcher": self.launcher,
            "integrator": self.integrator,
        }


@contextlib.contextmanager
def cached(opened: Engine, entries: Entries | None, fresh: bool) -> Iterator[Engine]:
    """Yield an open engine that keeps its runs where there is a cache."""
    if entries is None:
        yield opened
        return
    from harness.store.cached_engine import CachedEngine

    yield CachedEngine(opened, entries, fresh=fresh)


def runs_made(engine: Engine | None) -> dict[str, int]:
    """Return how many runs an engine made and how many were kept ones, where it counts them."""
    from harness.store.cached_engine import CachedEngine

    if not isinstance(engine, CachedEngine):
        return {}
    return {"engine_runs": engine.ran, "engine_runs_from_cache": engine.read}


def _check_launcher(command: str | None) -> None:
    import shlex

    from harness.errors import RequestError

    if command is None:
        return
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise RequestError(f"--mpirun {command!r}: {str(error).lower()}") from None
    if not words:
        raise RequestError(f"--mpirun {command!r}: must be a command, as in 'mpirun -np 4'")
