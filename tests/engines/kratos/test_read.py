"""What Kratos wrote is read by the cases; how its end and its series are told apart."""

import numpy as np
import pytest

from harness.cases.drop import case as drops
from harness.cases.incline import runs as inclines
from harness.cases.incline.system import Motion, margin
from harness.cases.tower import run as towers
from harness.cases.tower.system import timing_of
from harness.engines.contract import finished
from harness.engines.kratos.engine import Kratos
from harness.engines.process import Ended
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.errors import EngineMissingError, EngineNaNError, EngineOutputError, RequestError
from harness.solvers.chain import exact

HEAD = "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n"
ROWS = "0,0,1.1,0,-1\n0.1,0,1.0,0,-1\n0.2,0,0.9,0,-1\n"


def test_the_path_of_a_drop_is_the_reference_s(recorded, recorded_drop):
    run = drops.read(recorded_drop, recorded("drop"))
    (expected,) = drops.run_drops(Reference("velocity-verlet"), [recorded_drop])
    # a rounding of the position, eps of a metre, is k eps of force; over the time, of velocity
    seconds = recorded_drop.duration * recorded_drop.contact_time
    rounding = np.finfo(float).eps * recorded_drop.stiffness / recorded_drop.mass * seconds
    for name, values in vars(expected.path).items():
        np.testing.assert_allclose(getattr(run.path, name), values, rtol=0, atol=rounding)


def test_an_incline_is_judged_by_its_stages(recorded, recorded_incline):
    output = recorded("incline")
    run = inclines.read(recorded_incline, "passage", output, "linear", 50)
    assert run.motion is Motion.MOVES_ON
    steps, path = int(output.text("steps")), run.trajectory
    assert run.steps == steps == 50 * (len(path.time_s) - 1)
    last = (path.x_m[-1], path.y_m[-1], path.vx_m_per_s[-1], path.vy_m_per_s[-1])
    assert run.margin_J == pytest.approx(margin(recorded_incline, 1, *last), rel=1e-12)
    assert len(run.crests.time_s) == 1
    assert run.touching


def test_a_tower_is_read_with_the_forces_of_its_contacts(recorded, recorded_tower):
    timing = timing_of(recorded_tower, 3.0, 100.0, 60)
    run = towers.read(recorded_tower, timing, recorded("tower"), Kratos.traits, profiles=True)
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
    ("series", "error", "words"),
    [
        ("", EngineOutputError, "without rows"),
        (HEAD, EngineOutputError, "without rows"),
        (HEAD + ROWS, EngineOutputError, "3 rows of a series of 21"),
        (HEAD + ROWS[:-3], EngineOutputError, "cut in its last row"),
        (HEAD + ROWS + "0.3,0,1\n", EngineOutputError, "incomplete series"),
        (HEAD + "0,0,1.1,0,-1,4,5\n", EngineOutputError, "7 columns under 5 names"),
        (HEAD + ROWS.replace("1.1", "x"), EngineOutputError, "incomplete series"),
        (HEAD + "".join(f"{i},0,inf,0,-1\n" for i in range(21)), EngineNaNError, "not numbers"),
    ],
)
def test_a_series_that_is_cut_or_damaged_is_named(recorded, recorded_drop, series, error, words):
    with pytest.raises(error, match=words):
        drops.read(recorded_drop, recorded("drop", lambda _: series))


def test_a_log_without_a_verdict_is_that_of_a_run_that_did_not_finish(recorded):
    output = recorded("incline")
    assert finished(output.log)
    assert output.number("seconds") > 0.0
    assert not finished(output.log[: output.log.index("RESULT verdict")])


def test_a_python_without_kratos_is_named_with_the_remedy():
    said = "Traceback:\nModuleNotFoundError: No module named 'KratosMultiphysics'"
    with Kratos() as engine:
        error = engine.error_of(Ended(said, 1, 0.1, False), "")
    assert isinstance(error, EngineMissingError)
    assert "pip install KratosDEMApplication" in str(error)


def test_an_option_of_an_integrator_that_it_lacks_is_refused():
    with pytest.raises(RequestError, match=r"kratos\.scheme"):
        open_engine("kratos", options={"scheme": "Forward_Euler"})
