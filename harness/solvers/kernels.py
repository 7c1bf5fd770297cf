"""What compiled steps share: how they are compiled, and the parts of a state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from harness.compiled import jit

Function = TypeVar("Function", bound=Callable[..., Any])

POSITION, VELOCITY, SPIN, FORCE, TORQUE = range(5)
PARTS = 5


def kernel(function: Function) -> Function:
    """Compile without reference counts of arrays, which take five sixths of a step.

    Callers keep the arrays; nothing may be allocated.
    """
    return jit(function, error_model="numpy", nogil=True, _nrt=False)


def inlined(function: Function) -> Function:
    """Compile a kernel into its callers."""
    return jit(function, error_model="numpy", nogil=True, inline="always", _nrt=False)
