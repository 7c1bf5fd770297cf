import ast
import json
import re

import pytest

from harness.cases.contact import motion as contacts
from harness.cases.drop import case as drops
from harness.cases.drop.case import Drop
from harness.cases.incline import system as inclines
from harness.cases.incline.system import Incline
from harness.cases.tower import system as towers
from harness.cases.tower.system import timing_of
from harness.engines.contract import Job, Template
from harness.engines.esys.engine import Esys
from harness.parameters.law import PLASTIC, Contact
from harness.parameters.plane_scene import LOOK
from harness.parameters.tower import Tower

TEMPLATES = [inclines.TEMPLATE, drops.TEMPLATE, towers.TEMPLATE]
ENGINE = Esys.__new__(Esys)
"""Renders and refuses without ESyS-Particle."""


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda template: template.name)
def test_scripts_are_python_and_say_what_they_take(template):
    script = Esys.script(template)
    tree = ast.parse(script.text)
    (stated,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "PARAMETERS"
    )
    has = ast.literal_eval(stated)
    assert script.variables == set(has)
    scene = template.scene({"series_every": LOOK, **template.variants[template.main]}, "Hertz")
    defaults = Esys.scene_values(scene)
    assert set(has) - {"series", "results"} == set(defaults) - {"tail", "damping"}
    assert all(has[name] == defaults[name] for name in set(has) & set(defaults))
    assert f"mpirun -np 2 esysparticle {script.name}" in script.text
    assert all(len(line) <= 120 and line == line.rstrip() for line in script.text.splitlines())


def test_the_inputs_are_the_scripts(inputs):
    committed = {f"esys/{path.name}": path for path in (inputs / "esys").iterdir()}
    names = ["esys/contacts.py", "esys/drop.py", "esys/incline.py", "esys/tower.py"]
    assert sorted(committed) == names
    generated = Esys.inputs([*TEMPLATES, contacts.TEMPLATE])
    assert {name: path.read_text(encoding="utf-8") for name, path in committed.items()} == generated


def told(job):
    """Return the values of a job as its command writes them."""
    line = ENGINE.command_line(ENGINE.task(job))
    return dict(word.split("=", 1) for word in line.split()[5:])


@pytest.fixture(autouse=True)
def _program(monkeypatch):
    monkeypatch.setattr(ENGINE, "program", "/usr/bin/esysparticle", raising=False)


def test_numbers_are_stated_to_the_last_digit():
    case = Drop(contact=PLASTIC, stiffness=1e6 / 3.0, gap=0.1 + 0.2, density=1.1, speed=1.0)
    words = told(drops.job_of(case))
    assert float(words["stiffness"]) == case.stiffness
    assert json.loads(words["y"]) == [case.diameter + case.gap, 0.0]
    assert float(words["mass"]) == case.mass
    assert words["steps"] == "6000"


@pytest.mark.parametrize("mass", ["full", "half"])
@pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
def test_an_incline_states_its_contact_and_its_start(mass, restitution):
    contact = Contact(
        restitution=restitution, damping_ratio=None, effective_mass=mass, tail="clipped"
    )
    case = Incline(contact=contact, steps_per_contact=100.0, phase=0.1 + 0.2)
    words = told(inclines.job_of(case, "passage", 7))
    assert float(words["coefficient"]) == pytest.approx(case.hertz.coefficient, rel=1e-14)
    assert float(words["relaxation"]) == pytest.approx(case.hertz.relaxation, rel=1e-14)
    start = inclines.start_of(case, "passage", "Hertz")
    assert (json.loads(words["x"])[0], json.loads(words["vy"])[0]) == (start.x_m, start.vy_m_per_s)
    assert words["every"] == "7"
    assert told(inclines.job_of(case, "steady"))["every"] == "0"


def test_a_tower_has_the_linear_spring():
    case = Tower(height=2, law="overlap")
    words = told(towers.job_of(case, timing_of(case, 1.0, None, None)))
    assert (words["coefficient"], float(words["stiffness"])) == ("0.0", 1e6)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"law": "deformable"}, r"it has the overlap law only \(law = 'deformable'\)"),
        ({"angle": 1.0}, r"template 'tower' has no value 'angle' \(angle = 1\.0\)"),
        ({"phase": 0.5}, r"template 'tower' has no value 'phase' \(phase = 0\.5\)"),
    ],
)
def test_what_it_cannot_state_is_refused(values, reason):
    case = Tower(height=2, law="overlap")
    job = towers.job_of(case, timing_of(case, 1.0, None, None))
    assert ENGINE.refuses(job) == ""
    assert re.search(reason, ENGINE.refuses(Job(job.template, {**job.values, **values})))


def test_a_template_that_it_does_not_have_is_refused():
    assert ENGINE.refuses(Job(Template("hopper", {"": {}}), {})) == "it has no template 'hopper'"
