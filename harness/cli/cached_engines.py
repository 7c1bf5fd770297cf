"""Open the cache, and engines that remember in it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.store.entries import Entries

_PANEL = "Kept results"

Cache = Annotated[
    Path | None,
    typer.Option(
        "--cache",
        metavar="DIR",
        help="Where results are kept, up to 1 GiB.  [default: DEM_HARNESS_HOME/cache, "
        "else ~/.cache/dem-harness]",
        rich_help_panel=_PANEL,
    ),
]

Fresh = Annotated[
    bool,
    typer.Option("--fresh", help="Run everything again, whatever is kept.", rich_help_panel=_PANEL),
]


class Chosen(NamedTuple):
    """The options that choose an engine, as given."""

    engine: str
    lmp: str | None = None
    mpirun: str | None = None
    integrator: str | None = None
    programs: Mapping[str, str] | None = None


def open_entries(option: Path | None) -> Entries | None:
    """Return the cache, or None with a note on stderr where the default place cannot be written.

    Raise RequestError for a place that was named.
    """
    from harness.store.entries import Entries, tell_stderr
    from harness.store.home import cache_place

    place = cache_place(option)
    try:
        return Entries(place.path)
    except OSError as error:
        why = error.strerror or str(error)
        if place.named_by:
            raise place.refused(why) from None
        tell_stderr(f"cache {place.path} cannot be written ({why}); nothing is kept")
        return None


@contextlib.contextmanager
def open_cached_engine(chosen: Chosen, entries: Entries | None, fresh: bool) -> Iterator[Engine]:
    """Yield the engine, remembering its runs where there is a cache; close it after use."""
    from harness.engines.registry import open_engine

    name, lmp, mpirun, integrator, programs = chosen
    with (
        open_engine(
            name, lmp=lmp, launcher=mpirun, integrator=integrator, programs=programs
        ) as opened,
        remembered(opened, entries, fresh) as engine,
    ):
        yield engine


@contextlib.contextmanager
def remembered(opened: Engine, entries: Entries | None, fresh: bool) -> Iterator[Engine]:
    """Yield an open engine so that it remembers its runs where there is a cache."""
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
