"""The reader on what Kratos wrote, and on what is damaged."""

import numpy as np
import pytest

from harness.cases.incline.judge import run_of_path
from harness.cases.incline.result import Motion
from harness.cases.tower.timing import plan
from harness.chain import exact
from harness.engines.kratos.engine import Kratos
from harness.engines.kratos.read import error_of, finished, read_path, read_tower, seconds_in
from harness.engines.process import Ended
from harness.engines.reference.engine import Reference
from harness.errors import EngineMissingError, EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance

WHO = Provenance("kratos", "10.4.4")
HEAD = "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n"
ROWS = "0,0,1.1,0,-1\n0.1,0,1.0,0,-1\n0.2,0,0.9,0,-1\n"


def test_the_path_of_a_drop_is_the_reference_s(recorded, recorded_drop):
    path = read_path(recorded("drop.csv"), rows=21)
    (expected,) = Reference("velocity-verlet").drops([recorded_drop])
    # a rounding of the position, eps of a metre, is k eps of force; over the time, of velocity
    seconds = recorded_drop.duration * recorded_drop.contact_time
    rounding = np.finfo(float).eps * recorded_drop.stiffness / recorded_drop.mass * seconds
    for name, values in vars(expected.path).items():
        np.testing.assert_allclose(getattr(path, name), values, rtol=0, atol=rounding)


def test_the_path_of_an_incline_gives_what_the_script_says_of_it(recorded, recorded_incline):
    results = dict(
        line.removeprefix("RESULT ").split(" = ") for line in recorded("incline.txt").splitlines()
    )
    path = read_path(recorded("incline.csv"))
    run = run_of_path(recorded_incline, "passage", path, WHO, seconds=0.0)
    assert run.motion is Motion.MOVES_ON
    assert run.motion.value == results["verdict"]
    assert run.margin_J == pytest.approx(float(results["margin_J"]), rel=1e-12)
    assert run.steps == int(results["steps"])
    assert len(run.crests.time_s) == int(results["crests_passed"])
    assert run.touching


def test_a_tower_is_read_with_the_forces_of_its_contacts(recorded, recorded_tower):
    timing = plan(recorded_tower, 3.0, 100.0, 60)
    run = read_tower(recorded_tower, timing, recorded("tower.csv"), WHO, profiles=True)
    assert run.time[-1] == pytest.approx(3.0 * recorded_tower.contact_time, rel=1e-14)
    # the overlap law: the force of each contact is k times its overlap
    overlap = np.maximum(-np.diff(run.profiles.displacements, axis=1), 0.0)
    np.testing.assert_allclose(run.profiles.forces, 1e5 * overlap, atol=1e-8)
    reference = exact.run(recorded_tower, run.time[-1], samples=len(run.time) - 1)
    rows = np.searchsorted(reference.time, run.time - 1e-9 * run.time[-1])
    # 100 steps a contact of an integrator of second order: (pi / 100)^2
    difference = np.abs(reference.grain_force[rows] - run.grain_force).max()
    assert difference < 1e-3 * reference.grain_force.max()


@pytest.mark.parametrize(
    ("series", "rows", "error", "words"),
    [
        ("", None, EngineOutputError, "0 lines"),
        (HEAD, None, EngineOutputError, "1 lines of a series, not 2"),
        (HEAD + ROWS, 4, EngineOutputError, "4 lines of a series, not 5"),
        (HEAD + ROWS[:-3], None, EngineOutputError, "4 lines of a series"),
        (HEAD + ROWS + "0.3,0,1\n", None, EngineOutputError, "cannot be read"),
        (HEAD + "0,0,1.1,0,-1,4,5\n", None, EngineOutputError, "7 columns instead of 5"),
        (HEAD + ROWS.replace("1.1", "x"), None, EngineOutputError, "cannot be read"),
        (HEAD + ROWS.replace("1.1", "inf"), None, EngineNaNError, "not numbers"),
    ],
)
def test_a_series_that_is_cut_or_damaged_is_named(series, rows, error, words):
    with pytest.raises(error, match=words):
        read_path(series, rows)


def test_a_log_without_a_verdict_is_that_of_a_run_that_did_not_finish(recorded):
    log = recorded("incline.txt")
    assert finished(log)
    assert seconds_in(log) > 0.0
    assert not finished(log[: log.index("RESULT verdict")])


def test_a_python_without_kratos_is_named_with_the_remedy():
    said = "Traceback:\nModuleNotFoundError: No module named 'KratosMultiphysics'"
    error = error_of(Ended(said, 1, 0.1, False), 300.0, Kratos.traits.install_hint)
    assert isinstance(error, EngineMissingError)
    assert "pip install KratosDEMApplication" in str(error)
    assert error.log == said
