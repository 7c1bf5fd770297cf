"""How the kernels of the rigid grain are compiled."""

from harness.compiled import Function, jit


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call: IEEE arithmetic, without a lock."""
    return jit(function, error_model="numpy", nogil=True)
