import ast
import re

import pytest

from harness.cases.contact import motion as contacts
from harness.cases.drop import case as drops
from harness.cases.incline import system as inclines
from harness.cases.incline.system import Incline
from harness.cases.tower import system as towers
from harness.cases.tower.system import timing_of
from harness.engines.scripts import scene_values
from harness.engines.yade.engine import Yade
from harness.parameters.law import CLIPPED, PLASTIC

TEMPLATES = [inclines.TEMPLATE, drops.TEMPLATE, towers.TEMPLATE]
INPUTS = Yade.inputs([*TEMPLATES, contacts.TEMPLATE])
SCRIPTS = pytest.mark.parametrize("script", [Yade.script(template) for template in TEMPLATES])


def defaults(script):
    """Return PARAMETERS of a script, read without Yade."""
    for node in ast.parse(script.text).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "PARAMETERS":
            return ast.literal_eval(node.value)
    return None


@pytest.mark.parametrize("name", INPUTS)
def test_committed_input_is_what_is_generated(name, inputs):
    assert (inputs / name).read_text(encoding="utf-8") == INPUTS[name]


def test_every_committed_input_is_generated(inputs):
    committed = {f"yade/{path.name}" for path in (inputs / "yade").iterdir()}
    assert committed == set(INPUTS)


@SCRIPTS
def test_every_parameter_that_is_used_is_declared(script):
    used = set(re.findall(r"\b(?:self\.)?p\.(\w+)", script.text))
    declared = set(defaults(script))
    assert used <= declared
    assert declared - used == set()
    assert script.variables == declared


@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED, PLASTIC.replace(effective_mass="half")])
def test_a_job_sets_parameters_that_the_script_has_in_types_that_it_keeps(contact, drop, tower):
    source = Yade.__new__(Yade)  # renders and refuses without Yade
    jobs = [
        inclines.job_of(Incline(contact=contact), "passage", 7),
        drops.job_of(drop.replace(contact=contact)),
        towers.job_of(tower, timing_of(tower, 1.0, None, None)),
    ]
    for job in jobs:
        task = source.task(job)
        assert source.refuses(job) == ""
        has = defaults(task.script)
        # Yade's tails are clipped: nothing to set
        scene = job.template.scene(job.values, "linear")
        assert set(scene_values(scene)) - set(task.values) == {"tail"}
        assert all(type(has[name]) is type(value) for name, value in task.values.items())


@SCRIPTS
def test_the_traps_of_yade_are_spelled_out(script):
    assert "kn=2 * p.stiffness, cn=2 * p.damping" in script.text
    assert "NewtonIntegrator(damping=0, " in script.text


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"law": "deformable"}, r"it has the overlap law only \(law = 'deformable'\)"),
        ({"rolling": 0.1}, r"template 'tower' has no value 'rolling' \(rolling = 0\.1\)"),
    ],
)
def test_what_yade_cannot_state_is_refused(tower, values, reason):
    job = towers.job_of(tower, timing_of(tower, 1.0, None, None))
    job = type(job)(job.template, {**job.values, **values}, sampled=True)
    assert re.search(reason, Yade.__new__(Yade).refuses(job))
