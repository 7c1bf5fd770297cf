"""What every code that runs scripts has in common, with Python as the code."""

import sys
from typing import ClassVar

import pytest

from harness.cases.registry import get_case, homes
from harness.engines.base import Job, Template, Traits
from harness.engines.output import Output, Provenance
from harness.engines.process import Limits
from harness.engines.registry import ENGINES, engine_class
from harness.engines.scripts import ScriptedEngine
from harness.errors import EngineError, RequestError

SCRIPT = """# {{ name }}, made by dem-harness {{ version }}: {{ variant }} {{ note }}
import json, sys
PARAMETERS = {
    "size": {{ size }},
    "mode": "{{ mode }}",
    "record": "no",
}
for run in json.load(open(sys.argv[1])):
    run = {**PARAMETERS, **run}
    mode, size = run["mode"], run["size"]
    if mode == "raise":
        raise ValueError("no size at all")
    if run["record"] == "yes":
        open(run["series"], "a").write(f"time_s,x_m\\n0,{size}\\n1,{size}\\n")
    open(run["results"], "w").write(f"RESULT size = {size}\\nRESULT verdict = finished\\n")
"""
BALL = Template(
    "ball",
    {"": {"size": 1.0, "mode": "well", "tail": "clipped"}, "big": {"size": 9.5, "mode": "well"}},
    notes={"big": "a big one"},
    neutral={"tail": "clipped"},
)


class Toy(ScriptedEngine):
    name = "toy"
    traits = Traits("pip install toy", ("3",), title="Toy")
    switches: ClassVar = {"record": "yes", "everyone": "yes"}
    folder = None

    @classmethod
    def _folders(cls, package):
        return super()._folders(package) if package else (cls.folder,)

    @classmethod
    def find(cls, program):
        return sys.executable if program is None else super().find(program)

    def ask_version(self):
        said, _ = self.ask([self.program, "--version"])
        return Provenance("toy", said.split()[1], (), self.program, "executable")


class Varied(Toy):
    name = "varied"
    renders_variants = True


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    """Give the engines a folder of templates."""
    Toy.folder = tmp_path_factory.mktemp("templates")
    (Toy.folder / "ball.py.j2").write_text(SCRIPT, encoding="utf-8")


@pytest.fixture
def toy():
    with Toy(workers=2, limits=Limits(seconds=2.0)) as engine:
        yield engine


def job(size=2.0, mode="well", sampled=False, **more):
    return Job(BALL, {"size": size, "mode": mode, **more}, sampled=sampled)


def test_outputs_are_in_order_with_results_and_provenance_of_the_script(toy):
    outputs = toy.run([job(3.0), job(1.0, sampled=True), job(2.5)])
    assert [output.number("size") for output in outputs] == [3.0, 1.0, 2.5]
    assert outputs[0].tables == {}
    assert outputs[1].table(("time_s", "x_m"), 2)["x_m"].tolist() == [1.0, 1.0]
    who = outputs[0].provenance
    assert (who.engine, who.engine_version) == ("toy", sys.version.split()[0])
    assert (who.script, who.script_sha256) == ("ball.py", toy.script(BALL).sha256)
    assert who.integrator == "velocity-verlet"
    assert 0.0 < outputs[0].seconds < 60.0


def test_logs_are_headed_by_the_command_and_the_script(toy):
    (good,), (bad,) = toy.run([job()]), toy.run([job(mode="raise")])
    for log, mode in ((good.log, "well"), (bad.log, "raise"), (toy.logs()["ball.py"], "well")):
        head, digest, *_ = log.splitlines()
        assert head.endswith(f" ball.py size=2.0 mode={mode}")
        assert digest.endswith(toy.script(BALL).sha256)
    assert "ValueError: no size at all" in bad.log


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ({"tail": "clipped"}, ""),
        ({"tail": "attractive"}, "no variable 'tail' (tail = 'attractive')"),
        ({"weight": 2.0}, r"its script ball.py has no variable 'weight' (weight = 2.0)"),
    ],
)
def test_a_value_that_the_script_has_no_variable_for_is_refused_first(toy, more, reason):
    wanted = job(**more)
    if not reason:
        assert isinstance(toy.run([wanted])[0], Output)
        return
    assert reason in toy.refuses(wanted)
    with pytest.raises(RequestError, match=r"^engine 'toy' cannot run 'ball': "):
        toy.run([job(), wanted])
    assert toy.logs() == {}


def test_variants_are_scripts_of_their_own_or_values_of_the_main_one(toy):
    assert set(Toy.inputs([BALL])) == {"ball.py"}
    assert set(Varied.inputs([BALL])) == {"ball.py", "ball-big.py"}
    assert ": big a big one\n" in Varied.script(BALL, "big").text
    (output,) = toy.run([Job(BALL, {}, "big")])
    assert output.number("size") == 9.5
    with pytest.raises(RequestError, match="'ball' has no variant 'bog': must be one of"):
        Toy.script(BALL, "bog")


def test_templates_of_another_package_and_of_other_defaults(tmp_path, monkeypatch):
    package = tmp_path / "rolling_case"
    (package / "templates" / "toy").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "templates" / "toy" / "ball.py.j2").write_text("# mine\n" + SCRIPT)
    monkeypatch.syspath_prepend(tmp_path)
    assert Toy.script(Template("ball", BALL.variants, package="rolling_case")).text[:6] == "# mine"
    assert '"size": 1.0' in Toy.script(BALL).text
    assert '"size": 7.0' in Toy.script(Template("ball", {"": {"size": 7.0, "mode": ""}})).text
    with pytest.raises(RequestError, match="package 'no_such_package': it cannot be imported"):
        Toy.has_template(Template("ball", BALL.variants, package="no_such_package"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("b = {{ no_such_value }}\n", "UndefinedError: 'no_such_value' is undefined"),
        ("a = {% if %}\n", "TemplateSyntaxError"),
    ],
)
def test_a_template_that_fails_is_named_with_its_engine(tmp_path, text, words):
    kind = type("Mine", (Toy,), {"__module__": __name__, "folder": tmp_path})
    (tmp_path / "ball.py.j2").write_text(text)
    with pytest.raises(EngineError) as error, kind() as engine:
        engine.refuses(job())
    where = "engine 'toy' of package 'tests': case 'ball': template ball.py.j2 cannot be rendered"
    assert str(error.value).startswith(f"{where}: {words}")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ENGINES)
def test_no_script_declares_a_value_that_changes_the_motion_and_never_uses_it(name):
    kind = engine_class(name)
    jobs = [case.job(case.default) for case in map(get_case, homes())]
    for template in [job.template for job in jobs] if issubclass(kind, ScriptedEngine) else ():
        for variant in template.variants if kind.has_template(template) else ():
            script = kind.script(template, variant)
            for variable in script.variables & template.neutral.keys():
                stem = variable.rpartition("_")[0] + "_"  # a name may be put together of its stem
                stems = [v for v in script.variables if v == variable or v.startswith(stem)]
                uses = script.text.count(stem if "_" in variable else variable)
                assert uses > len(stems), f"{script.name}: {variable}"
