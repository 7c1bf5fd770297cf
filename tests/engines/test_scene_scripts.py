"""Codes with one script of scenes: what it says, what is read of it, what is damaged is named."""

import ast
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases.drop import case as drops
from harness.cases.drop.case import Drop
from harness.cases.incline import runs as inclines
from harness.cases.incline import system
from harness.cases.incline.system import Incline, Motion, margin
from harness.cases.tower import run as towers
from harness.cases.tower import system as tower_system
from harness.cases.tower.system import timing_of
from harness.engines.contract import Job, Template, finished
from harness.engines.output import Output, read_csv, results_in
from harness.engines.programs import with_stages
from harness.engines.reference import Reference
from harness.engines.registry import engine_class
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.parameters.law import CLIPPED, PLASTIC, Contact
from harness.parameters.plane_scene import LOOK
from harness.parameters.tower import Tower
from tests.engines.tower_runs import force_difference

HERE = Path(__file__).parent
CODES = ("liggghts", "yade", "kratos")
PYTHON = CODES[1:]
TEMPLATES = (system.TEMPLATE, drops.TEMPLATE, tower_system.TEMPLATE)
TOWER = Tower(height=2, law="overlap", stiffness=1e5)
HALF = Contact(name="e = 0.5", restitution=0.5, damping_ratio=None, tail="clipped")
RECORDED = {
    "yade": (
        Incline(angle=10.5, contact=PLASTIC, stiffness=1e5),
        200,
        Drop(contact=HALF, speed=1.0, steps_per_contact=100.0, duration=2.0, every=20),
        timing_of(TOWER, 1.0, 100.0, 20),
    ),
    "kratos": (
        Incline(contact=PLASTIC, angle=10.3, stiffness=1e5, steps_per_contact=50.0),
        50,
        Drop(contact=PLASTIC, steps_per_contact=200.0, gap=1e-3, speed=1.0, duration=2.0, every=20),
        timing_of(TOWER, 3.0, 100.0, 60),
    ),
}
"""What was recorded: the passage of an incline, steps between its samples, a drop, a tower."""

OWN = {"kratos": ("scheme", "search_every", "search_tolerance", "search_tolerance_against_walls")}
"""What scripts are told besides a scene."""

ALL = pytest.mark.parametrize("code", CODES)
READ = pytest.mark.parametrize("code", PYTHON)


def engine_of(code):
    """Return an engine that renders and refuses without its code."""
    kind = engine_class(code)
    engine = kind() if code == "kratos" else kind.__new__(kind)
    engine.program = f"/usr/bin/{code}"
    return engine


def scene(template):
    values = {"series_every": LOOK, **template.variants[template.main]}
    return template.scene(values)


def parameters(script):
    """Return PARAMETERS of a script, read without its code."""
    for node in ast.parse(script.text).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "PARAMETERS":
            return ast.literal_eval(node.value)
    return None


# ---- scripts -----------------------------------------------------------------------------------


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda template: template.name)
@ALL
def test_a_script_declares_the_data_of_a_scene_and_uses_them(code, template):
    kind = engine_class(code)
    script = kind.script(template)
    stated = kind.scene_values(scene(template))
    own = {"tail"} - script.variables  # of contacts that always clip there is no tail to set
    more = {"series", "results", *OWN.get(code, ())}
    assert script.variables | more == {*stated, *more} - own
    assert "import harness" not in script.text
    assert "from harness" not in script.text
    assert not finished(script.text)
    if code in PYTHON:
        has = parameters(script)
        assert all(has[name] == stated[name] for name in has.keys() & stated.keys())
        assert set(has) <= set(re.findall(r"\.(\w+)", script.text))
        assert set(re.findall(r"\bp\.(\w+)", script.text)) <= set(has)


