"""Options that choose an engine or a solver, its program and its cache; open what they name.

A command that ran one engine ends with whether that engine qualifies.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import Folder, Name, options
from harness.cli.files import print_json
from harness.errors import EngineError, HarnessError, RequestError
from harness.report.plain import printable

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.store.entries import Entries
    from harness.workflows.progress import Progress


@options("Kept results")
class CacheOptions:
    """Where results are kept, and whether they are used."""

    cache: Folder = None
    """Where results are kept, up to 2 GiB. [default: DEM_HARNESS_HOME/cache, else
    ~/.cache/dem-harness]"""
    fresh: bool = False
    """Run everything again, whatever is kept."""

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


@options("Engine")
class WhereOptions:
    """Where the programs of engines are."""

    lmp: Annotated[str | None, Parameter(metavar="COMMAND")] = None
    """A LAMMPS executable of your own, with its arguments if need be, as in
    `--lmp "lmp -sf omp"`. Without it, LAMMPS runs in-process."""
    mpirun: Annotated[str | None, Parameter(metavar="COMMAND")] = None
    """An MPI launcher of LAMMPS with its options, as in `--mpirun "mpirun -np 4"`."""
    program: Annotated[list[str] | None, Parameter(metavar="NAME=PATH")] = None
    """The executable of an engine (of Kratos a Python that has it); repeat it for several."""

    @property
    def programs(self) -> dict[str, str]:
        """Return the programs by the engines' names; raise RequestError for an unknown one."""
        from harness.engines.registry import check_known, named_values

        programs = named_values(self.program or (), "--program")
        check_known(programs, "--program")
        return programs


@options("Engine")
class ProgramOptions(CacheOptions, WhereOptions):
    """How engines are run: programs, launcher, options of their classes."""

    engine_option: Annotated[list[str] | None, Parameter(metavar="NAME.KEY=VALUE")] = None
    """An option of an engine's class, as `lammps.limits=60`, the seconds a run may take (300);
    repeat it for several."""

    def opening(self, name: str, integrator: str | None = None) -> dict[str, Any]:
        """Return what opens an engine, as the functions of the registry take it.

        Raise RequestError for options that cannot be read.
        """
        from harness.engines.registry import check_launcher, engine_settings

        check_launcher(self.mpirun)
        return {
            "program": self.programs.get(name),
            "options": engine_settings(self.engine_option or ()).get(name, {}),
            "lmp": self.lmp,
            "launcher": self.mpirun,
            "integrator": integrator,
        }

    def check_names(self, engines: Iterable[str], option: str = "--engine") -> None:
        """Raise RequestError for a program or option whose engine is not requested.

        ``engines`` are the engines that will run, ``option`` is how one is asked for.
        """
        from harness.engines import registry

        settings = registry.engine_settings(self.engine_option or ())
        registry.check_names(self.programs, settings, engines, option)

    @contextlib.contextmanager
    def open(self, name: str, integrator: str | None = None) -> Iterator[Engine]:
        """Yield an engine, keeping its runs where there is a cache; close it after use."""
        from harness.engines.registry import open_engine

        entries = self.entries()
        with open_engine(name, **self.opening(name, integrator)) as opened:
            yield cached(opened, entries, self.fresh)


@options("Engine")
class IntegratorOptions(ProgramOptions):
    """How engines are run, the reference engine's integrator among it."""

    integrator: Name = None
    """Of the reference engine. `velocity-verlet`: as LAMMPS. `mfix-euler`,
    `mfix-adams-bashforth`: as MFiX-DEM (with --half-mass). `rk4`: fourth order. `adaptive`: high
    order, contact changes located; has no step, --steps-per-contact is ignored. [default:
    velocity-verlet]"""


