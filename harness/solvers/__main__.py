"""Compile the kernels of chains: ``python -m harness.solvers`` beside what compiles others."""

import numpy as np

from harness.solvers import chain_exact, chain_stepped
from harness.solvers.chain import make_chain

CHAIN = make_chain(np.ones(3), np.full(3, 1e6), deformable=True, speed=1.0, overlap=np.zeros(2))

if __name__ == "__main__":
    chain_exact.run(CHAIN, 0.01, samples=10)
    chain_stepped.run(CHAIN, 0.01, 1e-4, scheme="rk4", samples=10)
