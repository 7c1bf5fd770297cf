"""Engines of other packages: what they should not raise or return is an error that names them."""

from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop import CASE
from harness.engines.base import SCENE_NAME, Engine, Output, Traits, scene_job
from harness.engines.output import Provenance
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.model.conventions import Rules

WHO = Provenance("plugin", "1")
JOB = CASE.job(CASE.default)
LABEL = "engine 'plugin' of package 'tests': "


def plugin(run=list, **methods):
    """Return an engine of another package whose methods are these."""
    members = {
        "name": "plugin",
        "traits": Traits(install_hint="", versions=("1",)),
        "identify": lambda _: WHO,
        "__module__": __name__,
    }
    members |= {"run": lambda _, jobs: run(jobs)} if run else {}
    return type("Plugin", (Engine,), {**members, **methods})()


def with_column(values):
    series = {"step": np.arange(3.0), "y_m": values}
    return lambda jobs: [Output((), WHO, {"series": series}) for _ in jobs]


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda _: [], "ValueError: 0 outcomes of 2 jobs"),
        (lambda _: None, "TypeError: NoneType in place of list"),
        (with_column(np.array(["a"] * 3)), "column 'y_m' of table 'series' is no array of numbers"),
        (with_column(np.zeros((3, 1, 3))), "'series' is not of shape (M,) or (M, N)"),
        (with_column(np.zeros(2)), "table 'series' has columns of several lengths: [2, 3]"),
        (lambda jobs: [{} for _ in jobs], "TypeError: dict in place of an outcome"),
        (lambda jobs: [Output((), WHO, {"series": [1.0]}) for _ in jobs], "is no mapping of"),
        (lambda _: 1 // 0, "ZeroDivisionError: integer division or modulo by zero"),
    ],
)
def test_a_flawed_run_is_an_error_of_each_job_in_one_line_that_names_the_package(run, words):
    outcomes = plugin(run).run([JOB, JOB])
    assert len(outcomes) == 2
    for error in outcomes:
        assert isinstance(error, EngineError)
        assert str(error).startswith(f"{LABEL}run raised ")
        assert words in str(error)
        assert "\n" not in str(error)


@pytest.mark.parametrize("motions", [lambda *_: None, lambda *_: [], lambda *_: [None, None]])
def test_flawed_motions_are_an_error_of_each_job(motions):
    outcomes = plugin(None, rules=lambda *_: Rules(), motions=motions).run([JOB, JOB])
    assert [str(error)[: len(LABEL)] for error in outcomes] == [LABEL] * 2


def test_scripts_and_scenes_run_in_batches_of_their_own_and_keep_their_places():
    batches = []

    def run(jobs):
        batches.append({job.template.name for job in jobs})
        return [Output((("place", job.values["place"]),), WHO) for job in jobs]

    mixed = [JOB, scene_job(JOB.scene)] * 2
    jobs = [replace(job, values={"place": str(place)}) for place, job in enumerate(mixed)]
    has_template = staticmethod(lambda template: template is JOB.template)
    methods = {"has_template": has_template, "refuses": lambda *_: ""}
    outcomes = dict(plugin(run, **methods).outcomes(jobs))
    assert [outcomes[place].text("place") for place in range(4)] == ["0", "1", "2", "3"]
    assert batches == [{SCENE_NAME}, {JOB.template.name}]
    methods |= dict.fromkeys(("run_scenes", "run_scripts"), lambda _, jobs: run(jobs))
    outcomes = plugin(None, **methods).run(jobs)
    assert [outcome.text("place") for outcome in outcomes] == ["0", "1", "2", "3"]


def test_errors_and_refusals_of_an_engine_pass_as_they_are():
    known = EngineOutputError("mine")
    assert plugin(lambda _: [known]).run([JOB]) == [known]
    with pytest.raises(RequestError, match=r"^no$"):
        plugin(lambda _: exec("raise RequestError('no')", globals())).run([JOB])


@pytest.mark.parametrize(
    ("name", "method", "words"),
    [
        *((name, lambda *_: {}["x"], "KeyError: 'x'")
          for name in ("identify", "fingerprint", "refuses", "rules", "logs", "close",
                       "script_text", "script_digest")),
        ("identify", lambda *_: "1.0", "TypeError: str in place of Provenance"),
        ("refuses", lambda *_: None, "TypeError: NoneType in place of str"),
    ],
)  # fmt: skip
def test_a_method_that_raises_or_returns_another_type_is_named(name, method, words):
    of_job = ("refuses", "script_text", "script_digest")
    arguments = [JOB.scene] if name == "rules" else [JOB] * (name in of_job)
    with pytest.raises(EngineError, match=f"^{LABEL}{name} raised {words}"):
        getattr(plugin(**{name: method}), name)(*arguments)
