"""The guard: what engines of other packages return and raise becomes errors that name them."""

import numpy as np
import pytest

from harness.cases.drop import CASE
from harness.engines.base import Engine, Output, Traits
from harness.engines.provenance import Provenance
from harness.errors import EngineError, EngineNaNError, EngineOutputError, RequestError

WHO = Provenance("plugin", "1")
JOB = CASE.job(CASE.default)


def plugin(run=list, **methods):
    """Return an engine of another package whose methods are these."""
    members = {
        "name": "plugin",
        "traits": Traits(install_hint="", versions=("1",)),
        "identify": lambda _: WHO,
        "run": lambda _, jobs: run(jobs),
        "__module__": __name__,
    }
    return type("Plugin", (Engine,), {**members, **methods})()


def outputs(**more):
    series = {"step": np.arange(3.0), "x_m": np.zeros(3), **more}
    return lambda jobs: [Output((), WHO, {"series": series}) for _ in jobs]


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda _: [], "run returned 0 outcomes of 2 jobs, must return a list with an Output or"),
        (lambda _: None, "run returned a NoneType, must return a list with an Output"),
        (lambda jobs: [{"x_m": []} for _ in jobs], "run returned a list with a dict, must return"),
        (lambda jobs: [Output((), None) for _ in jobs], "an Output of NoneType, must return a Pro"),
        (lambda jobs: [Output((), WHO, {"series": [1.0]}) for _ in jobs], "a list, must return co"),
        (outputs(y_m=[0.0, 1.0, 2.0]), "column 'y_m' a list, must return an array of numbers"),
        (outputs(y_m=np.array(["a"] * 3)), "column 'y_m' a <U1 array, must return an array"),
        (outputs(y_m=np.zeros((3, 1, 3))), "must return an array of numbers, (M,) or (M, N)"),
        (outputs(y_m=np.zeros(2)), "of several lengths ({'step': 3, 'x_m': 3, 'y_m': 2}), must"),
        (outputs(y_m=np.array([0.0, np.nan, 1.0])), "values that are not numbers in 'y_m', must"),
        (lambda _: 1 // 0, "run raised ZeroDivisionError: integer division or modulo by zero (tes"),
    ],
)
def test_a_flaw_is_an_error_of_each_job_in_one_line_that_names_the_package(run, words):
    outcomes = plugin(run).run([JOB, JOB])
    assert len(outcomes) == 2
    for error in outcomes:
        assert isinstance(error, EngineError)
        assert str(error).startswith("engine 'plugin' of package 'tests': ")
        assert words in str(error)
        assert "\n" not in str(error)


def test_forces_may_be_unknown_and_positions_may_not():
    (output,) = plugin(outputs(fx_N=np.full(3, np.nan))).run([JOB])
    assert isinstance(output, Output)
    (error,) = plugin(outputs(x_m=np.full(3, np.inf))).run([JOB])
    assert isinstance(error, EngineNaNError)


def test_errors_and_refusals_of_an_engine_pass_as_they_are():
    known = EngineOutputError("mine")
    assert plugin(lambda _: [known]).run([JOB]) == [known]
    with pytest.raises(RequestError, match=r"^no$"):
        plugin(lambda _: exec("raise RequestError('no')", globals())).run([JOB])


@pytest.mark.parametrize(
    ("name", "method", "words"),
    [
        ("identify", lambda _: "1.0", "identify returned a str, must return a Provenance"),
        ("refuses", lambda *_: 1 // 0, "refuses raised ZeroDivisionError"),
        ("refuses", lambda *_: None, "refuses returned a NoneType, must return a text"),
        ("fingerprint", lambda _: "mine", "fingerprint returned a str, must return a dictionary"),
        ("rules", lambda *_: {}, "rules returned a dict, must return the Rules of a scene"),
        ("motions", lambda *_: [None], "motions returned a list with a NoneType, must return a"),
        ("motions", lambda *_: [], "motions returned 0 outcomes of 1 jobs, must return a list"),
    ],
)
def test_a_flaw_of_another_method_is_raised(name, method, words):
    arguments = {"refuses": [JOB], "rules": [JOB.scene], "motions": [[JOB]]}.get(name, [])
    with pytest.raises(EngineError, match=f"engine 'plugin' of package 'tests': {words}"):
        getattr(plugin(**{name: method}), name)(*arguments)


def test_a_flaw_of_a_motion_is_an_error_of_each_job_of_the_run():
    members = {"run": Engine.run_scene_jobs, "motions": lambda *_: None, "__module__": __name__}
    outcomes = type("Mine", (type(plugin()),), members)().run([JOB, JOB])
    for error in outcomes:
        assert str(error).startswith("engine 'plugin' of package 'tests': motions returned a NoneT")
