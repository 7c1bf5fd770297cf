"""The engine with MFiX's stand-in, and MFiX itself: its steps, and a run that fails is named."""

import numpy as np
import pytest

from harness.engines.base import scene_job
from harness.engines.mfix.engine import Mfix
from harness.engines.output import Output
from harness.engines.registry import open_engine
from harness.engines.scenes import motion_in
from harness.errors import (
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    RequestError,
)
from harness.model.law import Law, damping_ratio
from harness.solvers import reference
from tests.engines.mfix.test_scenes import HALF, LAW, SOURCE
from tests.engines.test_plane_scenes import drop, row, tower

SINGLE = 2.0**-23
GOOD = drop(HALF, "held").replace(steps=200)
ELASTIC = Law(normal_stiffness=1e6)
ROW = row(LAW, motion="held", wells=1)
SCENES = {
    "drop": GOOD,
    "drop, source": drop(LAW, "held", 9.81).replace(steps=600),
    "row": ROW.replace(law=Law.linear(1e3, SOURCE, False), step=1e3**0.5 * ROW.step),
    "row, trapped": row(LAW, 8.0, motion="held", wells=1).replace(every=60_000),
    "tower, every third step": tower(ELASTIC).replace(every=3, steps=201),
    "tower, damped": tower(Law.linear(1e6, 0.3, False), motion="held").replace(steps=200),
}


def check_equal(engine, scene):
    """Compare a run with the reference in MFiX's scheme, in single precision."""
    (output,) = engine.run([scene_job(scene)])
    assert isinstance(output, Output), output
    found, expected = motion_in(output, scene), reference.run(scene, engine.rules(scene))
    size = 2.0 * max(np.abs(expected.position[:, :, :2]).max(), 4.0)
    assert found.time == pytest.approx(expected.time, rel=1e-12)
    assert np.abs(found.position - expected.position).max() < 4 * SINGLE * size
    # the first step of a row moves its spheres against the dashpot of the grain
    fixed = [body.motion != "free" for body in scene.bodies]
    speed = 1e-6 if not scene.stages else 1e-5
    assert np.abs((found.velocity - expected.velocity)[:, [not f for f in fixed]]).max() < speed
    if len(scene.bodies) > 2 and not scene.stages:
        largest = np.abs(expected.force).max()
        assert np.abs(found.force - expected.force).max() < 2 * SINGLE * largest
    if scene.stages:
        assert found.stages[:, 0].tolist() == expected.stages[:, 0].tolist()
        assert np.abs(found.stages - expected.stages).max() < 1e-5


@pytest.mark.parametrize("name", [name for name in SCENES if name != "row, trapped"])
def test_a_run_is_the_reference_in_mfix_s_scheme(stand_in, name):
    check_equal(stand_in(), SCENES[name])


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_mfix_itself_is_the_reference_in_its_scheme(mfix, name):
    check_equal(mfix, SCENES[name])


@pytest.mark.live
@pytest.mark.slow
def test_mfix_itself_by_adams_and_bashforth(mfix):
    with Mfix(program=mfix.program, scheme="ADAMS_BASHFORTH") as engine:
        for name in ("drop", "drop, source"):
            check_equal(engine, SCENES[name])


def test_it_names_its_version_and_another_program_is_refused(stand_in):
    with pytest.raises(EngineMissingError, match=r"mfix\.netl\.doe\.gov.*--program mfix=PATH"):
        open_engine("mfix")
    with open_engine("mfix", program=stand_in().program) as engine:
        who = engine.identify()
    assert (who.engine, who.engine_version, who.integrator) == ("mfix", "21.3.2", "mfix-euler")
    # a plain cmake build outside a checkout answers 0.0, in one without tags nothing
    assert {stand_in(how).identify().engine_version for how in ("0.0", "blank")} == {"unversioned"}
    with pytest.raises(EngineMissingError, match=r"not an MFiX solver \(it says: hello"):
        stand_in("another").identify()


def test_a_search_with_cells_of_less_than_two_diameters_loses_the_contacts(stand_in, monkeypatch):
    monkeypatch.setattr("harness.engines.mfix.scenes.SEARCH_CELL", 1.5)
    scene = tower(ELASTIC).replace(steps=50)
    (output,) = stand_in().run([scene_job(scene)])
    assert not motion_in(output, scene).force.any()


FAULTS = {  # by the restitution at which the stand-in has it
    0.25: (EngineNaNError, "signal SIGFPE"),
    0.26: (EngineInputError, "refused its input: Error 1000: Required input"),
    0.27: (EngineInputError, "input: Illegal or unknown input: DES_EN_INPUT = 0.27"),
}


def test_each_way_to_fail_has_its_error_and_costs_only_its_own_run(stand_in):
    laws = [Law.linear(1e6, damping_ratio(restitution), False) for restitution in FAULTS]
    scenes = [*(GOOD.replace(law=law) for law in laws), GOOD]
    *failures, other = stand_in().run([scene_job(scene) for scene in scenes])
    for failed, (error, reason) in zip(failures, FAULTS.values(), strict=True):
        assert type(failed) is error
        assert reason in str(failed)
        assert "\n" not in str(failed)
        assert "DTSOLID_FACTOR" in failed.log
        assert "# particle_input.dat" in failed.log
    assert isinstance(other, Output)


def test_a_sphere_that_is_not_held_is_an_error(stand_in):
    scene = drop(HALF, "held", 9.81).replace(steps=200)
    (outcome,) = stand_in("no hold").run([scene_job(scene)])
    assert isinstance(outcome, EngineOutputError)
    assert "moved a sphere that is to be held" in str(outcome)


def test_adams_bashforth_is_an_option_that_its_inputs_state(stand_in):
    program, options = stand_in().program, {"scheme": "ADAMS_BASHFORTH"}
    with open_engine("mfix", program=program, options=options) as engine:
        assert engine.identify().integrator == engine.traits.integrator == "mfix-adams-bashforth"
        assert engine.deciding_options == options
        assert "in scheme EULER only" in engine.refuses(scene_job(tower(ELASTIC)))
        assert not engine.refuses(scene_job(GOOD))
    with pytest.raises(RequestError, match="scheme=RK4: must be 'EULER' or 'ADAMS_BASHFORTH'"):
        open_engine("mfix", program=program, options={"scheme": "RK4"})
