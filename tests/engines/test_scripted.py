"""What every code that runs scripts has in common, with Python as the code."""

import signal
import subprocess
import sys
from typing import ClassVar

import pytest

from harness.engines.base import Job, Template, Traits
from harness.engines.output import Output
from harness.engines.process import Limits, fresh_folder
from harness.engines.programs import ScriptedEngine
from harness.engines.provenance import Provenance
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.files import PREFIX

SCRIPT = """# {{ name }}, made by dem-harness {{ version }}: {{ variant }} {{ note }}
import os, signal, sys, time
PARAMETERS = {
    "size": {{ size }},
    "mode": "{{ mode }}",
    "record": "no",
}
for number, words in enumerate(sys.argv[1:]):
    size, mode, record = words.split(",")
    if mode == "hang":
        time.sleep(60)
    if mode == "raise":
        raise ValueError("no size at all")
    if mode.startswith("flood"):
        # a file of 102,400 bytes is as long as one may be
        name = {"log": f"{number}.txt", "series": f"{number}.csv"}.get(mode.split()[1])
        if name is None:
            signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
            os.write(1, bytes(60_000))
            os.write(1, bytes(60_000))
            os.write(1, bytes(60_000))
        with open(name, "wb") as file:
            file.write(bytes(102_400))
        if mode == "flood log":
            continue
    rows = "" if mode == "empty" else f"0,{size}\\n1,{size}\\n"
    if record == "yes":
        with open(f"{number}.csv", "a") as series:
            series.write("time_s,x_m\\n" + rows)
    with open(f"{number}.txt", "w") as results:
        results.write(f"RESULT size = {size}\\nRESULT verdict = finished\\n")
"""
BALL = Template(
    "ball",
    {"": {"size": 1.0, "mode": "well", "tail": "clipped"}, "big": {"size": 9.5, "mode": "well"}},
    notes={"big": "a big one"},
    neutral={"tail": "clipped"},
)


class Toy(ScriptedEngine):
    name = "toy"
    extension = "py"
    unused_values = frozenset({"colour"})
    traits = Traits(
        "pip install toy",
        ("3",),
        "velocity-verlet",
        title="Toy",
    )
    switches: ClassVar = {"record": "yes", "everyone": "yes"}
    folders = ()

    @classmethod
    def own_folders(cls):
        return list(cls.folders)

    @classmethod
    def find(cls, program):
        return super().find(program) if cls.programs or program else sys.executable

    def ask_version(self):
        said, _ = self.ask([self.program, "--version"])
        return Provenance("toy", said.split()[1], (), self.program, "executable")

    def command(self, folder, tasks):  # noqa: ARG002
        words = [
            ",".join(str(task.values.get(name, "no")) for name in ("size", "mode", "record"))
            for task in tasks
        ]
        return [self.program, tasks[0].script.name, *words]


