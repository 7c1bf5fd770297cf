"""An engine that remembers: what it has run before is read, only the rest is run."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.engines.contract import Engine, Route
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.store.entries import Entries
from harness.store.keys import key_of, machine, source_digest, versions
from harness.store.runs import DECODE_ERRORS, pack_incline, pack_tower, unpack_incline, unpack_tower

ROOMS = ("parameters", "observables", "engines")
"""Source that turns a case into a result: edited, every run is run again."""

Case = TypeVar("Case", Incline, Tower)
Run = TypeVar("Run", InclineRun, TowerRun)


class CachedEngine(Engine):
    """Wraps an engine; each result is kept as soon as it is there, errors are not.

    An interrupted command so goes on where it stopped. ``fresh`` reads nothing
    and keeps all the same. ``ran`` and ``read`` count the runs. The wall time
    in a result that was read is that of the run when it was made.
    """

    def __init__(self, engine: Engine, entries: Entries, *, fresh: bool = False) -> None:
        self.name = engine.name
        self.traits = engine.traits
        self.states_towers = engine.states_towers
        self.ran = 0
        self.read = 0
        self._engine = engine
        self._entries = entries
        self._fresh = fresh
        self._lock = threading.Lock()

    def identify(self) -> Provenance:
        """Return what the engine says of itself."""
        return self._engine.identify()

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return the engine's own."""
        return self._engine.fingerprint()

    def logs(self) -> dict[str, str]:
        """Return the logs of what the engine ran itself; kept results have none."""
        return self._engine.logs()

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the drops anew: an engine qualifies afresh, and they take no time."""
        return self._engine.drops(cases)

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Return the results in order, those kept without running them."""
        options = {"system": "incline", "route": route, "every": every}
        return self._each(
            cases,
            options,
            lambda some: self._engine.inclines(some, route, every=every),
            pack_incline,
            unpack_incline,
        )

    def towers(
        self,
        cases: Sequence[Tower],
        duration: float,
        *,
        steps_per_contact: float | None = None,
        samples: int | None = None,
        profiles: bool = False,
    ) -> list[TowerRun | EngineError]:
        """Return the results in order, those kept without running them."""
        options: dict[str, Any] = {
            "steps_per_contact": steps_per_contact,
            "samples": samples,
            "profiles": profiles,
        }
        return self._each(
            cases,
            {"system": "tower", "duration": duration, **options},
            lambda some: self._engine.towers(some, duration, **options),
            pack_tower,
            unpack_tower,
        )

    def close(self) -> None:
        """End the engine's processes."""
        self._engine.close()

    def _each(
        self,
        cases: Sequence[Case],
        options: Mapping[str, Any],
        run: Callable[[Sequence[Case]], list[Run | EngineError]],
        pack: Callable[[Run], bytes],
        unpack: Callable[[bytes, Case], Run],
    ) -> list[Run | EngineError]:
        who = self._engine.fingerprint()
        if who is None:
            return self._counted(run(cases))
        keys = [run_key(case, options, who) for case in cases]
        results: dict[int, Run | EngineError] = {}
        for index, (key, case) in enumerate(zip(keys, cases, strict=True)):
            kept = None if self._fresh else self._kept(key, case, unpack)
            if kept is not None:
                results[index] = kept
        missing = [index for index in range(len(cases)) if index not in results]
        made = self._counted(run([cases[index] for index in missing])) if missing else []
        for index, result in zip(missing, made, strict=True):
            results[index] = result
            if not isinstance(result, EngineError):
                self._entries.put(keys[index], pack(result))
        return [results[index] for index in range(len(cases))]

    def _kept(self, key: str, case: Case, unpack: Callable[[bytes, Case], Run]) -> Run | None:
        data = self._entries.get(key)
        if data is None:
            return None
        try:
            run = unpack(data, case)
        except DECODE_ERRORS as error:
            self._entries.drop(key, f"not a run: {error}")
            return None
        with self._lock:
            self.read += 1
        return run

    def _counted(self, results: list[Run | EngineError]) -> list[Run | EngineError]:
        with self._lock:
            self.ran += len(results)
        return results


def run_key(case: Incline | Tower, options: Mapping[str, Any], engine: Mapping[str, Any]) -> str:
    """Return the key of a run: case, options, engine, platform, and the source that reads it."""
    return key_of(
        {
            "case": {type(case).__name__: case.model_dump(mode="json")},
            "options": dict(options),
            "engine": dict(engine),
            "machine": machine(),
            "packages": versions("numpy", "pydantic"),
            "source": source_digest(*ROOMS),
        }
    )