@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED, PLASTIC.replace(effective_mass="half")])
@ALL
def test_a_job_sets_all_data_to_the_last_digit(code, contact):
    engine = engine_of(code)
    case = Incline(contact=contact, phase=0.1 + 0.2, steps_per_contact=100.0)
    drop = Drop(contact=contact, stiffness=1e6 / 3.0, gap=0.1 + 0.2, density=1.1, speed=1.0)
    for job in (
        system.job_of(case, "passage", 7),
        drops.job_of(drop),
        tower_system.job_of(TOWER, timing_of(TOWER, 1.0, None, None)),
    ):
        assert engine.refuses(job) == ""
        task = engine.task(job)
        left = task.script.variables - set(task.values) - {"series", "results"}
        assert left <= set(OWN.get(code, ()))
        own = engine.scene_values(job.template.scene(job.values))
        assert all(task.values[n] == v for n, v in own.items() if n in task.values)
        line = engine.command_line(task)
        assert all(engine.literal(v) in line for v in (own["step"], own["mass"], *own["vx"]))
        if code in PYTHON:
            has = parameters(task.script)
            assert all(type(has[name]) is type(value) for name, value in task.values.items())
    values = engine.scene_values(system.scene_of(system.values_of(case, "passage")))
    eta = case.settings()["damping_coefficient_N_s_per_m"]
    assert values["damping"] == pytest.approx(eta, rel=1e-14)
    assert engine.task(system.job_of(case, "passage", 7)).values["every"] == 7
    assert engine.task(system.job_of(case, "steady")).values["every"] == 0


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"law": "deformable"}, "takes law = overlap, not deformable"),
        ({"angle": 1.0}, r"template 'tower' has no value 'angle' \(angle = 1\.0\)"),
        ({"rolling": 0.1}, r"template 'tower' has no value 'rolling' \(rolling = 0\.1\)"),
    ],
)
@ALL
def test_what_a_script_cannot_state_is_refused(code, values, reason):
    job = tower_system.job_of(TOWER, timing_of(TOWER, 1.0, None, None))
    engine = engine_of(code)
    assert engine.refuses(job) == ""
    assert re.search(reason, engine.refuses(Job(job.template, {**job.values, **values})))
    assert engine.refuses(Job(Template("hopper", {"": {}}), {})) == "it has no template 'hopper'"


# ---- what they leave ---------------------------------------------------------------------------


@pytest.fixture
def recorded():
    """Return a function that reads an output of a code by name, log or series damaged or not."""

    def read(code, name, series=str, text=str):
        folder, title = HERE / code / "recorded", engine_class(code).traits.title
        log = text((folder / f"{name}.txt").read_text("utf-8"))
        path, tables = folder / f"{name}.csv", {}
        if path.is_file():
            tables["series"] = read_csv(series(path.read_text("utf-8")), title)
        return with_stages(Output(results_in(log), Provenance(code, "1"), tables, log))

    return read


def reference_of(code):
    return Reference(engine_class(code).traits.integrator)


@READ
def test_a_drop_goes_where_the_reference_goes(recorded, code):
    _, _, case, _ = RECORDED[code]
    run = drops.read(case, recorded(code, "drop"))
    (expected,) = drops.run_drops(reference_of(code), [case])
    # a rounding of the position, eps of a metre, is k eps of force; over the time, of velocity
    seconds = case.duration * case.contact_time
    rounding = 2.0 * np.finfo(float).eps * case.stiffness / case.mass * seconds
    # of spheres that touch at the start a code may feel the dashpot a step earlier
    eta = 2.0 * case.contact.zeta * np.sqrt(case.stiffness * case.mass)
    early = 0.0 if case.gap else eta * case.speed * case.step / case.mass
    for name, values in vars(expected.path).items():
        width = rounding + early * (1.0 if name.startswith("v") else seconds)
        np.testing.assert_allclose(getattr(run.path, name), values, rtol=0, atol=width)


@READ
def test_an_incline_is_judged_by_its_stages_as_the_reference_is(recorded, code):
    case, every, _, _ = RECORDED[code]
    output = recorded(code, "incline")
    run = inclines.read(case, "passage", output, every)
    (expected,) = inclines.run_inclines(reference_of(code), [case], "passage", every=every)
    assert (run.motion, run.steps, run.touching) == (Motion.MOVES_ON, expected.steps, True)
    assert run.steps == int(output.text("steps"))
    assert run.margin_J == pytest.approx(expected.margin_J, abs=1e-11)
    assert run.crests.margin_J.tolist() == [run.margin_J]
    assert run.provenance is output.provenance
    path = run.trajectory
    for name, values in vars(expected.trajectory).items():
        np.testing.assert_allclose(getattr(path, name), values[: path.x_m.size], atol=1e-11)
    if path.time_s[-1] == run.time_s:
        last = (path.x_m[-1], path.y_m[-1], path.vx_m_per_s[-1], path.vy_m_per_s[-1])
        assert run.margin_J == pytest.approx(margin(case, 1, *last), rel=1e-12)