class Varied(Toy):
    name = "varied"
    renders_variants = True


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Give the engines a folder of templates."""
    (tmp_path / "ball.py.j2").write_text(SCRIPT, encoding="utf-8")
    monkeypatch.setattr(Toy, "folders", (tmp_path,))
    return tmp_path


@pytest.fixture
def toy():
    with Toy(workers=2, limits=Limits(seconds=2.0)) as engine:
        yield engine


def job(size=2.0, mode="well", sampled=False, **more):
    return Job(BALL, {"size": size, "mode": mode, **more}, sampled=sampled)


def test_outputs_are_in_order_with_results_and_provenance_of_the_script(toy):
    outputs = toy.run([job(size) for size in (3.0, 1.0, 2.5)])
    assert [output.number("size") for output in outputs] == [3.0, 1.0, 2.5]
    who = outputs[0].provenance
    assert (who.engine, who.engine_version) == ("toy", sys.version.split()[0])
    assert (who.script, who.script_sha256) == ("ball.py", toy.script(BALL).sha256)
    assert who.integrator == "velocity-verlet"
    assert outputs[0].tables == {}
    assert 0.0 < outputs[0].seconds < 60.0


def test_a_sampled_job_sets_the_switches_that_the_script_has(toy):
    (output,) = toy.run([job(sampled=True)])
    assert output.table(("time_s", "x_m"), 2)["x_m"].tolist() == [2.0, 2.0]


def test_logs_are_headed_by_the_command_and_the_script(toy):
    (good,), (bad,) = toy.run([job()]), toy.run([job(mode="raise")])
    for log, mode in ((good.log, "well"), (bad.log, "raise"), (toy.logs()["ball.py"], "well")):
        head, digest, *_ = log.splitlines()
        assert head.endswith(f" ball.py size=2.0 mode={mode}")
        assert digest.endswith(toy.script(BALL).sha256)
    assert "ValueError: no size at all" in bad.log


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"colour": "red"}, ""),
        ({"tail": "clipped"}, ""),
        ({"tail": "attractive"}, "no variable 'tail' (tail = 'attractive')"),
        ({"weight": 2.0}, r"its script ball.py has no variable 'weight' (weight = 2.0)"),
        ({"effective_mass": "full"}, "no variable 'effective_mass'"),
    ],
)
def test_a_value_that_the_script_cannot_be_told_is_refused_before_anything_runs(toy, more, said):
    wanted = job(**more)
    if not said:
        assert toy.refuses(wanted) == ""
        assert isinstance(toy.run([wanted])[0], Output)
        return
    assert said in toy.refuses(wanted)
    with pytest.raises(RequestError, match=r"^engine 'toy' cannot run 'ball': "):
        toy.run([job(), wanted])
    assert toy.logs() == {}


def test_scripts_and_scenes_keep_the_order_of_jobs(toy, monkeypatch):
    jobs = [Job(Template(name, {"": {}}), {}) for name in "abcd"]
    monkeypatch.setattr(toy, "check", lambda _: None)
    monkeypatch.setattr(toy, "has_template", lambda template: template.name in "bd")
    for way in ("_run_scripts", "run_scene_jobs"):
        monkeypatch.setattr(
            toy, way, lambda some, w=way: [EngineError(f"{w} {job.template.name}") for job in some]
        )
    assert [str(outcome) for outcome in toy.run(jobs)] == [
        "run_scene_jobs a", "_run_scripts b", "run_scene_jobs c", "_run_scripts d",
    ]  # fmt: skip


def test_variants_are_scripts_of_their_own_or_values_of_the_main_one(toy):
    assert set(Toy.inputs([BALL])) == {"ball.py"}
    assert set(Varied.inputs([BALL])) == {"ball.py", "ball-big.py"}
    assert "made by dem-harness" in Varied.inputs([BALL])["ball-big.py"]
    assert ": big a big one\n" in Varied.script(BALL, "big").text
    (output,) = toy.run([Job(BALL, {}, "big")])
    assert output.number("size") == 9.5
    with pytest.raises(RequestError, match="'ball' has no variant 'bog': must be one of"):
        Toy.script(BALL, "bog")


def test_templates_of_another_package_lie_there_by_the_name_of_the_engine(tmp_path, monkeypatch):
    package = tmp_path / "elsewhere" / "rolling_case"
    (package / "templates" / "toy").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "templates" / "toy" / "ball.py.j2").write_text("# mine\n" + SCRIPT)
    monkeypatch.syspath_prepend(tmp_path / "elsewhere")
    mine = Template("ball", BALL.variants, package="rolling_case")
    assert Toy.script(mine).text.startswith("# mine\n")
    assert Toy.script(BALL).text.startswith("# ball.py")
    missing = Template("ball", BALL.variants, package="no_such_package")
    with pytest.raises(RequestError, match="package 'no_such_package' cannot be imported"):
        Toy.has_template(missing)


def test_a_template_of_the_same_name_with_other_defaults_is_rendered_anew():
    other = Template("ball", {"": {"size": 7.0, "mode": "well"}})
    assert '"size": 1.0' in Toy.script(BALL).text
    assert '"size": 7.0' in Toy.script(other).text


KILLED = """
import os, signal
from harness.engines.process import fresh_folder
with fresh_folder() as folder:
    (folder / "series").touch()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_files_of_a_killed_harness_are_removed_by_the_next_run(toy, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    (tmp_path / "dem-harness-mine").mkdir()
    killed = subprocess.run([sys.executable, "-c", KILLED], check=False)
    assert killed.returncode == -signal.SIGKILL
    (left,) = tmp_path.glob(f"{PREFIX}*")
    assert (left / "series").exists()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with fresh_folder() as other:
        toy.run([job()])
        assert other.is_dir()
    assert {path.name for path in tmp_path.iterdir()} == {"ball.py.j2", "dem-harness-mine"}


@pytest.mark.parametrize("what", ["log", "series", "words"])
def test_what_is_too_long_to_be_read_costs_only_its_own_run(toy, monkeypatch, what):
    monkeypatch.setattr("harness.engines.process.LARGEST_FILE", 102_400)
    bad, good = toy.run([job(mode=f"flood {what}", sampled=True), job(sampled=True)])
    assert type(bad) is EngineOutputError
    assert "102400" in str(bad)
    assert isinstance(good, Output)


class Rendered(ScriptedEngine):
    name = "rendered"
    traits = Traits(install_hint="", versions=("1",), integrator="velocity-verlet")
    programs = ("true",)

    def ask_version(self):
        return Provenance(self.name, "1")

    def command(self, folder, tasks):  # noqa: ARG002
        return ["true"]


@pytest.fixture
def rendered(tmp_path, monkeypatch):
    """Return a function from the text of a template to an engine of another package with it."""

    def make(text):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        (folder / "tilted.py.j2").write_text(text)
        kind = type("Mine", (Rendered,), {"__module__": "my_dem.engine"})
        monkeypatch.setattr(kind, "own_folders", classmethod(lambda _: [folder]))
        monkeypatch.setattr(kind, "_template_folders", classmethod(lambda _: []))
        return kind

    return make


TILTED = Job(Template("tilted", {"": {"angle": 1.0}}, neutral={"angle": 0.0}), {"angle": 1.0})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = 1\nb = {{ no_such_value }}\n", "tilted.py.j2, line 2 cannot be rendered: Undefined"),
        ("a = {% if %}\n", "tilted.py.j2, line 1 cannot be rendered: TemplateSyntaxError"),
        ("a\n\n{{ 1 // 0 }}\n", "tilted.py.j2, line 3 cannot be rendered: ZeroDivisionError"),
    ],
)
def test_a_template_that_fails_is_named_with_its_engine_and_line(rendered, text, words):
    with pytest.raises(EngineError) as error, rendered(text)() as engine:
        engine.refuses(TILTED)
    assert str(error.value).startswith("engine 'rendered' of package 'my_dem': case 'tilted': ")
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_script_that_declares_a_value_and_never_uses_it_is_refused(rendered):
    declared = 'PARAMETERS = {\n    "angle": 0,\n}\n'
    with rendered(declared)() as engine:
        assert "tilted.py declares 'angle' and never uses it (1.0)" in engine.refuses(TILTED)
    with rendered(declared + 'g = PARAMETERS["angle"]\n')() as engine:
        assert engine.refuses(TILTED) == ""
