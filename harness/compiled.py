"""Compile kernels to machine code at their first call, kept in the cache folder.

Beside the sources, where numba would keep them, they would outlive ``pip uninstall``. A folder
that the user names in ``NUMBA_CACHE_DIR`` comes first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from harness.home import cache_place

Function = TypeVar("Function", bound=Callable[..., Any])

FOLDER = "numba"


def jit(function: Function, **options: Any) -> Function:
    """Compile a function with options of ``numba.njit``, keeping its Python type.

    Where the cache folder cannot be written, numba chooses its own.
    """
    config: Any = numba.config
    given = config.CACHE_DIR
    try:
        # numba asks for the folder here and not again: other users of numba keep theirs
        config.CACHE_DIR = given or str(cache_place().path / FOLDER)
        return cast(Function, numba.njit(cache=True, **options)(function))
    finally:
        config.CACHE_DIR = given
