import re

import pytest

from harness.cases.contact.motion import TEMPLATE as CONTACT
from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.incline.system import TEMPLATE as INCLINE
from harness.cases.penetration import TEMPLATE as PENETRATION
from harness.cases.tower.system import TEMPLATE as TOWER
from harness.cases.tower.system import job_of, timing_of
from harness.engines.contract import finished
from harness.engines.lammps.engine import Lammps
from harness.engines.liggghts.engine import Liggghts
from harness.errors import RequestError
from harness.parameters.law import CONTACTS
from harness.parameters.tower import Tower

FILES = Liggghts.inputs([INCLINE, TOWER, DROP, CONTACT, PENETRATION])
SCRIPTS = [Liggghts.script(t, v) for t in (INCLINE, TOWER, DROP) for v in t.variants]
BY_NAME = pytest.mark.parametrize("script", SCRIPTS, ids=lambda s: s.name)


def code(script):
    return [line for line in script.text.splitlines() if line and not line.startswith("#")]


@pytest.mark.parametrize(("path", "text"), FILES.items(), ids=FILES)
def test_committed_input_is_what_is_generated(path, text, inputs):
    assert (inputs / path).read_text(encoding="utf-8") == text


def test_every_committed_input_is_generated(inputs):
    committed = {f"liggghts/{path.name}" for path in (inputs / "liggghts").iterdir()}
    assert committed == set(FILES)


@pytest.mark.parametrize("variant", CONTACTS)
def test_variables_and_their_defaults_are_those_of_lammps(variant):
    for template, name in ((INCLINE, variant), (DROP, "")):
        own, theirs = (kind.script(template, name) for kind in (Liggghts, Lammps))
        assert _defaults(own) == _without(_defaults(theirs), "thermo")


def test_tower_has_the_variables_of_lammps_but_the_law():
    theirs = _without(_defaults(Lammps.script(TOWER)), "law", "thermo")
    assert _defaults(Liggghts.script(TOWER)) == theirs


def _without(defaults, *names):
    return {name: value for name, value in defaults.items() if name not in names}


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
    assert not finished(script.text)


def test_everything_a_case_sets_is_declared_or_a_rule_of_the_engine():
    for template in (INCLINE, TOWER, DROP):
        for variant, values in template.variants.items():
            left = set(values) - Liggghts.script(template, variant).variables
            assert left == ({"law"} if template is TOWER else set())
            assert left <= set(Liggghts.traits.fixed_values)


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
