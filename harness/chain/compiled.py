"""How the kernels of the chain are compiled."""

from harness.compiled import Function, jit


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call, keeping its Python type.

    IEEE arithmetic, but for the fusing of a product and a sum. Nothing is
    reordered: equal particles in equal states must stay equal to the last bit. Python's lock is
    let go: an interrupt is heard while a kernel runs.
    """
    return jit(function, error_model="numpy", fastmath={"contract"}, nogil=True)
