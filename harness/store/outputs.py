"""Convert outputs of engines to bytes and back, exactly: arrays as npz, the rest as JSON."""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.engines.output import Output
from harness.observables.provenance import Provenance

FACTS = "facts"
DECODE_ERRORS = (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error)
"""What unpacking raises for bytes that are not those of an output."""


def pack(output: Output, template: str = "") -> bytes:
    """Return an output as bytes; ``template`` says what was run, for who looks into the cache."""
    arrays: dict[str, NDArray[Any]] = {}
    tables: dict[str, dict[str, str]] = {}
    for table, columns in output.tables.items():
        alike: dict[tuple[np.dtype[Any], tuple[int, ...]], list[str]] = {}
        for column, values in columns.items():
            alike.setdefault((values.dtype, values.shape), []).append(column)
        tables[table] = dict.fromkeys(columns, "")
        for names in alike.values():  # one array for all: each has its own cost
            place = f"array {len(arrays)}"
            arrays[place] = np.stack([columns[name] for name in names])
            tables[table] |= {name: f"{place}/{row}" for row, name in enumerate(names)}
    facts = {
        "results": output.results,
        "provenance": {f.name: getattr(output.provenance, f.name) for f in fields(Provenance)},
        "tables": tables,
        "log": output.log,
        "seconds": output.seconds,
        "title": output.title,
        "ranks": output.ranks,
        "template": template,
    }
    stream = io.BytesIO()
    text = np.frombuffer(zlib.compress(json.dumps(facts).encode(), 1), dtype=np.uint8)
    np.savez(stream, allow_pickle=False, **{FACTS: text}, **arrays)
    return stream.getvalue()


def unpack(data: bytes) -> Output:
    """Return the output from its bytes; ``seconds`` are those of the run when it was made.

    Raise one of :data:`DECODE_ERRORS` when the bytes are not those of an output.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    facts: dict[str, Any] = json.loads(zlib.decompress(arrays[FACTS].tobytes()))
    who = facts["provenance"]
    return Output(
        results=tuple((name, text) for name, text in facts["results"]),
        provenance=Provenance(**{**who, "packages": tuple(who["packages"])}),
        tables={
            table: {column: _array(arrays, place) for column, place in columns.items()}
            for table, columns in facts["tables"].items()
        },
        log=facts["log"],
        seconds=facts["seconds"],
        title=facts["title"],
        ranks=facts.get("ranks", 1),
    )


def _array(arrays: Mapping[str, NDArray[Any]], place: str) -> NDArray[Any]:
    """Return a column: a row of one of the arrays, or all of one in entries of earlier releases."""
    name, _, row = place.partition("/")
    return arrays[name][int(row)] if row else arrays[name]
