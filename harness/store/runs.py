"""Results of engines as bytes and back, exactly: arrays as npz without pickle, the rest as JSON.

The case is not stored: it is part of the key, and whoever asks has it.
"""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import asdict, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion
from harness.observables.provenance import Provenance
from harness.observables.tower import Profiles, TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower

Arrays = dict[str, NDArray[Any]]
FACTS = "facts"
DECODE_ERRORS = (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile)
"""What unpacking raises for bytes that are not those of a run."""

SERIES = tuple(
    f.name
    for f in fields(TowerRun)
    if f.name not in ("tower", "solver", "step", "profiles", "provenance")
)


def pack_incline(run: InclineRun) -> bytes:
    """Return a run of the incline as bytes."""
    facts = {
        "motion": run.motion.value,
        "margin_J": run.margin_J,
        "touching": run.touching,
        "time_s": run.time_s,
        "steps": run.steps,
        "seconds": run.seconds,
        "provenance": asdict(run.provenance),
    }
    arrays = {f"crests.{name}": array for name, array in vars(run.crests).items()}
    if run.trajectory is not None:
        arrays |= {f"trajectory.{name}": array for name, array in vars(run.trajectory).items()}
    return _pack(facts, arrays)


def unpack_incline(data: bytes, case: Incline) -> InclineRun:
    """Return the run of a case from its bytes; ``seconds`` are those of the run when it was made.

    Raise one of :data:`DECODE_ERRORS` when the bytes are not those of a run.
    """
    facts, arrays = _unpack(data)
    path = _group(arrays, "trajectory")
    return InclineRun(
        case=case,
        motion=Motion(facts.pop("motion")),
        provenance=_provenance(facts.pop("provenance")),
        crests=Crests(**_group(arrays, "crests")),
        trajectory=Trajectory(**path) if path else None,
        **facts,
    )


def pack_tower(run: TowerRun) -> bytes:
    """Return a run of the tower as bytes."""
    facts = {
        "solver": run.solver,
        "step": run.step,
        "provenance": asdict(run.provenance) if run.provenance else None,
    }
    arrays = {f"series.{name}": getattr(run, name) for name in SERIES}
    if run.profiles is not None:
        arrays |= {f"profiles.{n}": array for n, array in run.profiles._asdict().items()}
    return _pack(facts, arrays)


def unpack_tower(data: bytes, case: Tower) -> TowerRun:
    """Return the run of a case from its bytes.

    Raise one of :data:`DECODE_ERRORS` when the bytes are not those of a run.
    """
    facts, arrays = _unpack(data)
    who, profiles = facts.pop("provenance"), _group(arrays, "profiles")
    series: dict[str, Any] = _group(arrays, "series")
    return TowerRun(
        tower=case,
        provenance=_provenance(who) if who else None,
        profiles=Profiles(**profiles) if profiles else None,
        **facts,
        **series,
    )


def _pack(facts: dict[str, Any], arrays: Arrays) -> bytes:
    stream = io.BytesIO()
    text = np.frombuffer(json.dumps(facts).encode(), dtype=np.uint8)
    np.savez(stream, allow_pickle=False, **{FACTS: text}, **arrays)
    return stream.getvalue()


def _unpack(data: bytes) -> tuple[dict[str, Any], Arrays]:
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    facts: dict[str, Any] = json.loads(arrays.pop(FACTS).tobytes())
    return facts, arrays


def _group(arrays: Arrays, prefix: str) -> Arrays:
    return {
        name.removeprefix(f"{prefix}."): array
        for name, array in arrays.items()
        if name.startswith(f"{prefix}.")
    }


def _provenance(record: dict[str, Any]) -> Provenance:
    return Provenance(**{**record, "packages": tuple(record["packages"])})
