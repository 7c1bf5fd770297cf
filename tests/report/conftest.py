from dataclasses import replace

import numpy as np
import pytest

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.extrapolation import extrapolate
from harness.cases.incline.ladder import QUICK_LADDER
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion
from harness.cases.tower.chain_evidence import chain_evidence
from harness.cases.tower.run import tower
from harness.cases.tower.step_convergence import step_convergence
from harness.comparison.engine_evidence import (
    Declared,
    EngineAngle,
    EngineEvidence,
    EngineTower,
    Rules,
)
from harness.comparison.evidence import InclineEvidence, Recursion, TowerEvidence
from harness.comparison.tolerances import TOLERANCES
from harness.comparison.verdicts import Kind, failed_run, finding, judge, not_tested
from harness.comparison.verification import Verification
from harness.errors import EngineTimeoutError
from harness.observables.provenance import Provenance
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import CONTACTS, PLASTIC
from harness.parameters.tower import Tower

ENGINE = Provenance("lammps", "1 Jan 2030", ("GRANULAR",), "/bin/lmp", "executable")


def _angle(case):
    value = 10.2 - 40 * case.static_overlap - 20 * case.static_overlap / case.steps_per_contact
    return CriticalAngle(value, 1e-4, 1e-5, "passage", case, ENGINE)


def _run(angle, motion):
    time = np.linspace(0, 10, 200)
    path = Trajectory(time, time, 0.9 + 0.1 * np.cos(time), 1 + 0 * time, np.sin(time))
    crests = Crests(np.arange(3.0), np.array([0.1, 0.05, 0.02]))
    case = Incline(angle=angle)
    return InclineRun(case, motion, 0.01, True, crests, 10.0, 1000, 0.1, ENGINE, path)


def _hung():
    error = EngineTimeoutError("5 s")
    error.log = "# lmp -in incline-source.in -var angle 10.2\nLAMMPS (1 Jan 2030)\nStep 1 <&> 2\n"
    return error


@pytest.fixture(scope="session")
def verification():
    """A verification with every kind of row and of evidence, made up."""
    width = TOLERANCES["critical angle, extrapolated"]
    angles = [_angle(case) for case in QUICK_LADDER.cases(Incline(contact=PLASTIC))]
    by_contact = {
        name: [_angle(Incline(contact=contact, steps_per_contact=n)) for n in (50.0, 100.0)]
        for name, contact in CONTACTS.items()
    }
    runs = [_run(10.20, Motion.TRAPPED), _run(10.22, Motion.MOVES_ON)]
    towers = TowerEvidence()
    chain_evidence(towers)
    energies = np.array([0.12, 0.08, 0.06])
    return Verification(
        level="quick",
        started="2030-01-01T00:00:00+00:00",
        seconds=1.5,
        platform="a test",
        harness_version="0",
        provenance=ENGINE,
        checks=(
            judge("angle <holds>", Kind.ANALYTIC, 10.2, 10.2001, width),
            judge("angle | fails", Kind.ANALYTIC, 10.2, 10.3, width),
            failed_run("a run that hung", Kind.CROSS_CODE, _hung()),
            not_tested("no engine", Kind.CROSS_CODE, "not installed"),
            finding("laws differ", 1.0, 2.0, "deg", "as they should"),
        ),
        incline=InclineEvidence(
            closed_form_deg=10.2,
            extrapolated=extrapolate(angles),
            by_contact=by_contact,
            motions=runs,
            recursion=Recursion(runs[1], energies, energies + 1e-5),
        ),
        tower=towers,
        scripts={"incline-plastic.in": "run 0\n"},
        engine_errors=("out of time: 5 s",),
        logs={"incline-plastic.in": "# lmp -in incline-plastic.in\nTotal wall time: 0:00:01\n"},
    )


def _engine_angle(engine, tail, value, **others):
    known = {"reference_deg": value - 1e-4, "microseconds_per_step": 4.9, **others}
    return EngineAngle(
        engine, "plastic", Rules(tail, "full", "linear"), 1e6, 100.0, value, 3e-4, 10.2,
        "velocity-verlet", **known,
    )  # fmt: skip


def _declared(engine, **others):
    return Declared(
        engine, "1.2" if not others.get("missing") else "", "executable", "apt install", ("1.2",),
        "velocity-verlet", ("clipped",), ("full", "half"), "linear", 15,
        **{"lineage": "", "caveats": (), **others},
    )  # fmt: skip


@pytest.fixture(scope="session")
def engine_evidence():
    """Engines beside one another, made up: one that holds, one missing, one not qualified."""
    case = Tower(height=2, law="overlap", stiffness=1e5)
    exact = tower(case, solver="exact", samples=4000)
    order = step_convergence(
        lambda n: tower(case, solver="rk4", steps_per_contact=n), exact, (250.0, 500.0, 1000.0)
    )
    return EngineEvidence(
        closed_form_deg=10.2,
        declared=[
            _declared("yade", caveats=("It <always> clips.", "It counts m/2.")),
            _declared("liggghts", lineage="LAMMPS"),
            _declared("esys", missing="no esysparticle here"),
            _declared("kratos", unqualified="free fall"),
        ],
        angles=[
            _engine_angle("yade", "clipped", 10.2003),
            _engine_angle("liggghts", "attractive", 10.246, lineage="LAMMPS"),
            _engine_angle("mfix (recorded)", "attractive", 10.206, recorded=True),
            _engine_angle("reference", "clipped", 10.2004, microseconds_per_step=0.06),
        ],
        towers=[
            EngineTower("yade", 1, 1e4, 100.001, 100.0, 2.0, 2.0),
            EngineTower("mfix (recorded)", 4, 7071.0, 100.0, 100.0, recorded=True),
        ],
        convergence=[replace(order, solver="yade")],
    )
