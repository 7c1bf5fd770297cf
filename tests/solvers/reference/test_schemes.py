"""Schemes against recorded runs of MFiX, their orders; stages that end a run; runs in pieces."""

import math
from pathlib import Path

import numpy as np
import pytest

from harness.errors import EngineNaNError
from harness.model.conventions import Rules
from harness.model.law import Law, damping_ratio
from harness.model.scene import LOOK, Body, Scene, Stage, Wall
from harness.solvers import reference
from tests.solvers.reference.scenes import DAMPED, HOOKE, MASS, G, R, climbing, impact, on_row

RECORDED = Path(__file__).parent / "recorded"
MFIX = Rules(scheme="mfix_euler", frozen_mass="own", least_overlap=1e-15)


def recorded(name):
    return np.genfromtxt(RECORDED / name, delimiter=",", names=True)


def step_of(stiffness, ratio, factor):
    """Return MFiX's step [s]: contact time by m/2 over a factor."""
    omega = math.sqrt(stiffness / 0.5)
    return math.pi / (omega * math.sqrt(1.0 - ratio**2)) / factor


def row_of_mfix(stiffness, factor, angle, **more):
    """Return a grain on a row at an angle [deg], with the contact and the step of the source."""
    ratio = damping_ratio(1e-20)
    step = step_of(stiffness, ratio, factor)
    return on_row(stiffness, angle=angle, ratio=ratio, clipped=False, step=step, **more)


@pytest.mark.parametrize(
    ("name", "factor"),
    [("incline_k1e6_euler_f50_th10.20.csv", 50), ("quartier_k1e6_euler_f500_th10.20.csv", 500)],
)
def test_recorded_incline(name, factor):
    """To half of the last of six digits, over four wells and six seconds, and over one well."""
    table, every = recorded(name), 20 * factor // 50
    motion = reference.run(
        row_of_mfix(1e6, factor, 10.20, steps=(len(table) - 1) * every, every=every), MFIX
    )
    assert motion.time == pytest.approx(table["t_s"], rel=1e-5)
    assert motion.position[:, 0, 0] + 0.5 == pytest.approx(table["x_m"], abs=5e-6)
    assert motion.position[:, 0, 1] == pytest.approx(table["y_m"], abs=5e-7)
    assert motion.velocity[:, 0, 0] == pytest.approx(table["vx_m_s"], abs=5e-6)


def lasts(stiffness, factor, angle, wells):
    """Return whether a grain passes so many crests of a row at an angle [deg]."""
    tilt, crest = math.radians(angle), 1.0 - G / stiffness
    scene = row_of_mfix(stiffness, factor, angle)
    stages = tuple(
        # a grain that turns back below the energy at rest on the crest ahead never passes it
        Stage(place=k - crest * math.sin(tilt), floor=G * (crest - k * math.sin(tilt)))
        for k in range(1, wells + 1)
    )
    steps = math.ceil(32.0 * wells / scene.step)
    motion = reference.run(scene.replace(stages=stages, steps=steps, every=steps), MFIX)
    return len(motion.stages) == wells + 1 and motion.stages[-1, 2] > stages[-1].place


# at 4.8 steps of a contact fates depend on its phase, and on how long one waits
JITTERED = ((1e5, 50), (1e6, 50))


def steady_rows():
    for row in recorded("critical_angles_euler.csv"):
        case = row["stiffness_N_per_m"], row["dtsolid_factor"]
        if case not in JITTERED:
            yield pytest.param(row, marks=[pytest.mark.slow] if case[1] > 500 else [])


@pytest.mark.parametrize("row", [*steady_rows()])
def test_recorded_critical_angle(row):
    stiffness, factor, angle, _ = row.tolist()
    assert not lasts(stiffness, factor, angle - 3e-3, 20)
    assert lasts(stiffness, factor, angle + 3e-3, 20)


def test_recorded_drop_by_adams_and_bashforth():
    """In single precision: e = 0.5 by m/2, 100 steps of a contact, a held sphere."""
    table = recorded("drop_adams_bashforth.csv")
    grain = Body(radius=0.5, mass=1.0, position=(0.0, 1.0, 0.0), velocity=(0.0, -1.0, 0.0))
    scene = Scene(bodies=(grain, Body(radius=0.5, mass=1.0, motion="held")), every=4,
                  law=Law.linear(1e6, damping_ratio(0.5), clipped=False),
                  step=math.pi * 1e-3 / 100, steps=4 * (len(table) - 1))  # fmt: skip
    offs = {}
    for scheme in ("mfix_adams_bashforth", "mfix_euler"):
        motion = reference.run(scene, Rules(scheme=scheme, least_overlap=1e-15))
        assert motion.time == pytest.approx(table["t_s"], rel=1e-7, abs=1e-12)
        assert motion.position[:, 0, 1] == pytest.approx(table["y_m"], abs=2e-3)
        offs[scheme] = np.abs(motion.velocity[:, 0, 1] - table["vy_m_s"]).max()
    assert offs["mfix_adams_bashforth"] < 1e-7
    assert offs["mfix_euler"] > 1e-3


