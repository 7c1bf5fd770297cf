"""Compile the kernels of chains; arrays and results, elsewhere, need no compiler."""

from __future__ import annotations

from harness.compiled import Function, jit


def compiled(function: Function) -> Function:
    """Compile ``function`` at its first call, keeping its Python type.

    IEEE arithmetic, but for the fusing of a product and a sum. Nothing is reordered: equal
    particles in equal states stay equal to the last bit. Python's lock is released.
    """
    return jit(function, error_model="numpy", fastmath={"contract"}, nogil=True)
