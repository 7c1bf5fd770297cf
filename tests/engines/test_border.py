"""What engines of other packages return, raise and leave unread: an error each that names them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop.case import CASE
from harness.engines.border import ReadValues
from harness.engines.contract import Engine, Job, Output, Template
from harness.engines.programs import ScriptedEngine
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance

TRAITS = Traits(install_hint="", versions=("1",), integrator="velocity-verlet")
WHO = Provenance("plugin", "1")
JOB = CASE.job(CASE.default)
NEUTRAL = {
    **{"up_x": 0.0, "up_y": 0.0, "up_z": 1.0},
    **{"drift_x": 0.0, "drift_y": 0.0, "drift_z": 0.0},
    **{"gravity_z": 0.0, "friction": 0.0},
}
TEMPLATE = Template("contacts", {"plane": {"friction": 0.3, "gravity_z": -9.81}}, neutral=NEUTRAL)
WALL = Job(TEMPLATE, TEMPLATE.variants["plane"], "plane", sampled=True)


class Plugin(Engine):
    """An engine of another package, which does what a test says."""

    name = "plugin"
    traits = TRAITS

    def __init__(self, run, who=WHO):
        self._run, self._who = run, who

    @classmethod
    def states(cls, template):  # noqa: ARG003
        return True

    def identify(self):
        return self._who

    def run(self, jobs):
        return self._run(jobs)


def table(**more):
    return {"series": {"step": np.arange(3.0), "x_m": np.zeros(3), **more}}


def output(tables):
    return Output((), WHO, tables)


def divided(jobs):
    return 1 / (len(jobs) - len(jobs))


@pytest.mark.parametrize(
    ("run", "said"),
    [
        (lambda _: [], "run returned 0 outcomes, must return a list with an Output or an Engine"),
        (lambda _: None, "run returned a NoneType, must return a list with an Output"),
        (lambda jobs: [{"x_m": []} for _ in jobs], "run returned a dict for a job, must return an"),
        (lambda jobs: [Output((), None) for _ in jobs], "an Output of NoneType, must return a Pro"),
        (
            lambda jobs: [output({"series": [1.0]}) for _ in jobs],
            "table 'series' as a list, must return columns by name",
        ),
        (
            lambda jobs: [output(table(y_m=[0.0, 1.0, 2.0])) for _ in jobs],
            "column 'y_m' of table 'series' as a list, must return an array of numbers",
        ),
        (
            lambda jobs: [output(table(y_m=np.array(["a"] * 3))) for _ in jobs],
            "column 'y_m' of table 'series' as a <U1 array, must return",
        ),
        (
            lambda jobs: [output(table(y_m=np.zeros(2))) for _ in jobs],
            r"columns of several lengths (step: 3, x_m: 3, y_m: 2), must return one for all",
        ),
        (divided, "run raised ZeroDivisionError: division by zero (test_border.py, line "),
    ],
)
def test_what_is_no_outcome_is_an_error_of_each_job_that_names_the_package(run, said):
    outcomes = Plugin(run).run([JOB, JOB])
    assert len(outcomes) == 2
    for error in outcomes:
        assert isinstance(error, EngineError)
        assert str(error).startswith("engine 'plugin' of package 'tests': ")
        assert said in str(error)
        assert "\n" not in str(error)


def test_errors_and_refusals_of_an_engine_pass_as_they_are():
    def refuse(_):
        raise RequestError("no")

    known = EngineOutputError("mine")
    assert Plugin(lambda _: [known]).run([JOB]) == [known]
    with pytest.raises(RequestError, match=r"^no$"):
        Plugin(refuse).run([JOB])


def test_identify_returns_a_provenance():
    with pytest.raises(EngineOutputError, match="'tests': identify returned a str, must return a"):
        Plugin(list, who="1.0").identify()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ({"refuses": lambda *_: 1 // 0}, "refuses raised ZeroDivisionError"),
        ({"refuses": lambda *_: None}, "refuses returned a NoneType, must return a text"),
        ({"fingerprint": lambda _: {"x": print}}, "fingerprint raised TypeError: Object of type"),
        ({"fingerprint": lambda _: "mine"}, "fingerprint returned a str, must return a dictionary"),
    ],
)
def test_what_is_asked_beside_runs_is_checked_as_well(call, said):
    (name,) = call
    kind = type("Mine", (Plugin,), {**call, "__module__": __name__})
    with pytest.raises(EngineError, match=f"engine 'plugin' of package 'tests': {said}"):
        getattr(kind(list), name)(*[JOB] * (name == "refuses"))


# ---- values that are not read ------------------------------------------------------------------


def turned(**values):
    return replace(WALL, values={**WALL.values, "walls_as": "region", **NEUTRAL, **values})


def read(*names):
    def run(jobs):
        for job in jobs:
            for name in names:
                job.values[name]
        return [output(table()) for _ in jobs]

    return Plugin(run)


def test_a_value_that_turns_the_walls_and_is_not_read_is_named():
    job = turned(up_x=0.48, up_z=0.6, drift_y=0.1)
    (error,) = read("up_z", "friction", "up_y").run([job])
    assert isinstance(error, EngineOutputError)
    assert "run ignored up_x = 0.48, drift_y = 0.1 of template 'contacts'" in str(error)
    (found,) = read("up_x", "up_z", "drift_y", "friction").run([job])
    assert isinstance(found, Output)


def test_values_that_change_nothing_may_be_left_unread():
    (found,) = read("friction").run([turned()])
    assert isinstance(found, Output)


@pytest.mark.parametrize(
    "everything",
    [dict, list, lambda v: {**v}, lambda v: v | {}, json.dumps, lambda v: v.items(), dict.copy],
    ids=["dict", "list", "stars", "or", "json", "items", "copy"],
)
def test_one_who_takes_all_values_has_read_all(everything):
    if everything is dict.copy:
        everything = ReadValues.copy
    values = ReadValues({"up_x": 1.0, "up_z": 0.0})
    everything(values)
    assert values.read == {"up_x", "up_z"}


# ---- templates ---------------------------------------------------------------------------------


class Scripted(ScriptedEngine):
    name = "scripted"
    traits = TRAITS
    programs = ("true",)

    def ask_version(self):
        return WHO

    def command(self, folder, tasks):  # noqa: ARG002
        return ["true"]


@pytest.fixture
def scripted(tmp_path, monkeypatch):
    """Return a function from the text of a template to an engine that has it for contacts."""

    def make(text):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        (folder / "contacts.py.j2").write_text(text)
        kind = type("Mine", (Scripted,), {"__module__": "my_dem.engine"})
        monkeypatch.setattr(kind, "own_folders", classmethod(lambda _: [folder]))
        monkeypatch.setattr(kind, "_template_folders", classmethod(lambda _: []))
        return kind

    return make


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 1\nb = {{ no_such_value }}\n", "contacts.py.j2, line 2 cannot be rendered: Undefin"),
        ("a = {% if %}\n", "contacts.py.j2, line 1 cannot be rendered: TemplateSyntaxError"),
        ("a\n\n{{ 1 // 0 }}\n", "contacts.py.j2, line 3 cannot be rendered: ZeroDivisionError"),
    ],
)
def test_a_template_that_fails_is_named_with_its_engine_and_line(scripted, text, said):
    with pytest.raises(EngineError) as error, scripted(text)() as engine:
        engine.refuses(WALL)
    assert str(error.value).startswith("engine 'scripted' of package 'my_dem': case 'contacts': ")
    assert said in str(error.value)
    assert "\n" not in str(error.value)


NAMES = [*WALL.values, "walls_as", *NEUTRAL]
DECLARED = "PARAMETERS = {\n" + "".join(f'    "{n}": 0,\n' for n in NAMES) + "}\n"


def test_a_script_that_declares_a_value_and_never_uses_it_is_refused(scripted):
    job = turned(up_x=1.0, up_z=0.0, gravity_z=0.0, friction=0.0)
    with scripted(DECLARED)() as engine:
        assert "contacts.py declares 'up_x' and never uses it (1.0)" in engine.refuses(job)
    used = DECLARED + 'normal = [PARAMETERS[f"up_{axis}"] for axis in "xyz"]\n'
    with scripted(used)() as engine:
        assert engine.refuses(job) == ""
