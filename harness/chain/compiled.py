"""Compile the kernels of the chain once, ahead of a run, and cache them on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call, keeping its Python type.

    IEEE arithmetic, but for the fusing of a product and a sum. Nothing is
    reordered: equal particles in equal states must stay equal to the last bit.
    """
    decorate = numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
    return cast(Function, decorate(function))
