"""Runs of towers: version 1's values, timing, scripts and scenes, outputs that are refused."""

import math

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.tower import impulse as windows
from harness.cases.tower.case import CASE
from harness.cases.tower.parameters import Tower, TowerParameters
from harness.cases.tower.runs import chain_of, make_setup, read, run_in, solve, tower
from harness.engines.output import SERIES, Output, Provenance
from harness.engines.reference import Reference
from harness.errors import EngineOutputError, RequestError
from tests.cases.tower.standin import Standin

# of `run tower --engine rk4` in version 1
VERSION_1 = {
    "source-overlap": (
        1441.249719875804, 2.5245575759613597, 0.0019284152021029869, -1.9163705459109504,
    ),
    "grain-on-one": (
        2009.8340588767949, 4.030915249106918, 0.0015757012874589643, -1.9381694814805188,
    ),
}  # fmt: skip
NAMES = ("peak_force_N", "impulse_Ns", "turnaround_s", "final_velocity_m_per_s")


@pytest.mark.parametrize("preset", VERSION_1)
def test_a_run_has_the_values_of_version_1(preset):
    found = CASE.solve(CASE.presets[preset], "rk4")
    for name, value in zip(NAMES, VERSION_1[preset], strict=True):
        scale = CASE.quantity(name).size(CASE.presets[preset])
        assert found[name] == pytest.approx(value, abs=1e-9 * scale)


def test_quantities_of_a_run_at_equal_steps_and_without_a_step():
    parameters, bench = TowerParameters(law="deformable"), Bench(Standin())
    measured = CASE.measure(parameters, bench.output(CASE.job(parameters)))
    reference, exact = CASE.reference(parameters, bench), CASE.exact(parameters)
    for quantity in CASE.quantities:
        scale = quantity.size(parameters)
        assert measured[quantity.name] == pytest.approx(reference[quantity.name], abs=1e-9 * scale)
        assert measured[quantity.name] == pytest.approx(exact[quantity.name], abs=1e-5 * scale)
        assert abs(exact[quantity.name]) <= 3.0 * scale
    assert CASE.solve(parameters, "exact")["impulse_Ns"] == pytest.approx(exact["impulse_Ns"])


def test_a_run_is_as_long_as_the_window_of_its_impulse():
    sinking = TowerParameters(height=12, speed=9.81 / 300)
    assert CASE.job(sinking).values["duration"] > 3.0
    assert CASE.job(TowerParameters()).values["duration"] == 3.0
    late = TowerParameters(start="gapped", gap=1e-2)
    assert CASE.solve(late, "rk4")["impulse_Ns"] == pytest.approx(CASE.exact(late)["impulse_Ns"])


@pytest.mark.parametrize("start", ["touching", "preloaded", "gapped"])
def test_script_scene_and_chain_are_one_tower(start):
    case = Tower(height=3, law="overlap", start=start, gap=1e-3 * (start == "gapped"))
    setup = make_setup(case)
    scene, chain = setup.scene, chain_of(case)
    places = [body.position[0] - i for i, body in enumerate(scene.bodies)]
    assert places == pytest.approx(chain.displacement.tolist(), abs=1e-15)
    assert [body.motion for body in scene.bodies] == ["free"] * 3 + ["frozen"]
    runs = [run_in(Bench(engine), setup)[0] for engine in (Standin(), Reference())]
    assert runs[0].grain_force == pytest.approx(runs[1].grain_force, abs=1e-6)
    assert runs[0].energy == pytest.approx(runs[1].energy, abs=1e-9)


@pytest.mark.parametrize(
    ("steps", "law", "height", "bound"),
    [
        (3.0, "overlap", 4, "3.1416"),
        (10.0, "deformable", 9, "14.2"),
        (math.nan, "overlap", 1, "3.1"),
    ],
)
def test_unstable_steps_are_refused(steps, law, height, bound):
    with pytest.raises(RequestError, match=f"steps_per_contact.*{bound}"):
        make_setup(Tower(height=height, law=law), 3.0, steps)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"solver": "euler"}, "exact, rk4"),
        ({"solver": "exact", "steps_per_contact": 10.0}, "no step"),
        ({"solver": "rk4", "steps_per_contact": 0.5}, "finite and greater than"),
        ({"duration": 0.0}, "duration"),
        ({"duration": math.inf}, "duration"),
        ({"engine": Standin(), "solver": "rk4"}, "contradicts"),
        ({"engine": Standin()}, "one number each"),
    ],
)
def test_bad_requests(options, said):
    unequal = Tower(height=1, mass=(1.0, 2.0))
    with pytest.raises(RequestError, match=said):
        tower(unequal, **options)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"height": 0}, "height"),
        ({"mass": (1.0, 2.0, 3.0)}, "height . 1 = 2"),
        ({"start": "gapped"}, "gap"),
        ({"gap": 1e-3}, "gap"),
        ({"start": "preloaded", "base": "free"}, "rests on air"),
        ({"start": "preloaded", "stiffness": 10.0}, "at most 25 %"),
        ({"speed": -1.0}, "speed"),
    ],
)
def test_bad_parameters(values, said):
    with pytest.raises(RequestError, match=said):
        Tower(**values)


def test_an_output_of_other_parameters_is_refused():
    setup = make_setup(Tower(height=1, law="overlap"))
    good = Bench(Standin()).output(setup.job)
    results = (("mass_kg", "1.0000001"),)
    wrong = Output(results, Provenance("lammps", "1"), {SERIES: good.tables[SERIES]})
    assert read(setup, good).step == setup.step
    with pytest.raises(EngineOutputError, match="mass_kg"):
        read(setup, wrong)
    total = Output((("final_velocity_m_per_s", "1"),), Provenance("x", "1"), good.tables)
    with pytest.raises(EngineOutputError, match="its series"):
        read(setup, total)


def test_a_frame_has_units_and_the_rounding_of_contacts():
    run = solve(Tower(height=2, law="overlap"), "exact")
    frame = run.to_frame()
    assert [*frame][:5] == ["t_over_t0", "time_s", "grain_displacement_m",
                            "grain_velocity_m_per_s", "grain_force_N"]  # fmt: skip
    assert frame["contacts"].max() == 2
    assert (run.contacts_above(1e-3) <= run.contacts).all()
    assert run.deformations.max() == pytest.approx(run.forces.max() / 1e6, rel=0.5)


def test_the_film_draws_what_touches_as_touching():
    parameters = TowerParameters(law="deformable", height=3)
    output = Bench(Standin()).output(CASE.film_job(parameters, 60))
    discs = CASE.discs(parameters, output)
    gaps = np.diff(discs.x, axis=1) - discs.radius[:, 1:] - discs.radius[:, :-1]
    pressed = discs.value.max(axis=1) > 1.0
    assert pressed.any()
    assert np.abs(gaps[pressed].min(axis=1)).max() < 1e-6
    assert discs.time[-1] == pytest.approx(3.0 * parameters.contact_time)
    assert gaps.min() > -1e-6
    assert discs.radius.min() > 0.0


def test_summary_has_the_keys_of_version_1():
    record = windows.summary(solve(Tower(), "rk4"))
    assert [*record] == [
        "law", "solver", "height", "stiffness_N_per_m", "mass_kg", "speed_m_per_s",
        "gravity_m_per_s2", "base", "step_s", "duration_s", "window", "window_s", "impulse_Ns",
        "peak_force_N", "contact_time_s", "turnaround_s", "energy_drift", "contacts",
        "final_velocity_m_per_s",
    ]  # fmt: skip
    assert record["contacts"][0] == [0.0, 1]
