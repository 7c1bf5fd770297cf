import numpy as np
import pytest

from harness.observables.incline import Crests, InclineRun, Motion, Trajectory
from harness.observables.provenance import Provenance
from harness.verbs.reproduction.exhibits import exhibits


class Engine:
    """Stands in for LAMMPS: the lower angle is trapped."""

    def inclines(self, cases, route, *, every):  # noqa: ARG002 - the contract's arguments
        time = np.linspace(0, 40, 3000)
        path = Trajectory(time, time, 1 + 0 * time, 1 + np.sin(time), 0 * time)
        crests, who = Crests(np.arange(3.0), np.zeros(3)), Provenance("lammps", "test")
        fates = (Motion.TRAPPED, Motion.MOVES_ON)
        return [
            InclineRun(case, fate, 0.0, True, crests, 40.0, 100, 0.1, who, path)
            for case, fate in zip(cases, fates, strict=True)
        ]


@pytest.fixture(scope="session")
def source_exhibits():
    return exhibits(Engine())
