"""Layers on an incline: what is allowed, what is read, the single grain, undecided descents."""

import math
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from harness.cases.layers.case import CASE, FLOWING
from harness.cases.layers.system import SINGLE, TEMPLATE, Layers, values_of
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, read_dump
from harness.errors import (
    EngineLostAtomsError,
    EngineOutputError,
    EngineUndecidedError,
    RequestError,
)
from harness.observables.provenance import Provenance
from harness.workflows.sweep_plan import (
    SweepRequest,
    names_in,
    parameter_columns,
    plan,
    request_in,
)

COLUMNS = [
    *("contact.restitution", "contact.damping_ratio", "contact.tail", "layers", "length_d"),
    *("width_d", "filled_d", "base", "roughness_d", "polydispersity", "seed"),
    *("stiffness_over_weight", "steps_per_contact", "first_angle_deg", "lowest_angle_deg"),
    *("flow_time", "rate_deg", "rise_deg", "arrest_speed", "arrest_ratio", "time_limit"),
]

TINY = Layers(
    layers=1, length=6, width=3, stiffness_over_weight=100.0, rate=1.0, flow_time=10.0, rise=0.2
)

WRONG = [
    ({"layers": 8, "length": 7}, "length = 7 d: is too small for 8 layers; must be at least 8"),
    ({"layers": 9, "width": 4}, "width = 4 d: must be 1, or at least 3 and half the 9 layers"),
    ({"roughness": 0.8}, "roughness = 0.8 d: grains fall through the base; must be less than"),
    ({"stiffness_over_weight": 79.0}, "is too soft; must be at least 80 for 4 layers"),
    ({"steps_per_contact": 12.0}, "steps_per_contact = 12: must be at least 12.1"),
]


@pytest.mark.parametrize(("changes", "words"), WRONG)
def test_what_cannot_hold_grains_or_be_integrated_is_refused(changes, words):
    with pytest.raises(RequestError) as told:
        Layers(**changes)
    assert words in str(told.value)


def test_only_a_contact_without_attraction_is_offered():
    with pytest.raises(RequestError, match="must have the clipped tail"):
        Layers(contact="source")
    assert Layers(contact={"restitution": 0.5}).contact.tail == "clipped"
    with pytest.raises(RequestError, match="lowest_angle = 30"):
        Layers(lowest_angle=30.0)
    with pytest.raises(RequestError, match="filled = 17 d: must be at most"):
        Layers(filled=17)


def test_the_line_of_the_step_is_that_of_the_bound():
    """(frequency step)^2 / 4 + rate step / 2 = 1 at the fewest steps per contact."""
    for zeta in (0.0, 0.6, 5.0):
        case = Layers(contact={"damping_ratio": zeta}, steps_per_contact=1e3)
        step = math.pi / case.fewest_steps_per_contact  # in sqrt(m/k)
        assert 8 * step**2 / 4 + 8 * math.sqrt(2) * zeta * step / 2 == pytest.approx(1.0)


def output(**results):
    told = tuple((name, str(value)) for name, value in results.items())
    return Output(told, Provenance("fake", "1"))


@pytest.mark.parametrize(
    ("results", "error", "words"),
    [
        ({"verdict": "never_started"}, EngineOutputError, "undecided: the flow never started"),
        ({"verdict": "never_stopped", "last_angle_deg": 0.9}, EngineOutputError,
         "undecided: the flow never stopped above lowest_angle = 1 deg"),
        ({"verdict": "never_stopped", "last_angle_deg": 7.0}, EngineOutputError,
         "undecided: the flow never stopped within time_limit = 5000; it was at 7 deg"),
        ({"verdict": "fell_through"}, EngineLostAtomsError, "fell through the base"),
        ({"verdict": "stopped", "stop_angle_deg": 7.0}, EngineOutputError, "incomplete"),
        ({"verdict": "else"}, EngineOutputError, "unknown verdict"),
    ],
)  # fmt: skip
def test_a_descent_without_an_angle_of_stop_has_none(results, error, words):
    with pytest.raises(error, match=words):
        CASE.read(Layers(), output(**results), Lammps.traits)


def test_an_undecided_descent_keeps_its_flow():
    flow = {"mean_speed": 0.25, "kinetic_over_elastic": 3.0, "coordination": 4.0, "steps": 100}
    left = output(verdict="never_stopped", last_angle_deg=0.9, **flow)
    with pytest.raises(EngineUndecidedError) as caught:
        CASE.measured(Layers(), left, Lammps.traits)
    assert dict(caught.value.values) == flow
    assert caught.value.provenance is left.provenance


def test_a_corner_that_is_too_soft_is_a_row_of_a_sweep():
    stiff = {"layers": "1,8", "stiffness_over_weight": "100,1000"}
    chosen = plan(SweepRequest("layers", (stiff,), {"width": "4"}))
    assert [one.swept for one in chosen.points] == [
        {"layers": "1", "stiffness_over_weight": "100"},
        {"layers": "1", "stiffness_over_weight": "1000"},
        {"layers": "8", "stiffness_over_weight": "1000"},
    ]
    ((place, refused),) = chosen.refused.items()
    assert place == 2
    assert "too soft; must be at least 160 for 8 layers" in refused.reason