@READ
def test_a_tower_is_read_with_the_forces_of_its_contacts(recorded, code):
    *_, timing = RECORDED[code]
    output, traits = recorded(code, "tower"), engine_class(code).traits
    run = towers.read(TOWER, timing, output, traits, profiles=True)
    assert output.number("steps") == timing.steps
    assert output.number("step_s") == pytest.approx(timing.step, rel=1e-14)
    assert run.time[-1] == pytest.approx(timing.duration * TOWER.contact_time, rel=1e-12)
    assert run.grain_velocity[0] == pytest.approx(2.0, abs=1e-12)
    assert set(run.contacts) <= {0.0, 1.0, 2.0}
    assert run.contacts.max() == 2.0
    # the overlap law: the force of each contact is k times its overlap
    overlap = np.maximum(-np.diff(run.profiles.displacements, axis=1), 0.0)
    most = run.grain_force.max()
    np.testing.assert_allclose(run.profiles.forces, 1e5 * overlap, rtol=1e-12, atol=1e-9 * most)
    # the energy swings with the square of the step, (omega_max h)^2 / 4 in a leapfrog
    assert np.abs(run.energy / run.energy[0] - 1.0).max() < (TOWER.omega * timing.step) ** 2
    # of second order in the step
    assert force_difference(run) < (np.pi * TOWER.omega * timing.step) ** 2


def test_the_rounding_of_places_is_no_contact(recorded, monkeypatch):
    """Forces of two roundings of a place count as none; one contact that presses is still there."""
    # spheres that rest in spite of gravity: these samples are not to be held against each other
    monkeypatch.setattr(towers, "FEWEST", 100)
    timing, traits = RECORDED["yade"][3], engine_class("yade").traits
    tiny = 1e5 * 2.0 * float(np.finfo(float).eps)

    def rounded(series, last):
        head, *rows = series.splitlines()
        times = [row.partition(",")[0] for row in rows]
        rows = [f"{time},0,1,2,0,0,0,{tiny!r},{tiny!r}" for time in times]
        rows[-1] = f"{times[-1]},0,1,2,0,0,0,{last}"
        return "\n".join([head, *rows]) + "\n"

    one, none = (
        recorded("yade", "tower", lambda text, last=last: rounded(text, last), lambda _: "")
        for last in ("9,0", "0,0")
    )
    run = towers.read(TOWER, timing, one, traits)
    assert run.contacts.tolist() == [0.0] * (len(run.time) - 1) + [1.0]
    with pytest.raises(EngineOutputError, match="no contact of the tower ever presses"):
        towers.read(TOWER, timing, none, traits)


@READ
def test_a_stage_that_is_missing_leaves_the_run_undecided(recorded, code):
    output, case = recorded(code, "incline"), RECORDED[code][0]
    stages = {name: column[:1] for name, column in output.tables["stages"].items()}
    with pytest.raises(EngineOutputError, match="undecided, before the time limit"):
        inclines.read(case, "passage", replace(output, tables={"stages": stages}))


def _with_columns(text):
    head, *rows = text.splitlines()
    return "\n".join([head, *(row + ",1,1" for row in rows)]) + "\n"


def _without_column(text):
    return "\n".join(row.rpartition(",")[0] for row in text.splitlines()) + "\n"


@pytest.mark.parametrize(
    ("damage", "error", "words"),
    [
        (lambda _: "", EngineOutputError, "without rows"),
        (lambda text: text[:1], EngineOutputError, "series"),
        (lambda text: text[:40], EngineOutputError, "series"),
        (lambda text: text.splitlines()[0] + "\n", EngineOutputError, "without rows"),
        (lambda text: text[:-1], EngineOutputError, "cut in its last row"),
        (lambda text: text[:-20], EngineOutputError, "cut in its last row"),
        (lambda text: "\n".join(text.splitlines()[:-3]) + "\n", EngineOutputError, "left .* rows"),
        (lambda text: text + "9,0,1\n", EngineOutputError, "incomplete series"),
        (_with_columns, EngineOutputError, "columns under|incomplete"),
        (lambda text: text.replace(",0,", ",nothing,"), EngineOutputError, "incomplete series"),
        (lambda text: text.replace(",0,", ",nan,"), EngineNaNError, "not numbers"),
        (lambda text: text.replace(",0,", ",inf,"), EngineNaNError, "not numbers"),
        (_without_column, EngineOutputError, "no table with|left \\w+ of [12]|no \\w+"),
    ],
)
def test_a_damaged_series_is_named(recorded, damage, error, words):
    *_, case, timing = RECORDED["yade"]
    with pytest.raises(error, match=words):
        drops.read(case, recorded("yade", "drop", damage))
    with pytest.raises(error, match=words):
        towers.read(TOWER, timing, recorded("yade", "tower", damage), engine_class("yade").traits)


@pytest.mark.parametrize(
    ("row", "error"),
    [
        ("1,2,3,nan,5", EngineNaNError),
        ("1,2,3,4", EngineOutputError),
        ("-1,2,3,4,5", EngineOutputError),
    ],
)
def test_a_wrong_row_of_a_passage_is_named(recorded, row, error):
    series = f"time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n0,1,1,1,1\n{row}\n"

    def read():
        output = recorded("yade", "incline", lambda _: series)
        inclines.read(RECORDED["yade"][0], "passage", output, 1)

    with pytest.raises(error):
        read()
