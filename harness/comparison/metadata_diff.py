"""What differs between a case now and in the baseline besides its numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from harness.comparison.baseline_record import BaselineRecord

DERIVED = 1e-12
"""Part of itself that a derived parameter, as a duration, may differ by between processors: 2e-14
were seen. What anybody sets apart differs by more."""


def changed_parameters(now: Mapping[str, Any], known: Mapping[str, Any]) -> list[str]:
    """Say which parameters differ; one that only one side knows is no difference of the case."""
    found = []
    for key, wanted in known.items():
        if key not in now:
            continue
        if isinstance(wanted, Mapping) and isinstance(now[key], Mapping):
            found += [f"{key} {text}" for text in changed_parameters(now[key], wanted)]
        elif not _same(now[key], wanted):
            found.append(f"{key} = {now[key]!r}, the baseline's is {wanted!r}")
    return found


def _same(now: Any, wanted: Any) -> bool:
    """Return whether two values are one; of a derived one the last bits are the processor's."""
    if isinstance(now, float) and isinstance(wanted, float):
        return math.isclose(now, wanted, rel_tol=DERIVED)
    return bool(now == wanted)


def metadata_changes(case: BaselineRecord, known: BaselineRecord) -> list[str]:
    """Say what differs between the two runs besides the case."""
    said = []
    if case.engine_version != known.engine_version:
        said.append(f"baseline of {known.engine} {known.engine_version}")
    if case.platform != known.platform:
        said.append(f"baseline of {known.platform}")
    if case.script_sha256 != known.script_sha256:
        said.append(f"script {case.script} is not the baseline's")
    return said
