"""List and clear the cache: results by case, environments of releases, compiled kernels."""

from __future__ import annotations

import contextlib
import json
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from harness.engines import environments
from harness.home import KERNELS
from harness.store.entries import ASIDE, PRUNING
from harness.store.outputs import DECODE_ERRORS, FACTS
from harness.store.verifications import RECORD

Sort = Literal["run", "verification", "environment", "kernel", "other"]


@dataclass(frozen=True)
class Kept:
    """One thing in the cache: where it is, of which cases, its size and its last use."""

    path: Path
    sort: Sort
    size: int  # [bytes]
    used: float  # [s since 1970]
    cases: tuple[str, ...] = ()

    def clear(self) -> bool:
        """Remove it; return whether it is gone. One that is in use stays."""
        try:
            if self.sort == "environment":
                environments.drop(self.path)
                for lock in environments.LOCKS:
                    self.path.with_name(self.path.name + lock).unlink(missing_ok=True)
            else:
                self.path.unlink(missing_ok=True)
        except OSError:
            return False
        return True


def contents(folder: Path) -> list[Kept]:
    """Return what the cache in a folder holds; of another folder nothing, whatever is in it."""
    found = list(_kernels(folder))
    if (folder / ASIDE).is_dir():
        found += [*_results(folder), *_environments(folder)]
    return found


def clear(folder: Path, found: Iterable[Kept]) -> list[Kept]:
    """Remove things of the cache in a folder, and folders that are empty then; return the gone."""
    gone = [one for one in found if one.clear()]
    if gone and not contents(folder):
        (folder / PRUNING).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            (folder / ASIDE).rmdir()
    parents = {p for one in gone for p in one.path.parents if p.is_relative_to(folder)}
    for path in sorted(parents, reverse=True):
        with contextlib.suppress(OSError):
            path.rmdir()
    return gone


def _results(folder: Path) -> Iterator[Kept]:
    for path in sorted(folder.glob("[0-9a-f][0-9a-f]/" + "[0-9a-f]" * 64)):
        with contextlib.suppress(OSError):
            state = path.stat()
            sort, cases = _told(path)
            yield Kept(path, sort, state.st_size, state.st_mtime, cases)


def _told(path: Path) -> tuple[Sort, tuple[str, ...]]:
    """Return what an entry is, and its cases; both kinds are zip files behind a head."""
    try:
        with zipfile.ZipFile(path) as archive:
            if RECORD in archive.namelist():
                return "verification", tuple(json.loads(archive.read(RECORD))["cases"])
            with archive.open(f"{FACTS}.npy") as file:
                facts = np.lib.format.read_array(file, allow_pickle=False)
        template = json.loads(zlib.decompress(facts.tobytes())).get("template", "")
    except DECODE_ERRORS:
        return "other", ()
    return "run", (template,) if template else ()


def _environments(folder: Path) -> Iterator[Kept]:
    for home in sorted((folder / environments.FOLDER).glob("*/")):
        with contextlib.suppress(OSError):
            used, size = environments.last_use_and_size(home)
            yield Kept(home, "environment", size, used)


def _kernels(folder: Path) -> Iterator[Kept]:
    for path in sorted((folder / KERNELS).rglob("*.nb[ci]")):
        with contextlib.suppress(OSError):
            state = path.stat()
            yield Kept(path, "kernel", state.st_size, state.st_mtime)
