import re

import pytest

from harness.cases.contact.motion import TEMPLATE as CONTACT
from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.incline.system import TEMPLATE as INCLINE
from harness.cases.tower.system import TEMPLATE as TOWER
from harness.cases.tower.system import job_of, timing_of
from harness.engines.contract import finished
from harness.engines.liggghts.engine import Liggghts
from harness.errors import RequestError
from harness.parameters.tower import Tower

FILES = Liggghts.inputs([INCLINE, TOWER, DROP, CONTACT])
SCRIPTS = [Liggghts.script(template) for template in (INCLINE, TOWER, DROP)]
EVERY = {"series_every": 50}
BY_NAME = pytest.mark.parametrize("script", SCRIPTS, ids=lambda s: s.name)


def code(script):
    return [line for line in script.text.splitlines() if line and not line.startswith("#")]


@pytest.mark.parametrize(("path", "text"), FILES.items(), ids=FILES)
def test_committed_input_is_what_is_generated(path, text, inputs):
    assert (inputs / path).read_text(encoding="utf-8") == text


def test_every_committed_input_is_generated(inputs):
    committed = {f"liggghts/{path.name}" for path in (inputs / "liggghts").iterdir()}
    assert committed == set(FILES)


@BY_NAME
def test_every_variable_that_is_used_is_declared(script):
    text = "\n".join(code(script))
    used = set(re.findall(r"\$\{(\w+)\}", text)) | set(re.findall(r"\bv_(\w+)", text))
    declared = set(re.findall(r"\bvariable (\w+)\s+(?:index|equal|string)\b", text))
    assert used - declared == set()
    assert script.variables <= used
    scene = next(t for t in (INCLINE, TOWER, DROP) if f"{t.name}.in" == script.name)
    stated = Liggghts.scene_values(scene.scene(scene.variants[scene.main] | EVERY, "linear"))
    assert script.variables == {*stated, "series"}


@BY_NAME
def test_every_jump_has_its_label(script):
    """LIGGGHTS says only "Label wasn't found" of a word that it does not know."""
    text = "\n".join(code(script))
    words = {"tail": ("attractive", "clipped")}
    labels = re.findall(r"^label (\w+)$", text, re.MULTILINE)
    assert len(labels) == len(set(labels))
    for target in re.findall(r"jump SELF ([\w${}]+)", text):
        stem, _, name = target.partition("${")
        choices = [stem + word for word in words[name.rstrip("}")]] if name else [target]
        assert set(choices) <= set(labels)


@BY_NAME
def test_damping_is_never_left_to_liggghts(script):
    text = "\n".join(code(script))
    (style,) = re.findall(r"^pair_style (.*)$", text, re.MULTILINE)
    assert "model hooke/stiffness" in style
    assert "absolute_damping on" in style
    assert "tangential off" in style
    assert "dimension 3" in text


@BY_NAME
def test_language_is_that_of_the_old_lammps(script):
    text = "\n".join(code(script))
    assert ":%" not in text
    assert not re.search(r"== [a-z]", text)


@BY_NAME
def test_log_that_only_echoes_the_script_is_no_result(script):
    assert not finished(script.text)


def test_tower_of_the_deformable_law_is_refused_in_one_line(program):
    case = Tower()
    job = job_of(case, timing_of(case, 3.0, None, None))
    with Liggghts(program) as engine, pytest.raises(RequestError) as caught:
        engine.run([job])
    assert "it has the overlap law only (law = 'deformable')" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("unequal", ["mass", "diameter", "stiffness"])
def test_tower_of_unequal_particles_cannot_be_stated(unequal):
    case = Tower(height=1, law="overlap", **{unequal: (1e6, 2e6)})
    with pytest.raises(RequestError, match="must be one number each in an engine"):
        job_of(case, timing_of(case, 3.0, 1000.0, 100))
