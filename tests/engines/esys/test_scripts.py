import ast

import pytest

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.tower.timing import plan
from harness.engines.esys.scripts import (
    all_scripts,
    drop_script,
    incline_parameters,
    incline_script,
    input_files,
    tower_parameters,
    tower_script,
)
from harness.engines.input_values import drop_values
from harness.errors import RequestError
from harness.parameters.contact import PLASTIC, Contact
from harness.parameters.tower import Tower


@pytest.mark.parametrize("script", all_scripts(), ids=lambda s: s.name)
def test_scripts_are_python_and_say_what_they_take(script):
    tree = ast.parse(script.text)
    (stated,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "PARAMETERS"
    )
    assert ast.literal_eval(stated) == dict(script.defaults)
    assert f"mpirun -np 2 esysparticle {script.name}" in script.text
    assert all(len(line) <= 120 and line == line.rstrip() for line in script.text.splitlines())


def test_the_inputs_are_the_scripts():
    assert sorted(input_files()) == ["esys/drop.py", "esys/incline.py", "esys/tower.py"]


def numbers(words):
    return dict(word.split("=", 1) for word in words)


def test_numbers_are_stated_to_the_last_digit():
    case = Drop(stiffness=1e6 / 3.0, gap=0.1 + 0.2, density=1.1)
    words = numbers(drop_script().arguments(drop_values(case)))
    assert float(words["stiffness"]) == case.stiffness
    assert float(words["gap"]) == case.gap
    assert words["steps"] == "6000"


def test_an_incline_states_its_contact_and_its_phases():
    cases = [
        Incline(contact=PLASTIC, steps_per_contact=100.0, phase=phase) for phase in (0.1 + 0.2, 0.5)
    ]
    words = numbers(incline_script().arguments(incline_parameters(cases, "passage", 7)))
    assert [float(text) for text in words["phases"].split(",")] == [0.1 + 0.2, 0.5]
    assert (words["damping"], words["damping_ratio"], words["series_every"]) == (
        "ratio",
        "5.0",
        "7",
    )
    by_restitution = Contact(restitution=0.3, damping_ratio=None, effective_mass="half")
    words = incline_parameters([Incline(contact=by_restitution)], "steady", 50)
    assert (words["damping"], words["restitution"]) == ("restitution", 0.3)
    assert words["effective_mass"] == "half"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "law = 'deformable': ESyS-Particle has the overlap law only"),
        ({"law": "overlap", "mass": (1.0, 2.0, 1.0)}, "must be one number each"),
    ],
)
def test_towers_that_it_does_not_have_are_refused(options, words):
    case = Tower(height=2, **options)
    with pytest.raises(RequestError, match=words):
        tower_parameters(case, plan(case, 1.0, None, None))


def test_an_unknown_parameter_is_a_mistake_of_ours():
    with pytest.raises(KeyError, match=r"tower\.py has no parameter angle"):
        tower_script().arguments({"angle": 1.0})
