import re

import pytest

from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.incline.system import TEMPLATE as INCLINE
from harness.cases.tower.system import TEMPLATE as TOWER
from harness.cases.tower.system import job_of, timing_of
from harness.engines.contract import finished
from harness.engines.liggghts.engine import Liggghts
from harness.errors import RequestError
from harness.parameters.tower import Tower

SCRIPTS = [Liggghts.script(template) for template in (INCLINE, TOWER, DROP)]
BY_NAME = pytest.mark.parametrize("script", SCRIPTS, ids=lambda s: s.name)


def code(script):
    return [line for line in script.text.splitlines() if line and not line.startswith("#")]


@BY_NAME
def test_every_variable_that_is_used_is_declared(script):
    text = "\n".join(code(script))
    used = set(re.findall(r"\$\{(\w+)\}", text)) | set(re.findall(r"\bv_(\w+)", text))
    declared = set(re.findall(r"\bvariable (\w+)\s+(?:index|equal|string)\b", text))
    assert used - declared == set()
    assert script.variables <= used


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


@pytest.mark.parametrize("unequal", ["mass", "diameter", "stiffness"])
def test_tower_of_unequal_particles_cannot_be_stated(unequal):
    case = Tower(height=1, law="overlap", **{unequal: (1e6, 2e6)})
    with pytest.raises(RequestError, match="must be one number each in an engine"):
        job_of(case, timing_of(case, 3.0, 1000.0, 100))
