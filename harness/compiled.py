"""Compile kernels to machine code at their first call, kept in the cache folder.

A folder that the user names in ``NUMBA_CACHE_DIR`` comes first. Numba compiles again when the file
of a kernel changes, but not when a kernel that it calls does, in another file: so the machine code
lies under a stamp of all files of the kernel's folder. Kept kernels are pickles, which run code as
they are read: they are read only from a folder that this user alone may write.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from harness.files import KERNELS, cache_place, make_private, writable_by_others

Function = TypeVar("Function", bound=Callable[..., Any])
Result = TypeVar("Result")
_CHOOSING = threading.Lock()  # held while numba's folder is set: threads import kernels


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call, keeping its Python type.

    IEEE arithmetic in the order written, and without Python's lock, so that runs go side by side
    in threads.
    """
    return jit(function, error_model="numpy", nogil=True)


def jit(function: Function, **options: Any) -> Function:
    """Compile a function with options of ``numba.njit``, keeping its Python type.

    Where the cache folder cannot be written, numba chooses its own.
    """
    config: Any = numba.config
    with _CHOOSING:
        chosen = config.CACHE_DIR
        try:
            # numba reads the folder here and not again: other users of numba keep theirs
            place = Path(chosen) if chosen else cache_place().path / KERNELS
            stamp = _stamp(Path(function.__code__.co_filename).parent)
            config.CACHE_DIR = str(_kernel_folder(place, stamp))
            kernel = numba.njit(cache=True, **options)(function)
            return cast(Function, _surviving_a_full_disk(kernel))
        except RuntimeError:  # no folder can be written
            return cast(Function, numba.njit(**options)(function))
        finally:
            config.CACHE_DIR = chosen


def shielded(kernel: Callable[..., Result], *arguments: Any) -> Result:
    """Return the result of a kernel, called where an interrupt cannot be raised within.

    The conversion of its arguments and results crashes where Python raises KeyboardInterrupt in
    it, which happens in the main thread alone: there it is called in another one. An interrupt
    does not wait for that.
    """
    if threading.current_thread() is not threading.main_thread():
        return kernel(*arguments)
    pool = ThreadPoolExecutor(1)
    try:
        return pool.submit(kernel, *arguments).result()
    finally:
        pool.shutdown(wait=False)


@cache
def _stamp(folder: Path) -> str:
    """Return a digest of the Python files of a folder, constants of kernels among them."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _kernel_folder(place: Path, stamp: str) -> Path:
    """Return the folder below ``place`` for kernels of a stamp, made if need be.

    In place of one that others can write, or a link, it is a temporary one, with a note.
    """
    folder = place / stamp
    with contextlib.suppress(OSError):
        make_private(folder)
    if not folder.is_dir():
        return folder  # it cannot be made: numba chooses one of its own
    linked = "it is a link" if folder.is_symlink() else ""
    reason = linked or writable_by_others(place, 0) or writable_by_others(folder)
    if not reason:
        return folder
    _note(f"kernels in {folder} are not used, {reason}: remove it, or name another place in "
          "DEM_HARNESS_HOME; until then they are compiled in each run")  # fmt: skip
    private = Path(tempfile.mkdtemp(prefix="dem-harness-kernels-"))
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return private


def _surviving_a_full_disk(dispatcher: Any) -> Any:
    """Return a kernel whose machine code is kept where there is room for it."""
    keeper = getattr(dispatcher, "_cache", None)  # numba has no public name for it
    if keeper is None:
        return dispatcher
    save = keeper.save_overload

    def save_or_note(*arguments: Any) -> None:
        try:
            save(*arguments)
        except OSError as error:
            reason = error.strerror or error
            _note(f"cache of kernels {keeper.cache_path} cannot be written ({reason}); "
                  "kernels are compiled anew")  # fmt: skip

    keeper.save_overload = save_or_note
    return dispatcher


@cache  # a note is printed once
def _note(text: str) -> None:
    print(f"dem-harness: {text}", file=sys.stderr)
