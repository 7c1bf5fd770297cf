"""The readers that LIGGGHTS shares with LAMMPS, on what LIGGGHTS wrote."""

import math

import numpy as np
import pytest

from harness.cases.incline.runs import read as read_incline
from harness.cases.incline.system import Incline, Motion
from harness.cases.tower.run import read
from harness.cases.tower.system import Timing
from harness.engines.lammps.language import error_from_text
from harness.engines.liggghts.engine import Liggghts
from harness.engines.output import Output, read_csv, read_dump, results_in
from harness.engines.programs import with_stages
from harness.errors import (
    EngineInputError,
    EngineLostAtomsError,
)
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC
from harness.parameters.tower import Tower


def read_run(case, log, series=None, route="passage"):
    """Return the run of an incline."""
    tables = {} if series is None else {"series": read_csv(series, "LIGGGHTS", rising=True)}
    output = with_stages(Output(results_in(log), WHO, tables, log, 0.5, "LIGGGHTS"))
    return read_incline(case, route, output, None if series is None else 100)


def read_tower(case, step, dump, who, profiles=False):
    """Return the run that a dump tells of."""
    table = read_dump(dump, "LIGGGHTS")
    every = int(table["step"][1])
    timing = Timing(1.0, step, every * (len(table["step"]) - 1), every, 100.0)
    output = Output((), who, {"series": table}, title="LIGGGHTS")
    return read(case, timing, output, Liggghts.traits, profiles)


WHO = Provenance("liggghts", "LIGGGHTS-PUBLIC 3.8.0")
CASE = Incline(angle=10.3, stiffness=5e3, steps_per_contact=50.0, contact=PLASTIC)
TOWER = Tower(height=2, law="overlap", stiffness=1e4)


def test_passage_with_its_path(recorded):
    log, series = recorded("passage-moves-on.log"), recorded("grain.csv")
    run = read_run(CASE, log, series)
    assert (run.motion, run.steps, run.touching) == (Motion.MOVES_ON, 1550, True)
    assert run.time_s == pytest.approx(1550 * CASE.step, rel=1e-14)
    assert run.crests.margin_J.tolist() == [run.margin_J]
    assert run.trajectory.time_s == pytest.approx(100 * CASE.step * np.arange(16), rel=1e-14)


def test_undecided_run(recorded):
    case = CASE.replace(time_limit=1.0)
    run = read_run(case, recorded("steady-undecided.log"), route="steady")
    assert (run.motion, run.steps, run.crests.time_s.size) == (Motion.UNDECIDED, 360, 1)
    assert run.steps == math.ceil(math.sqrt(CASE.diameter / CASE.gravity) / CASE.step)


def test_tower(recorded):
    run = read_tower(TOWER, 0.1, recorded("tower.dump"), WHO, profiles=True)
    assert run.time.tolist() == [0.0, 3.0, 6.0]
    assert (run.grain_force[0], run.grain_velocity[0]) == (0.0, 2.0)
    overlap = run.profiles.displacements[:, :-1] - run.profiles.displacements[:, 1:]
    assert run.profiles.forces == pytest.approx(1e4 * np.maximum(overlap, 0.0), abs=1e-9)


@pytest.mark.parametrize(
    ("name", "error", "said"),
    [
        ("refused-restitution.log", EngineInputError, "0.05 < coefficientRestitution <= 1"),
        ("lost-atom.log", EngineLostAtomsError, "Lost atoms"),
    ],
)
def test_errors_of_a_log(recorded, name, error, said):
    found = error_from_text(recorded(name), 1, "LIGGGHTS")
    assert type(found) is error
    assert said in str(found)
    assert str(found).startswith("LIGGGHTS ")
