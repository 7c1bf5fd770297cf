"""Compile the kernels that most tests need, each set of them in one worker of xdist.

In a new home they take more than a minute of a core, which each worker would spend on all of them.
"""

import fcntl

from harness.parameters.tower import Tower
from harness.solvers import hard_sphere, reference
from harness.solvers.chain import exact, rk4
from harness.solvers.pair.integration import integrate
from tests.solvers.pair.scenes import HERTZ, LINEAR, guided, impact
from tests.solvers.reference.scenes import HOOKE, on_row, resting

ROW = Tower(height=2, law="overlap")


def _exact():
    for law in ("overlap", "deformable"):
        exact.run(ROW.replace(law=law), ROW.contact_time)


def _contact():
    for law in (LINEAR, HERTZ):
        integrate(impact(law))
        integrate(guided(law, (100, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0))))


def _stepped():
    for law in ("overlap", "deformable"):
        rk4.run(ROW.replace(law=law), ROW.contact_time)
    hard_sphere.critical_angle(0.1)


def _reference():
    reference.run(resting(HOOKE, 1e-3, 10))
    reference.run(on_row(steps=10))


SETS = {"exact": _exact, "contact": _contact, "stepped": _stepped, "reference": _reference}


def compile_by_turns(folder, worker):
    """Compile the sets that no other worker is at, and wait for the others; locks lie in a folder.

    What another has compiled is read from the cache. ``worker`` is a number, which says where in
    the sets to begin.
    """
    first = worker % len(SETS)
    names = [*SETS][first:] + [*SETS][:first]
    for wait in (fcntl.LOCK_NB, 0):
        for name in names:
            with (folder / f"kernels-{name}").open("w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | wait)
                except BlockingIOError:
                    continue
                SETS[name]()
