"""Scripts run by hand refuse what the harness refuses, in a line that names variable and range."""

import ast
import json
import math
import re
import subprocess
import sys
import types

import pytest

from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.drop.case import Drop
from harness.cases.incline.system import TEMPLATE as INCLINE
from harness.cases.incline.system import Incline, scene_of, values_of
from harness.cases.tower.system import TEMPLATE as TOWER
from harness.engines.output import read_dump
from harness.engines.registry import engine_class
from harness.engines.scripts import SCENE_ALLOWED
from harness.errors import RequestError
from harness.parameters.law import Contact
from harness.parameters.tower import Tower

TEMPLATES = (INCLINE, TOWER, DROP)
DECLARED = {"incline": (Incline, Contact), "tower": (Tower, Contact), "drop": (Drop, Contact)}
PYTHON = ("yade", "kratos")


def beyond(one):
    """Return values just out of range, one a bound, and one that is not whole where it must be."""
    found = []
    for key, bound in one.bounds.items():
        away = 1 if one.whole else 1e-6 * max(1.0, abs(bound))
        if key.startswith("exclusive"):
            found.append(bound)
        else:
            found.append(bound - away if key == "minimum" else bound + away)
    return [*found, *([2.5] if one.whole else [])]


def beyond_each(allowed):
    """Return name and value of what some ranges refuse."""
    return [
        (name, value)
        for name, one in allowed.items()
        for value in (["sticky"] if one.words else beyond(one))
    ]


def allowed_in(engine, template):
    """Return what an engine's script of a template may be told."""
    return SCENE_ALLOWED if engine_class(engine).takes_scene(template) else template.allowed


def _script(engine, template):
    return engine_class(engine).script(template, template.main)


def refused_in(engine):
    """Return those of what the scripts of an engine declare."""
    return [
        (template, *one)
        for template in TEMPLATES
        for one in beyond_each(allowed_in(engine, template))
        if one[0] in _script(engine, template).variables
    ]


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda template: template.name)
def test_the_ranges_are_those_of_the_parameters(template):
    kinds, refused = DECLARED[template.name], beyond_each(template.allowed)
    for kind, name, value in ((k, *one) for k in kinds for one in refused):
        if name in kind.model_fields:
            others = {"restitution": 0.5} if kind is Contact else {}
            with pytest.raises(RequestError, match=f"^{name} = "):
                kind(**{**others, name: value})


