"""The folder of a sweep: held by one process at a time, taken up again by the same sweep."""

from __future__ import annotations

import contextlib
import fcntl
import json
from collections.abc import Iterator
from pathlib import Path

from harness.atomic_write import held_folder
from harness.errors import RequestError
from harness.home import lock_file
from harness.report.target import check_writable
from harness.workflows.sweep_plan import Asked

LOCK, REQUEST = ".lock", "sweep.json"


@contextlib.contextmanager
def held_sweep(folder: Path, asked: Asked) -> Iterator[None]:
    """Hold a folder for a sweep; the kernel lets go of it when the process ends, however it does.

    Raise RequestError for a folder that another process sweeps in, that holds another sweep or
    something else, or that cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    check_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    there = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    if there and REQUEST not in there:
        raise RequestError(f"--output {folder}: holds something else than a sweep; name another")
    with contextlib.ExitStack() as held:
        try:
            lock = held.enter_context(lock_file(folder / LOCK))
        except OSError as error:
            raise RequestError(f"--output {folder}: {LOCK}: {error.strerror}") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RequestError(f"--output {folder}: another sweep runs in it") from None
        _check_same(folder, json.dumps(vars(asked), indent=2) + "\n")
        yield


def _check_same(folder: Path, text: str) -> None:
    """Write down what is swept; raise RequestError where it is something else already."""
    file = folder / REQUEST
    if not file.is_file():
        with held_folder(folder) as aside:
            (aside / REQUEST).write_text(text, encoding="utf-8")
            (aside / REQUEST).replace(file)
    elif file.read_text(encoding="utf-8", errors="replace") != text:
        raise RequestError(
            f"--output {folder}: holds another sweep ({REQUEST} says which); name another"
        )
