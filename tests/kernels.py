"""Compile the kernels that most tests need, each set of them in one worker of xdist.

In a new home they take more than a minute of a core, which each worker would spend on all of them.
In a new clone Hypothesis makes a table of all characters, for 3 s, and keeps it: likewise.
"""

import fcntl

from hypothesis import given, settings
from hypothesis import strategies as st

from harness.cases.incline.columns import Columns, scene_of
from harness.cases.tower.runs import compile_chains
from harness.engines.process import cores
from harness.solvers import hard_sphere, reference
from harness.solvers.chain_stepped import run_columns
from harness.solvers.contact_time import contact_time
from tests.solvers.reference.scenes import HERTZ, HOOKE, resting
from tests.solvers.test_contact_time import impact as touching

SETS = {  # the longest first
    # contact times are by the forces of the reference
    "reference": lambda: [*(reference.run(resting(law, 1e-3, 10)) for law in (HOOKE, HERTZ)),
                          contact_time(touching(HERTZ))],
    "chain": compile_chains,
    "columns": lambda: run_columns(scene_of(Columns(n=1, stiffness=1e4)), 1),
    "rigid": lambda: hard_sphere.critical_angle(0.1),
    "characters": settings(max_examples=1, database=None)(given(st.text())(lambda _: None)),
}  # fmt: skip


def compile_by_turns(folder, worker):
    """Compile the sets that no other worker is at, and wait for the others; locks lie in a folder.

    What another has compiled is read from the cache. ``worker`` is a number, from 0 on: one beyond
    the number of cores waits alone, as the longest set takes as long as all others.
    """
    for wait in (fcntl.LOCK_NB, 0) if worker < cores() else (0,):
        for name in SETS:
            with (folder / f"kernels-{name}").open("w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | wait)
                except BlockingIOError:
                    continue
                SETS[name]()
