import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.incline.system import TEMPLATE, Incline, job_of, values_of
from harness.cases.registry import built_in, get_case
from harness.cases.tower.system import TEMPLATE as TOWER
from harness.engines.lammps.engine import Lammps
from harness.parameters.law import CONTACTS, Contact

SCRIPTS = [
    Lammps.script(template, variant)
    for template in (TEMPLATE, TOWER, DROP)
    for variant in template.variants
]
BY_NAME = pytest.mark.parametrize("script", SCRIPTS, ids=lambda s: s.name)


def defaults(script):
    rows = (line.split() for line in script.text.splitlines())
    return {w[1]: w[3] for w in rows if len(w) > 3 and w[0] == "variable" and w[2] == "index"}


def texts(case):
    """Return what reaches LAMMPS of a case."""
    return {name: Lammps.literal(value) for name, value in values_of(case, "passage").items()}


def code(script):
    return [line for line in script.text.splitlines() if line and not line.startswith("#")]


def test_every_committed_input_is_generated(inputs):
    generated = Lammps.inputs([get_case(name).template for name in built_in()])
    assert {path.name for path in inputs.glob("*.in")} == set(generated)


@BY_NAME
def test_every_variable_that_is_used_is_declared(script):
    text = "\n".join(code(script))
    used = set(re.findall(r"\$\{(\w+)\}", text)) | set(re.findall(r"\bv_(\w+)", text))
    declared = set(re.findall(r"\bvariable (\w+)\s+(?:index|equal|loop|string|atom)\b", text))
    # -var dump FILE asks for one: it has no default
    assert used - declared == {"dump"}


@BY_NAME
def test_every_override_is_used(script):
    text = "\n".join(code(script))
    unused = {n for n in script.variables if f"${{{n}}}" not in text and f"v_{n}" not in text}
    assert unused == set()


@pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
def test_everything_a_case_sets_is_declared(contact):
    values = values_of(Incline(contact=contact, steps_per_contact=100), "passage", 10)
    assert set(values) <= Lammps.script(TEMPLATE, contact.name).variables


def test_contact_without_a_script_of_its_own_runs_the_plastic_one():
    mine = job_of(Incline(contact=Contact(name="mine", restitution=0.3)), "passage")
    assert Lammps.script(mine.template, mine.variant).name == "incline-plastic.in"


@given(st.floats(0.0, 30.0), st.floats(1e5, 1e12))
def test_numbers_reach_lammps_at_full_precision(angle, stiffness):
    variables = texts(Incline(angle=angle, stiffness=stiffness))
    assert float(variables["angle"]) == angle
    assert float(variables["stiffness"]) == stiffness
    assert " " not in "".join(variables.values())


@pytest.mark.parametrize("e", [0.0, 1e-300, 0.3, 1.0])
def test_zeta_of_the_script_is_that_of_the_contact(e):
    variables = texts(Incline(contact=Contact(restitution=e)))
    assert variables["damping"] == "restitution"
    written = float(variables["restitution"])
    # as the script puts it, with its special case
    zeta = 1.0 if written == 0 else -math.log(written) / math.hypot(math.pi, math.log(written))
    assert zeta == pytest.approx(Contact(restitution=e).zeta, abs=1e-15)
