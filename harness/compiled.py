"""Compile kernels to machine code at their first call, kept in the cache folder.

Beside the sources, where numba would keep them, they would outlive ``pip uninstall``. A folder
that the user names in ``NUMBA_CACHE_DIR`` comes first.

Numba compiles again when the file of a kernel changes, but not when a kernel that it calls does,
in another file. So the machine code lies under a stamp of all files of the kernel's folder.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from harness.home import KERNELS, cache_place

Function = TypeVar("Function", bound=Callable[..., Any])
Result = TypeVar("Result")

_CHOOSING = threading.Lock()
"""Held while numba is told a folder: threads import kernels side by side."""


@cache
def _stamp(folder: Path) -> str:
    """Return a digest of the Python files of a folder, constants of kernels among them."""
    found = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        found.update(path.name.encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:16]


def jit(function: Function, **options: Any) -> Function:
    """Compile a function with options of ``numba.njit``, keeping its Python type.

    Where the cache folder cannot be written, numba chooses its own.
    """
    config: Any = numba.config
    with _CHOOSING:
        given = config.CACHE_DIR
        try:
            # numba asks for the folder here and not again: other users of numba keep theirs
            place = Path(given) if given else cache_place().path / KERNELS
            config.CACHE_DIR = str(place / _stamp(Path(function.__code__.co_filename).parent))
            return cast(Function, numba.njit(cache=True, **options)(function))
        finally:
            config.CACHE_DIR = given


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call, keeping its Python type.

    IEEE arithmetic in the order written, and without Python's lock, so that runs go side by side
    in threads.
    """
    return jit(function, error_model="numpy", nogil=True)


def shielded(kernel: Callable[..., Result], *arguments: Any) -> Result:
    """Return what a kernel returns, called where an interrupt cannot be raised within.

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
