"""Compile kernels to machine code at their first call, kept in the cache folder.

A folder that the user names in ``NUMBA_CACHE_DIR`` comes first. Numba compiles again when the file
of a kernel changes, but not when a kernel that it calls does, in another file: so the machine code
lies under a stamp of all files of the kernel's folder. Kept kernels are pickles, which run code as
they are read: they are read only from a folder that this user alone may write.
"""

from __future__ import annotations

import hashlib
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
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
    """Compile a function with options of ``numba.njit``, keeping its Python type; C cannot call it.

    Where the cache folder cannot be written, numba chooses its own.
    """
    config: Any = numba.config
    options["no_cfunc_wrapper"] = True  # an eighth of the time to compile
    with _CHOOSING:
        chosen = config.CACHE_DIR
        try:
            # numba reads the folder here and not again: other users of numba keep theirs
            place, folder = _places(Path(function.__code__.co_filename).parent)
            config.CACHE_DIR = str(folder)
            kernel = numba.njit(cache=_is_private(place, folder), **options)(function)
        except RuntimeError:  # no folder can be written
            kernel = numba.njit(**options)(function)
        finally:
            config.CACHE_DIR = chosen
    return cast(Function, _surviving_a_full_disk(kernel))


def waits_for_compilation(folder: Path) -> bool:
    """Return whether no kernel of a folder with Python files was compiled before, and kept."""
    with _CHOOSING:
        place, kept = _places(folder)
    with suppress(OSError):  # a place into which nothing can be put
        empty = _is_private(place, kept) and next(kept.rglob("*.nbi"), None) is None
        return empty and kept.is_dir()
    return False


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


def _places(folder: Path) -> tuple[Path, Path]:
    """Return where machine code is kept, and in there that of a folder with Python files."""
    config: Any = numba.config
    place = Path(config.CACHE_DIR or cache_place().path / KERNELS)
    return place, place / _stamp(folder)


@cache
def _stamp(folder: Path) -> str:
    """Return a digest of the Python files of a folder, constants of kernels among them."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _is_private(place: Path, folder: Path) -> bool:
    """Return whether no other user can write a folder below ``place``, made if need be."""
    try:
        make_private(folder)
        linked = "it is a link" if folder.is_symlink() else ""
        reason = linked or writable_by_others(place, 0) or writable_by_others(folder)
    except OSError:  # it has nothing to be read, and numba chooses a folder of its own
        return True
    if reason:
        _note(f"kernels in {folder} are not used, {reason}: remove it, or name another place in "
              "DEM_HARNESS_HOME; until then they are compiled in each run")  # fmt: skip
    return not reason


def _surviving_a_full_disk(dispatcher: Any) -> Any:
    """Return a kernel whose machine code is kept where there is room for it."""
    keeper: Any = getattr(dispatcher, "_cache", None)  # numba has no public name for it
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
