"""The reference as an engine: any scene by its own rules, scripts before scenes, errors."""

import numpy as np
import pytest

from harness.engines.base import Job, Template, scene_job
from harness.engines.output import SERIES, Output
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.engines.scene_tables import STAGES, motion_in
from harness.errors import EngineNaNError, EngineOutputError, EngineTimeoutError, RequestError
from harness.model.motion import STAGE_COLUMNS
from harness.solvers import reference
from tests.solvers.reference.scenes import HOOKE, difference, impact, on_row

ROW = Template("row", {"": {}})


def output_of(scene, engine=None, *, sampled=True):
    (output,) = (engine or Reference()).run([Job(ROW, {}, sampled=sampled, scene=scene)])
    assert isinstance(output, Output), output
    return output


def test_job_of_a_template_that_is_no_script_runs_its_scene():
    scene = on_row(wells=2, steps=40_000, every=100)
    output = output_of(scene)
    expected = reference.run(scene, Reference().rules(scene))
    assert difference(motion_in(output, scene), expected) == 0.0
    assert list(output.tables[STAGES]) == list(STAGE_COLUMNS)
    assert np.array_equal(motion_in(output, scene).stages, expected.stages)
    assert output.provenance.integrator == "velocity-verlet"


def test_samples_are_left_out_where_they_are_not_wanted():
    assert list(output_of(on_row(wells=1), sampled=False).tables) == [STAGES]


def test_scene_without_stages_has_samples_alone():
    scene = impact(HOOKE, (0.0, 0.0, -1.0), every=20)
    (output,) = Reference().run([scene_job(scene)])
    assert list(output.tables) == [SERIES]


@pytest.mark.parametrize("integrator", ["velocity-verlet", "mfix-euler", "mfix-adams-bashforth"])
def test_integrators(integrator):
    engine = open_engine("reference", options={"integrator": integrator})
    scene = impact(HOOKE, (0.0, 0.0, -1.0), every=20)
    assert engine.rules(scene).scheme == integrator.replace("-", "_")
    assert output_of(scene, engine).provenance.integrator == integrator


def test_refusals():
    with pytest.raises(RequestError, match="must be one of velocity-verlet"):
        open_engine("reference", options={"integrator": "rk4"})
    with pytest.raises(RequestError, match="has no template 'row'"):
        Reference().run([Job(ROW, {})])


def test_errors_of_one_run_leave_the_others():
    scene = impact(HOOKE, (0.0, 0.0, -1.0), every=20)
    body = scene.bodies[0].replace(velocity=(1e300, 0.0, 0.0))
    bad = scene.replace(bodies=(body,), walls=(), step=1e10, steps=10)
    outcomes = Reference().run([scene_job(one) for one in (scene, bad, scene)])
    assert [type(one) for one in outcomes] == [Output, EngineNaNError, Output]


def test_run_that_takes_too_long():
    (outcome,) = Reference(seconds=0.0).run([scene_job(on_row(steps=1000))])
    assert isinstance(outcome, EngineTimeoutError)


def test_motion_of_stages_that_lacks_samples_is_an_error():
    scene = on_row(wells=1, steps=40_000, every=100)
    output = output_of(scene)
    cut = {SERIES: {n: v[:-1] for n, v in output.tables[SERIES].items()}}
    with pytest.raises(EngineOutputError, match="samples"):
        motion_in(Output((), output.provenance, {**output.tables, **cut}), scene)
