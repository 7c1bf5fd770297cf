"""How the kernels of the reference DEM are compiled: at the first call, cached on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code, keeping its Python type.

    IEEE arithmetic in the order written, and without Python's lock, so that
    runs go side by side in threads.
    """
    decorate = numba.njit(cache=True, error_model="numpy", nogil=True)
    return cast(Function, decorate(function))