@options()
class LongRunOptions:
    """Consent to a long run."""

    force: bool = False
    """Run also what is expected to take more than ten minutes of a core."""

    def check_duration(self, seconds: float, work: str, instead: str = "") -> None:
        """Print the expected time of a long run; raise RequestError above the limit of engines.

        ``instead`` is what to request in its place. With ``--force`` there is no limit.
        """
        from harness.engines.border import STATED_SECONDS, check_duration, in_words
        from harness.store.entries import tell_stderr

        if not self.force:
            check_duration(seconds, work, instead)
        if seconds > STATED_SECONDS:
            tell_stderr(f"{work}: an estimated {in_words(seconds)} on one core")


@options("Engine")
class EngineOptions(IntegratorOptions):
    """One engine of the user's choice."""

    engine: Annotated[str, Parameter(metavar="NAME")] = "lammps"
    """The engine to run: a name that `dem-harness engines` lists, or `module:Class` of one of
    your own."""

    def run(self) -> contextlib.AbstractContextManager[Engine]:
        """Return the engine to be entered, after a look at the options that go with it."""
        self.check_names([self.engine])
        return self.open(self.engine, self.integrator)

    def without_launcher(self) -> EngineOptions:
        """Return the same options for the other engines, without the main engine's executable."""
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


@options("Engine")
class SolverOptions(ProgramOptions):
    """What runs the towers."""

    solver: Annotated[str, Parameter(metavar="NAME")] = "rk4"
    """`rk4`: fixed steps of fourth order. `exact`: modes, without a step. Or an engine that
    `dem-harness engines` lists, or `module:Class`: the overlap law; the deformable one in LAMMPS
    in-process."""

    @property
    def own_solver(self) -> str | None:
        """Return the requested solver of the harness, None for an engine."""
        return self.solver if self.solver in OWN else None

    @contextmanager
    def run(self) -> Iterator[Engine | None]:
        """Yield the requested engine; None for a solver of the harness.

        Raise RequestError for a name that is not known, and for options of another engine.
        """
        from harness.engines.registry import engine_class

        for name, value in (("--lmp", self.lmp), ("--mpirun", self.mpirun)):
            if value is not None and self.solver != "lammps":
                raise RequestError(f"{name} {value!r}: goes with --solver lammps only")
        self.check_names({self.solver} - set(OWN), "--solver")
        if self.own_solver:
            yield None
            return
        try:
            engine_class(self.solver)
        except RequestError as error:
            text = str(error).replace("--engine", "--solver", 1)
            raise RequestError(f"{text}; or a solver of the harness: {', '.join(OWN)}") from None
        with self.open(self.solver) as engine:
            yield engine


def completed(
    record: Mapping[str, Any], engine: Engine | None, progress: Progress
) -> dict[str, Any]:
    """Return a record with whether its engine qualifies, and how many runs were made or kept.

    Nothing is added for a solver of the harness. Ask after the result, which raises RequestError
    for a wrong request at once; kept runs are not repeated.
    """
    return {**record, **qualification(engine, progress), **runs_made(engine)}


def answer(
    record: Mapping[str, Any], engine: str, json: bool, show: Callable[[Mapping[str, Any]], None]
) -> int:
    """Print a record and return 0; 3, with the reason, where its engine did not qualify."""
    from harness.store.entries import tell_stderr

    (print_json if json else show)(record)
    if not record.get("qualified", True):
        reason = printable(record["qualification_failures"])
        tell_stderr(f"engine {engine!r} did not qualify, its result is not to be used: {reason}")
        return HarnessError.exit_status
    return 0


def qualification(engine: Engine | None, progress: Progress) -> dict[str, Any]:
    """Qualify an engine and return the result for a record; nothing for the reference engines."""
    from harness.cases.qualification import qualify
    from harness.engines.registry import ALWAYS
    from harness.store.entries import tell_stderr

    if engine is None or engine.name in ALWAYS:
        return {}
    progress(f"qualification of {engine.name}", 0, 1)
    try:
        reason = qualify(engine, tell=tell_stderr).reason
    except EngineError as error:
        reason = str(error)
    return {"qualified": not reason, "qualification_failures": reason}
