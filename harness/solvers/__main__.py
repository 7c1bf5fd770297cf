"""Compile the kernels of chains: ``python -m harness.solvers`` beside what compiles others."""

import numpy as np

from harness.solvers import chain_exact, chain_stepped
from harness.solvers.chain import make_chain


def compile_chains() -> None:
    """Compile the kernels of the exact propagator and of the steps, which serve both laws."""
    chain = make_chain(np.ones(3), np.full(3, 1e6), deformable=True, speed=1.0, overlap=np.zeros(2))
    chain_exact.run(chain, 0.01, samples=10)
    chain_stepped.run(chain, 0.01, 1e-4, scheme="rk4", samples=10)


if __name__ == "__main__":
    compile_chains()