def _lmp(lmp, folder, script, *words):
    (folder / script.name).write_text(script.text)
    command = [lmp, "-in", script.name, "-log", "none", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.live
@pytest.mark.parametrize(
    ("template", "name", "value"),
    [
        # one macro writes all checks: every third shows it, and each takes a start of LAMMPS
        pytest.param(*refused, marks=[] if number % 3 == 0 else pytest.mark.slow)
        for number, refused in enumerate(refused_in("lammps"))
    ],
)
def test_lammps_ends_with_variable_value_and_range(lmp, tmp_path, template, name, value):
    done = _lmp(lmp, tmp_path, _script("lammps", template), "-var", name, str(value))
    assert done.returncode == 1
    one = template.allowed[name]
    assert f"ERROR: {name} = {value}{one.unit and ' '}{one.unit}: {one.text}\n" in done.stdout
    assert "Setting up" not in done.stdout


@pytest.mark.live
@pytest.mark.parametrize("zeta", [0.0, 1.0, 5.0])
@pytest.mark.parametrize("away", [-1e-6, 1e-6])
def test_lammps_draws_the_line_of_the_step_where_the_harness_does(lmp, tmp_path, zeta, away):
    contact = Contact(damping_ratio=zeta)
    fewest = Incline(contact=contact, steps_per_contact=1000.0).fewest_steps_per_contact
    steps = fewest * (1.0 + away)
    values = {"damping": "ratio", "damping_ratio": zeta, "steps_per_contact": steps}
    words = [word for name, value in values.items() for word in ("-var", name, str(value))]
    done = _lmp(lmp, tmp_path, _script("lammps", INCLINE), *words, "-var", "time_limit", "1e-9")
    if away > 0:
        Incline(contact=contact, steps_per_contact=steps)
        assert "RESULT verdict = undecided" in done.stdout
    else:
        with pytest.raises(RequestError, match="steps_per_contact"):
            Incline(contact=contact, steps_per_contact=steps)
        assert f"ERROR: steps_per_contact = {steps}" in done.stdout


@pytest.mark.live
@pytest.mark.parametrize("template", TEMPLATES, ids=lambda template: template.name)
def test_one_variable_writes_a_dump_for_ovito_and_thermo_shows_the_motion(lmp, tmp_path, template):
    script = _script("lammps", template)
    done = _lmp(lmp, tmp_path, script, "-var", "dump", "all.dump")
    assert done.returncode == 0, done.stdout[-500:]
    text = (tmp_path / "all.dump").read_text()
    assert "ITEM: ATOMS id type x y z vx vy vz radius\n" in text
    table = read_dump(text, "LAMMPS")
    assert len(table["step"]) > 3
    assert (table["radius_m"] == 0.5).all()
    head = next(line.split() for line in done.stdout.splitlines() if "Step" in line.split())
    assert head[:2] == ["Step", "v_time"]
    assert len(head) >= 5
    plain = _lmp(lmp, tmp_path, script)
    with_dump, without = (re.findall("^RESULT.*", run.stdout, re.M) for run in (done, plain))
    assert with_dump == without


def _reader(script, *more):
    """Return the part of a Python script that reads its parameters, as it stands in it."""
    found = {"sys": sys, "math": math, "json": json}
    for node in ast.parse(script.text).body:
        target = node.targets[0] if isinstance(node, ast.Assign) else node
        if getattr(target, "id", getattr(target, "name", "")) in (
            "PARAMETERS",
            "ALLOWED",
            "value_of",
            *more,
        ):
            exec(ast.unparse(node), found)
    return found


@pytest.mark.parametrize("engine", PYTHON)
def test_scripts_in_python_say_the_same(engine):
    assert len(refused_in(engine)) > 20
    readers = {t.name: _reader(_script(engine, t)) for t, *_ in refused_in(engine)}
    for template, name, value in refused_in(engine):
        found, one = readers[template.name], allowed_in(engine, template)[name]
        whole = value == 2.5 and one.whole
        told = ": must be a whole number" if whole else f"{one.unit and ' '}{one.unit}: {one.text}"
        with pytest.raises(SystemExit) as ended:
            found["value_of"](name, str(value))
        assert ended.value.code == f"ERROR: {name} = {value}{told}"
        default = found["PARAMETERS"][name]
        assert found["value_of"](name, str(default)) == default
        with pytest.raises(SystemExit, match=r"^ERROR: angel: no such parameter; there are "):
            found["value_of"]("angel", "1")


@pytest.mark.parametrize("engine", PYTHON)
@pytest.mark.parametrize("mass", ["full", "half"])
@pytest.mark.parametrize("zeta", [0.0, 1.0, 5.0])
def test_scripts_of_scenes_draw_the_line_of_the_step_where_the_harness_does(engine, zeta, mass):
    kind = engine_class(engine)
    contact = Contact(damping_ratio=zeta, effective_mass=mass, tail="clipped")
    case = Incline(contact=contact, steps_per_contact=1000.0)
    values = kind.scene_values(scene_of(values_of(case, "passage")))
    script = _script(engine, INCLINE)
    watch = _reader(script, "Watch")["Watch"]
    longest = case.contact_time / case.fewest_steps_per_contact
    told = types.SimpleNamespace(results=[], add=lambda *_: None)
    watch(types.SimpleNamespace(**{**values, "step": longest * (1.0 - 1e-6)}), told)
    with pytest.raises(SystemExit, match=r"^ERROR: step = .* s: must be less than"):
        watch(types.SimpleNamespace(**{**values, "step": longest * (1.0 + 1e-6)}), told)
    # it is checked before there is a model: a code may wait for its workers for ever
    makes = {"yade": "O.reset()", "kratos": " Spheres(p)"}[engine]
    assert script.text.index("Watch(p") < script.text.index(makes)