@pytest.mark.parametrize(("factor", "every"), [(50, 1), (5000, 100)])
@pytest.mark.parametrize("height", [2, 3, 5, 10])
def test_recorded_tower(height, factor, every):
    table = recorded(f"tower_k1e5_euler_f{factor}.csv")
    row = [Body(radius=0.5, mass=1.0, position=(float(k), 0.0, 0.0)) for k in range(height)]
    first, *others, last = row
    bodies = (first.replace(velocity=(2.0, 0.0, 0.0)), *others, last.replace(motion="frozen"))
    scene = Scene(
        bodies=bodies, law=HOOKE.replace(normal_stiffness=1e5), gravity=(G, 0.0, 0.0),
        step=step_of(1e5, 0.0, factor), steps=(len(table) - 1) * every, every=every,
        pairs=tuple((k, k + 1) for k in range(height - 1)),
    )  # fmt: skip
    force = -reference.run(scene, MFIX).force[:, 0, 0]
    expected = table[f"F_top_N{height}"]
    assert force == pytest.approx(expected, abs=2e-5 * expected.max())


@pytest.mark.parametrize(
    ("scheme", "low", "high"),
    [("velocity_verlet", 1.9, 2.1), ("mfix_euler", 0.9, 1.1), ("mfix_adams_bashforth", 1.9, 2.1)],
)
def test_order(scheme, low, high):
    """An oscillator below its plane, which it does not leave: order with its interval."""
    body = Body(radius=R, mass=MASS, position=(0.0, 0.0, R - 2e-5))
    load, seconds = 1e5 * 1e-5 / MASS, 0.004
    omega, sizes, errors = math.sqrt(1e5 / MASS), 2.0 ** np.arange(8, 13), []
    exact = R - 1e-5 - 1e-5 * math.cos(omega * seconds)
    for steps in sizes:
        scene = Scene(bodies=(body,), walls=(Wall(),), law=HOOKE, step=seconds / steps,
                      steps=int(steps), gravity=(0.0, 0.0, -load))  # fmt: skip
        end = reference.run(scene, Rules(scheme=scheme)).position[-1, 0, 2]
        errors.append(abs(end - exact))
    fit, covariance = np.polyfit(np.log(sizes), np.log(errors), 1, cov=True)
    doubt = 3.0 * math.sqrt(covariance[0, 0])
    assert low < -fit[0] - doubt
    assert -fit[0] + doubt < high


def test_forces_are_set_up_anew_where_a_run_begins_again():
    scene = impact(HOOKE.replace(**DAMPED), (0.0, 0.0, -1.0))
    whole, anew = reference.run(scene), reference.run(scene.replace(setups=(50,)))
    assert 0.0 < np.abs(anew.velocity - whole.velocity).max() < 1e-3


# ---- stages


def test_stages_end_at_looks():
    motion = reference.run(climbing((0.1, 0.0), (0.15, 0.0)))
    steps, times, x, _, vx, _, spin = motion.stages.T
    assert steps.tolist() == [0, 150, 200]  # 0.1 m is passed at step 143, 0.15 m at 187
    assert times == pytest.approx(steps * 1e-3)
    assert x == pytest.approx(times - 1.05 * times**2, abs=1e-12)
    assert vx == pytest.approx(1.0 - 2.1 * times)
    assert (spin == 3.0).all()
    assert len(motion) == 21


@pytest.mark.parametrize(("floor", "last"), [(0.9, 1000), (1.1, 500)])
def test_body_that_moves_back_below_the_floor_ends_the_run(floor, last):
    """Its energy is 1 J: at the first look behind the turn it is below one floor, not the other."""
    motion = reference.run(climbing((10.0, floor)))
    assert motion.stages[:, 0].tolist() == [0, last]
    assert last % LOOK == 0


def test_last_look_is_at_the_last_step():
    motion = reference.run(climbing((10.0, 0.0), steps=333))
    assert motion.stages[-1, 0] == 333
    assert len(motion) == 34


def test_overflow_is_an_error():
    scene = climbing((1e300, 0.0)).replace(step=1e10, gravity=(1e300, 0.0, 0.0))
    for each in (scene, scene.replace(stages=())):
        with pytest.raises(EngineNaNError, match="finite"):
            reference.run(each)


def test_simulation_in_pieces_is_the_same():
    scene = on_row(wells=3, steps=80_000, every=7)
    whole = reference.run(scene)
    parts = reference.Simulation(scene)
    while not parts.over:
        parts.advance(777)
    motion = parts.motion()
    assert np.array_equal(motion.stages, whole.stages)
    assert np.array_equal(motion.position, whole.position)
    assert motion.stages[-1, 2] > 3.0
    assert len(motion) == int(motion.stages[-1, 0]) // 7 + 1
