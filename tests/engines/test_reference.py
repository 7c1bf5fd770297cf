"""The reference as an engine: any scene by its own rules, scripts before scenes, errors."""

import numpy as np
import pytest

from harness.engines.base import Job, Template, scene_job
from harness.engines.output import SERIES, STAGES, Output
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.engines.scenes import motion_in
from harness.errors import (
    EngineMemoryError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.solvers import reference
from tests.solvers.reference.scenes import HOOKE, difference, impact, on_row

ROW = Template("row", {"": {}})
STAGED, IMPACT = on_row(wells=1, steps=40_000, every=100), impact(HOOKE, (0.0, 0.0, -1.0), every=20)


def output_of(scene, engine=None, *, sampled=True):
    (output,) = (engine or Reference()).run([Job(ROW, {}, sampled=sampled, scene=scene)])
    assert isinstance(output, Output), output
    return output


def test_job_of_a_template_that_is_no_script_runs_its_scene():
    output = output_of(STAGED)
    expected = reference.run(STAGED, Reference().rules(STAGED))
    assert difference(motion_in(output, STAGED), expected) == 0.0
    assert np.array_equal(motion_in(output, STAGED).stages, expected.stages)
    assert list(output_of(STAGED, sampled=False).tables) == [STAGES]
    assert list(output_of(IMPACT).tables) == [SERIES]


@pytest.mark.parametrize("integrator", ["velocity-verlet", "mfix-euler", "mfix-adams-bashforth"])
def test_integrators(integrator):
    engine = open_engine("reference", options={"integrator": integrator})
    assert engine.rules(IMPACT).scheme == integrator.replace("-", "_")
    assert output_of(IMPACT, engine).provenance.integrator == integrator


def test_refusals():
    with pytest.raises(RequestError, match="--integrator 'rk4': must be one of velocity-verlet, m"):
        Reference("rk4")
    with pytest.raises(RequestError, match="has no template 'row'"):
        Reference().run([Job(ROW, {})])


def test_errors_of_one_run_leave_the_others():
    body = IMPACT.bodies[0].replace(velocity=(1e300, 0.0, 0.0))
    bad = IMPACT.replace(bodies=(body,), walls=(), step=1e10, steps=10)
    outcomes = Reference().run([scene_job(one) for one in (IMPACT, bad, IMPACT)])
    assert [type(one) for one in outcomes] == [Output, EngineNaNError, Output]
    huge = IMPACT.replace(steps=10**12, every=1)
    (full,) = Reference().run([scene_job(huge)])
    assert isinstance(full, EngineMemoryError)
    assert "1000000000001 samples of 1 bodies" in str(full)
    (late,) = Reference(seconds=0.0).run([scene_job(on_row(steps=1000))])
    assert isinstance(late, EngineTimeoutError)


def test_motion_of_stages_that_lacks_samples_is_an_error():
    output = output_of(STAGED)
    cut = {SERIES: {n: v[:-1] for n, v in output.tables[SERIES].items()}}
    with pytest.raises(EngineOutputError, match="samples"):
        motion_in(Output((), output.provenance, {**output.tables, **cut}), STAGED)
