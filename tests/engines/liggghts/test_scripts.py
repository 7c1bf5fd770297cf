import re

import pytest
from harness.engines.lammps.scripts import check_variables, drop_variables, incline_variables
from harness.engines.lammps.scripts import drop_script as lammps_drop
from harness.engines.lammps.scripts import incline_script as lammps_incline
from harness.engines.lammps.scripts import tower_script as lammps_tower
from harness.engines.liggghts.scripts import (
    all_scripts,
    drop_script,
    incline_script,
    input_files,
    tower_script,
    tower_variables,
)

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.engines.lammps.read import LAST_RESULT
from harness.errors import RequestError
from harness.parameters.contact import CONTACTS
from harness.parameters.tower import Tower

BY_NAME = pytest.mark.parametrize("script", all_scripts(), ids=lambda s: s.name)


def code(script):
    return [line for line in script.text.splitlines() if line and not line.startswith("#")]


@pytest.mark.parametrize(("path", "text"), input_files().items(), ids=input_files())
def test_committed_input_is_what_is_generated(path, text, inputs):
    assert (inputs / path).read_text(encoding="utf-8") == text


def test_every_committed_input_is_generated(inputs):
    committed = {f"liggghts/{path.name}" for path in (inputs / "liggghts").iterdir()}
    assert committed == set(input_files())


@pytest.mark.parametrize(
    ("own", "theirs"),
    [
        *((incline_script(name), lammps_incline(name)) for name in CONTACTS),
        (drop_script(), lammps_drop()),
    ],
    ids=lambda script: script.name,
)
def test_variables_and_their_defaults_are_those_of_lammps(own, theirs):
    assert _defaults(own) == _defaults(theirs)


def test_tower_has_the_variables_of_lammps_but_the_law():
    theirs = _defaults(lammps_tower())
    del theirs["law"]
    assert _defaults(tower_script()) == theirs


def _defaults(script):
    found = dict(re.findall(r"^variable (\w+) +index (\S+)", script.text, re.MULTILINE))
    assert script.variables == set(found)
    return found


@BY_NAME
def test_every_variable_that_is_used_is_declared(script):
    text = "\n".join(code(script))
    used = set(re.findall(r"\$\{(\w+)\}", text)) | set(re.findall(r"\bv_(\w+)", text))
    declared = set(re.findall(r"\bvariable (\w+)\s+(?:index|equal|loop|string)\b", text))
    assert used - declared == set()
    assert script.variables <= used


@BY_NAME
def test_every_jump_has_its_label(script):
    """LIGGGHTS says only "Label wasn't found" of a word that it does not know."""
    text = "\n".join(code(script))
    words = {
        **{"damping": ("ratio", "restitution"), "effective_mass": ("full", "half")},
        **{"tail": ("attractive", "clipped"), "route": ("passage", "steady")},
        **{"record": ("yes", "no"), "everyone": ("yes", "no"), "base": ("fixed", "free")},
        "start": ("touching", "preloaded", "gapped"),
    }
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
    assert LAST_RESULT not in script.text


@pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
def test_everything_a_case_sets_is_declared(contact):
    incline = Incline(contact=contact, steps_per_contact=100)
    check_variables(incline_script(contact.name), incline_variables(incline))
    check_variables(drop_script(), drop_variables(Drop(contact=contact)))
    check_variables(tower_script(), tower_variables(Tower(law="overlap"), 3.0, 100.0))


@pytest.mark.parametrize(
    ("case", "said"),
    [
        (Tower(), "law = 'deformable': LIGGGHTS has the overlap law only"),
        (Tower(law="overlap", mass=(1.0, 2.0)), "must be one number each in LIGGGHTS's tower"),
        (Tower(law="overlap", diameter=(1.0, 2.0)), "must be one number each in LIGGGHTS's tower"),
        (Tower(law="overlap", stiffness=(1e6, 2e6)), "must be one number each in LIGGGHTS's tower"),
    ],
)
def test_tower_that_cannot_be_stated_is_refused_in_one_line(case, said):
    with pytest.raises(RequestError, match=said) as caught:
        tower_variables(case, 3.0, 100.0)
    assert "\n" not in str(caught.value)
