"""``dem-harness cache``: what is kept of earlier runs."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import Folder, Json, Name, options
from harness.cli.files import print_json
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.store.cache import Kept

DAY = 86_400.0


@options()
class CacheCommandOptions:
    """Which cache, and what of it is removed."""

    cache: Folder = None
    """The cache. [default: DEM_HARNESS_HOME/cache, else ~/.cache/dem-harness]"""
    clear: bool = False
    """Remove what fits the two options below; all without them."""
    older_than: Annotated[float | None, Parameter(metavar="DAYS")] = None
    """Only what was not used for so many days."""
    case: Name = None
    """Only results of a case that `dem-harness cases` lists."""

    def fitting(self, entries: list[Kept]) -> list[Kept]:
        """Return what fits the options; raise RequestError for an age that is none."""
        from harness.cases.registry import get_case

        if self.older_than is not None and not self.older_than >= 0.0:
            raise RequestError(f"--older-than {self.older_than}: must be 0 days or more")
        if self.case is not None:
            template = get_case(self.case).template.name
            entries = [entry for entry in entries if {self.case, template} & set(entry.cases)]
        if self.older_than is not None:
            newest = time.time() - DAY * self.older_than
            entries = [entry for entry in entries if entry.used <= newest]
        return entries


def cache(choice: CacheCommandOptions = CacheCommandOptions(), *, json: Json = False) -> int:
    """Say what is kept: path, size and cases of the cache; or clear it, by age or case.

    Besides results the cache holds environments of `releases` and compiled kernels. What is
    cleared is computed, installed or compiled again when it is asked for.

    For example:

        dem-harness cache --json
        dem-harness cache --clear --older-than 30
    """
    from harness.files import cache_place
    from harness.store.cache import clear, contents

    folder = cache_place(choice.cache).path
    entries = choice.fitting(contents(folder))
    record: dict[str, Any] = {"cache": str(folder), **_sums(entries)}
    if choice.clear:
        gone = clear(folder, entries)
        record = {"cache": str(folder), "cleared": _sums(gone), **_sums(contents(folder))}
    if json:
        print_json(record)
        return 0
    print(f"{folder}: {_size_text(record)}")
    for sort, part in record["sorts"].items():
        print(f"  {sort}: {_size_text(part)}")
    for case, part in record["cases"].items():
        print(f"  of case {case}: {_size_text(part)}")
    if choice.clear:
        print(f"cleared: {_size_text(record['cleared'])}")
    return 0


def _sums(entries: list[Kept]) -> dict[str, Any]:
    sorts = sorted({entry.sort for entry in entries})
    cases = sorted({case for entry in entries for case in entry.cases})
    return {
        **_sum(entries),
        "sorts": {sort: _sum([entry for entry in entries if entry.sort == sort]) for sort in sorts},
        "cases": {
            case: _sum([entry for entry in entries if case in entry.cases]) for case in cases
        },
    }


def _sum(entries: list[Kept]) -> dict[str, int]:
    return {"count": len(entries), "size_bytes": sum(entry.size for entry in entries)}


def _size_text(part: dict[str, Any]) -> str:
    return f"{part['count']} kept, {part['size_bytes'] / 1e6:.1f} MB"
