"""Runs of towers: version 1's values, timing, scripts and scenes, outputs that are refused."""

import math

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.tower import impulse as windows
from harness.cases.tower.case import CASE
from harness.cases.tower.parameters import Tower, TowerParameters
from harness.cases.tower.runs import (
    chain_of,
    first_divergence,
    make_setup,
    read,
    run_in,
    solve,
    tower,
)
from harness.engines.output import SERIES
from harness.engines.reference import Reference
from harness.errors import EngineOutputError
from harness.results.rows import Failure
from tests.cases.common import assert_refused, made
from tests.cases.tower.standin import Standin

NAMES = (
    "peak_force_N", "impulse_Ns", "turnaround_s", "final_velocity_m_per_s", "energy_drift",
)  # fmt: skip
RK4 = {  # of `run tower --engine rk4` in version 1, by preset
    "source-overlap": (
        1441.249719875804, 2.5245575759613597, 0.0019284152021029869, -1.9163705459109504,
    ),
    "grain-on-one": (
        2009.8340588767949, 4.030915249106918, 0.0015757012874589643, -1.9381694814805188,
    ),
}  # fmt: skip
LAMMPS = {  # of `run tower --engine lammps`, by law
    "overlap": (
        1441.2523106108347, 2.524557595481276, 0.0019284148532298516, -1.916371905683487,
        2.413923522508694e-06,
    ),
    "deformable": (
        1814.3387388649762, 3.8186737270816655, 0.0036149475445609617, -1.725927949301745,
        4.1795442387794695e-06,
    ),
}  # fmt: skip


def assert_values(found, values, parameters):
    for name, value in zip(NAMES, values, strict=False):
        scale = CASE.quantity(name).size(parameters)
        assert found[name] == pytest.approx(value, abs=1e-9 * scale)


@pytest.mark.parametrize("preset", RK4)
def test_a_run_has_the_values_of_version_1(preset):
    assert_values(CASE.solve(CASE.presets[preset], "rk4"), RK4[preset], CASE.presets[preset])


@pytest.mark.live
@pytest.mark.parametrize("law", LAMMPS)
def test_a_run_of_lammps_has_the_values_of_version_1(lammps, law):
    parameters = TowerParameters(law=law)
    measured = CASE.measure(parameters, Bench(lammps).output(CASE.job(parameters)))
    assert make_setup(parameters).steps == 3010
    assert_values(measured, LAMMPS[law], parameters)


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


def in_steps(steps, law, height):
    return make_setup(Tower(height=height, law=law), 3.0, steps)


def unequal(**options):
    return tower(Tower(height=1, mass=(1.0, 2.0)), **options)


REFUSED = [
    (in_steps, {"steps": 3.0, "law": "overlap", "height": 4}, "steps_per_contact.*3.1416"),
    (in_steps, {"steps": 10.0, "law": "deformable", "height": 9}, "steps_per_contact.*14.2"),
    (in_steps, {"steps": math.nan, "law": "overlap", "height": 1}, "steps_per_contact.*3.1"),
    (unequal, {"solver": "euler"}, "exact, rk4"),
    (unequal, {"solver": "exact", "steps_per_contact": 10.0}, "no step"),
    (unequal, {"solver": "rk4", "steps_per_contact": 0.5}, "finite and greater than"),
    (unequal, {"duration": 0.0}, "duration"),
    (unequal, {"duration": math.inf}, "duration"),
    (unequal, {"engine": Standin(), "solver": "rk4"}, "contradicts"),
    (unequal, {"engine": Standin()}, "one number each"),
    (Tower, {"height": 0}, "height"),
    (Tower, {"mass": (1.0, 2.0, 3.0)}, "height . 1 = 2"),
    (Tower, {"start": "gapped"}, "gap"),
    (Tower, {"gap": 1e-3}, "gap"),
    (Tower, {"start": "preloaded", "base": "free"}, "rests on air"),
    (Tower, {"start": "preloaded", "stiffness": 10.0}, "at most 25 %"),
    (Tower, {"speed": -1.0}, "speed"),
    (Tower, {"speed": 1e200}, r"speed = 1e\+200: must be from 0 to 1e30"),
    (Tower, {"gravity": 1e200}, r"gravity = 1e\+200: must be from 0 to 1e30"),
    (CASE.job, {"parameters": TowerParameters(duration=1e200)}, "duration = .* 2e9 steps"),
]


@pytest.mark.parametrize(("function", "values", "words"), REFUSED)
def test_what_makes_no_run_is_refused_in_one_line(function, values, words):
    assert_refused(words, function, **values)


def test_an_output_of_other_parameters_is_refused():
    setup = make_setup(Tower(height=1, law="overlap"))
    good = Bench(Standin()).output(setup.job)
    assert read(setup, good).step == setup.step
    for name, value, words in (
        ("mass_kg", 1.0000001, "mass_kg"), ("final_velocity_m_per_s", 1, "its series")
    ):  # fmt: skip
        with pytest.raises(EngineOutputError, match=words):
            read(setup, made({name: value}, good.tables[SERIES]))


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


# ---- divergence

TIME = np.linspace(0.0, 10.0, 1001)


def divergence(difference, time=TIME):
    zero = np.zeros_like(TIME)
    return first_divergence(time, {"x": difference, "v": zero}, TIME, {"x": zero, "v": zero}, 0.5)


@pytest.mark.parametrize("value", [0.6, -1.0, np.nan])
@pytest.mark.parametrize("first", [0, 1, 2, 500])
def test_the_first_sample_outside_the_band_and_the_class(first, value):
    failure, note = divergence(np.where(np.arange(TIME.size) >= first, value, 0.5))
    assert failure is (Failure.FROM_FIRST_STEP if first <= 1 else Failure.LATE)
    assert note == f"{failure}: x at {TIME[first]:.6g} s, by up to {abs(value):.3g}"


def test_a_series_within_the_band_does_not_diverge_and_other_times_are_refused():
    assert divergence(np.full_like(TIME, 0.5)) == (Failure.NONE, "")
    for time in (TIME[:-1], TIME + 1e-3):
        with pytest.raises(ValueError, match="samples at other times than 1001 expected"):
            divergence(TIME, time)
