"""How the kernels of the reference DEM are compiled."""

from harness.compiled import Function, jit


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call, keeping its Python type.

    IEEE arithmetic in the order written, and without Python's lock, so that
    runs go side by side in threads.
    """
    return jit(function, error_model="numpy", nogil=True)