def test_the_committed_sweep_runs_the_descents_of_the_report():
    root = Path(__file__).parents[3]
    chosen = plan(request_in(root / "inputs" / "sweeps" / "layers.toml"))
    rows = [parameter_columns(point.parameters, ["contact"]) for point in chosen.points]
    planned = {tuple(row[name] or 0.0 for name in COLUMNS) for row in rows}
    runs = pd.read_csv(root / "reports" / "layers" / "runs.csv")
    made = set(runs[COLUMNS].fillna(0.0).itertuples(index=False, name=None))
    assert (len(planned), chosen.runs) == (263, 263)
    assert planned == made
    selected = {quantity.name for quantity in chosen.case.quantities}
    assert set(names_in(chosen.request.quantity)) <= selected
    assert 5.0 < chosen.seconds() / 3600.0 < 30.0  # 12.5 hours as measured


@pytest.fixture(scope="module")
def engine(lammps_here):  # noqa: ARG001
    with Lammps(workers=1) as opened:
        yield opened


@pytest.mark.live
def test_the_single_grain_stops_at_the_critical_angle_of_the_incline(engine):
    found = CASE.verification.run(engine, Study("quick"))
    (check,) = found.checks
    assert check.verdict is Verdict.PASS, check
    assert check.expected == pytest.approx(10.2078, abs=1e-4)
    (section,) = CASE.display.sections(found, found, {})
    (drawing,) = section.drawings
    assert len(drawing.draw().axes) == 2
    who, profile = found.evidence
    assert who == engine.title
    assert np.all(np.diff(profile.height) > 0)
    # a slice that holds a grain now and then has the speed of its grains: the surface is fastest
    assert profile.speed[0] < profile.speed[-3] < 1.5 * profile.speed[-1]
    # between a loose flow and close packing
    assert 0.4 < profile.middle_fraction < 0.74


@pytest.mark.live
def test_all_quantities_are_measured_and_the_start_is_above_the_stop(engine):
    found = CASE.measure(TINY, engine).values
    assert set(found) == {one.name for one in CASE.quantities}
    assert found["start_angle_deg"] > found["stop_angle_deg"]
    assert found["stop_angle_by_speed_deg"] == pytest.approx(found["stop_angle_deg"], abs=0.1)
    # a grain at rest without friction touches three others, but for one that rattles
    assert 2.5 < found["rest_coordination"] < 6.0


@pytest.mark.live
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"first_angle": 3.0, "flow_time": 60.0}, "the flow never started"),
        ({"first_angle": 25.0, "lowest_angle": 24.9}, "the flow never stopped above"),
        ({"time_limit": 0.5}, "the flow never stopped within time_limit = 0.5"),
    ],
)
def test_an_undecided_descent_is_no_angle(engine, changes, words):
    with pytest.raises(EngineOutputError, match=words):
        CASE.measure(TINY.replace(**changes), engine)


def lmp_run(words, folder, values):
    script = Lammps.script(TEMPLATE)
    (folder / script.name).write_text(script.text)
    told = [word for name, value in values.items() for word in ("-var", name, str(value))]
    command = [*words, "-in", script.name, "-log", "none", *told]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.live
def test_the_system_is_the_same_on_any_number_of_ranks(lmp, mpirun, tmp_path):
    short = TINY.replace(layers=2, flow_time=2.0, time_limit=0.1)
    frames = []
    for words in ([lmp], [mpirun, "-np", "2", lmp]):
        values = {**values_of(short), "dump": f"{len(frames)}.dump"}
        done = lmp_run(words, tmp_path, values)
        assert "RESULT verdict = never_stopped" in done.stdout, done.stdout[-500:]
        table = read_dump((tmp_path / values["dump"]).read_text(), "LAMMPS")
        places = np.column_stack([table[name][0] for name in ("type", "x_m", "y_m", "z_m")])
        frames.append(places[np.lexsort(places.T)])
    assert frames[0].shape == (short.grains + short.base_spheres, 4)
    assert np.array_equal(*frames)


@pytest.mark.live
@pytest.mark.parametrize(("changes", "words"), WRONG)
def test_the_script_refuses_what_the_harness_refuses(lmp, tmp_path, changes, words):  # noqa: ARG001
    done = lmp_run([lmp], tmp_path, {**values_of(Layers()), **changes})
    (name,) = [name for name in changes if name != "layers"]
    assert done.returncode == 1
    assert f"ERROR: {name} = " in done.stdout
    assert "Setting up" not in done.stdout


def test_the_cost_grows_with_the_grains_and_the_root_of_the_stiffness():
    seconds = CASE.seconds(Layers(), Lammps.traits)
    assert CASE.seconds(Layers(stiffness_over_weight=4e3), Lammps.traits) == 2 * seconds
    # a flow over a longer box is lowered over more displacement, too, and ends at a limit of time
    assert 1.5 * seconds < CASE.seconds(Layers(length=32), Lammps.traits) < 4.0 * seconds
    assert FLOWING.grains + FLOWING.base_spheres == 160
    assert SINGLE.grains == 1
