"""Engines opened for a caller: by name, for one call, their runs kept as on the command line."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from harness.engines.contract import Engine
from harness.engines.registry import DEFAULT, engine_names, open_engine
from harness.home import cache_place
from harness.store.cached_engine import CachedEngine
from harness.store.entries import Entries

TOLD = """
    ``engine`` may be the name of an engine as well: it is opened for the call and closed again.
    What it runs is kept in the cache of the command line and read from there; ``fresh=True`` runs
    all of it again.
    """


@contextmanager
def opened(
    name: str = DEFAULT, *, fresh: bool = False, options: Mapping[str, Any] | None = None
) -> Iterator[Engine]:
    """Yield an engine by its name, keeping its runs where the cache can be written; close it.

    ``options`` are those of :func:`harness.engines.registry.open_engine`.
    """
    with open_engine(name, options=options) as own, keeping(own, fresh=fresh) as engine:
        yield engine


@contextmanager
def keeping(engine: Engine, *, fresh: bool = False) -> Iterator[Engine]:
    """Yield an open engine that keeps its runs; itself where the cache cannot be written."""
    try:
        entries = Entries(cache_place().path)
    except OSError:
        yield engine
        return
    yield CachedEngine(engine, entries, fresh=fresh)


def opening(verb: Callable[..., Any]) -> Callable[..., Any]:
    """Return a verb that opens its engine by name and keeps its runs.

    A verb with a solver of its own opens an engine only where one is named, as ``engine`` or as
    ``solver``. One that opens engines itself is given the way to open them.
    """
    signature = inspect.signature(verb)
    takes = signature.parameters
    solves = "solver" in takes or any(one.kind is one.VAR_KEYWORD for one in takes.values())

    @functools.wraps(verb)
    def asked(*given: Any, fresh: bool = False, **named: Any) -> Any:
        ways = {
            "open_one": functools.partial(opened, fresh=fresh),
            "remember": functools.partial(keeping, fresh=fresh),
        }
        named = {name: way for name, way in ways.items() if name in takes} | named
        if named.get("engine") is None and named.get("solver") in engine_names():
            named["engine"] = named.pop("solver")
        bound = signature.bind_partial(*given, **named)
        engine = bound.arguments.get("engine", named.get("engine"))
        opens_itself = "remember" in takes or "settings" in takes or isinstance(engine, Engine)
        if opens_itself or (engine is None and solves):
            return verb(*given, **named)
        with opened(engine or DEFAULT, fresh=fresh) as own:
            if "engine" in takes:
                bound.arguments["engine"] = own
                return verb(*bound.args, **bound.kwargs)
            return verb(*given, **{**named, "engine": own})

    asked.__doc__ = f"{inspect.getdoc(verb)}\n\n{inspect.cleandoc(TOLD)}"
    return asked
