import ast
import math
import re

import pytest

from harness.cases.incline.parameters import Incline
from harness.cases.tower.timing import plan
from harness.engines.yade.scripts import (
    drop_script,
    drop_values,
    incline_script,
    incline_values,
    input_files,
    tower_script,
    tower_values,
)
from harness.errors import RequestError
from harness.parameters.contact import CLIPPED, PLASTIC
from harness.parameters.tower import Tower

SCRIPTS = pytest.mark.parametrize("script", [incline_script(), drop_script(), tower_script()])


def defaults(script):
    """Return PARAMETERS of a script, read without Yade."""
    for node in ast.parse(script.text).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "PARAMETERS":
            return ast.literal_eval(node.value)
    return None


@pytest.mark.parametrize("name", input_files())
def test_committed_input_is_what_is_generated(name, inputs):
    assert (inputs / name).read_text(encoding="utf-8") == input_files()[name]


def test_every_committed_input_is_generated(inputs):
    committed = {f"yade/{path.name}" for path in (inputs / "yade").iterdir()}
    assert committed == set(input_files())


@SCRIPTS
def test_every_parameter_that_is_used_is_declared(script):
    used = set(re.findall(r"\b(?:self\.)?p\.(\w+)", script.text))
    declared = set(defaults(script))
    assert used <= declared
    assert declared - used == set()


@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED, PLASTIC.replace(effective_mass="half")])
def test_a_case_sets_parameters_that_the_script_has_in_types_that_it_keeps(contact, drop, tower):
    told = [
        (incline_script(), incline_values(Incline(contact=contact))),
        (drop_script(), drop_values(drop.replace(contact=contact))),
        (tower_script(), tower_values(tower, plan(tower, 1.0, None, None))),
    ]
    for script, values in told:
        has = defaults(script)
        assert set(values) <= set(has)
        assert all(type(has[name]) is type(value) for name, value in values.items())


def test_numbers_of_the_defaults_are_exact():
    assert defaults(incline_script())["density"] == 6.0 / math.pi


@SCRIPTS
def test_the_traps_of_yade_are_spelled_out(script):
    assert "kn=2 * stiffness, cn=2 * eta" in script.text
    assert "NewtonIntegrator(damping=0, " in script.text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": "deformable"}, r"law = 'deformable': Yade has the overlap law only"),
        ({"mass": (1.0, 2.0, 1.0)}, r"must be one number each"),
    ],
)
def test_tower_that_yade_cannot_state_is_a_wrong_request(change, message):
    case = Tower(height=2, **{"law": "overlap", **change})
    with pytest.raises(RequestError, match=message):
        tower_values(case, plan(case, 1.0, None, None))
