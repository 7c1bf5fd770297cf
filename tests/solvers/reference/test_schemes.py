"""The schemes beside velocity Verlet, neighbours by index, and long rows and columns."""

import math
from pathlib import Path

import numpy as np
import pytest

from harness.errors import EngineNaNError
from harness.model.conventions import Faults, Rules
from harness.model.law import Law, damping_ratio
from harness.model.scene import Body, Scene, Wall
from harness.solvers import reference
from tests.solvers.reference.scenes import DAMPED, HOOKE, MASS, G, R, impact

RECORDED = Path(__file__).parent / "recorded"
MFIX = Rules(scheme="mfix_euler", frozen_mass="own", least_overlap=1e-15)
EULER, BASHFORTH = Rules(scheme="mfix_euler"), Rules(scheme="mfix_adams_bashforth")


def recorded(name):
    return np.genfromtxt(RECORDED / name, delimiter=",", names=True)


def step_of(stiffness, ratio, factor):
    """Return MFiX's step [s]: contact time by m/2 over a factor."""
    omega = math.sqrt(stiffness / 0.5)
    return math.pi / (omega * math.sqrt(1.0 - ratio**2)) / factor


@pytest.mark.parametrize(("factor", "seconds"), [(50, 0.6), (500, 1.9)])
def test_recorded_incline(factor, seconds):
    """To the six digits printed, as long as single precision has not grown."""
    table = recorded(f"quartier_k1e6_euler_f{factor}_th10.20.csv")
    ratio, angle, every = damping_ratio(1e-20), math.radians(10.20), 20 * factor // 50
    row = [
        Body(radius=0.5, mass=1.0, position=(k + 0.5, 0.0, 0.0), motion="frozen") for k in range(10)
    ]
    grain = Body(radius=0.5, mass=1.0, position=(1.0, math.sqrt(0.75), 0.0),
                 velocity=(1.5 * math.sqrt(0.75), 0.75, 0.0))  # fmt: skip
    scene = Scene(
        bodies=(grain, *row), law=Law.linear(1e6, ratio, clipped=False),
        gravity=(G * math.sin(angle), -G * math.cos(angle), 0.0), period=(10.0, None, None),
        step=step_of(1e6, ratio, factor), steps=(len(table) - 1) * every, every=every,
    )  # fmt: skip
    motion = reference.run(scene, MFIX)
    assert motion.time == pytest.approx(table["t_s"], rel=1e-5)
    early = table["t_s"] < seconds
    for name, values in (("x_m", motion.position[:, 0, 0]), ("vx_m_s", motion.velocity[:, 0, 0])):
        assert values[early] == pytest.approx(table[name][early], abs=2e-4)


@pytest.mark.parametrize("height", [2, 3, 5, 10])
def test_recorded_tower(height):
    table = recorded("tower_k1e5_euler_f50.csv")
    bodies = [
        Body(radius=0.5, mass=1.0, position=(float(k), 0.0, 0.0),
             velocity=(2.0 if k == 0 else 0.0, 0.0, 0.0),
             motion="frozen" if k == height - 1 else "free")
        for k in range(height)
    ]  # fmt: skip
    scene = Scene(
        bodies=tuple(bodies), law=HOOKE.replace(normal_stiffness=1e5), gravity=(G, 0.0, 0.0),
        step=step_of(1e5, 0.0, 50), steps=len(table) - 1,
        pairs=tuple((k, k + 1) for k in range(height - 1)),
    )  # fmt: skip
    force = -reference.run(scene, MFIX).force[:, 0, 0]
    expected = table[f"F_top_N{height}"]
    assert force == pytest.approx(expected, abs=2e-5 * expected.max())


def by_hand(steps, step, bashforth, k=1e5, eta=2.0):
    """Return heights and speeds of a sphere on the floor, by MFiX's formulas in plain Python."""

    def acceleration(z, v):
        return -G + (max(k * (R - z), 0.0) - eta * v * (z < R)) / MASS

    z, v = R - 1e-5, -0.3
    before, path = acceleration(z, v), [(z, v)]
    for _ in range(steps):
        a = acceleration(z, v)
        after = v + 0.5 * step * (3 * a - before) if bashforth else v + step * a
        z += 0.5 * step * (v + after) if bashforth else step * after
        v, before = after, a
        path.append((z, v))
    return np.array(path)


@pytest.mark.parametrize("rules", [EULER, BASHFORTH])
def test_mfix_schemes_by_hand(rules):
    body = Body(radius=R, mass=MASS, position=(0.0, 0.0, R - 1e-5), velocity=(0.0, 0.0, -0.3))
    scene = Scene(bodies=(body,), walls=(Wall(),), law=HOOKE.replace(**DAMPED), step=2e-5,
                  steps=400, gravity=(0.0, 0.0, -G))  # fmt: skip
    motion = reference.run(scene, rules)
    path = by_hand(400, 2e-5, bashforth=rules is BASHFORTH)
    assert motion.position[:, 0, 2] == pytest.approx(path[:, 0], abs=1e-15)
    assert motion.velocity[:, 0, 2] == pytest.approx(path[:, 1], rel=1e-11, abs=1e-12)


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


def test_simulation_that_is_looked_at():
    """The first look past a place, or at a grain that moves back, ends a stretch."""
    free = Body(radius=R, mass=MASS, velocity=(1.0, 0.0, 0.0))
    scene = Scene(bodies=(free,), step=1e-3, steps=1000, gravity=(-2.1, 0.0, 0.0))
    simulation = reference.Simulation(scene)
    assert simulation.advance_until(0.1, 1000)
    assert simulation.step_number == 150
    assert simulation.advance_until(10.0, 850)
    assert simulation.step_number == 500  # it moves back from 0.476 s on
    simulation.advance(50)
    assert len(simulation.motion()) == 551
    assert not simulation.advance_until(10.0, 0)


def test_continued_run_is_the_same_but_for_its_setup():
    scene = impact(HOOKE.replace(**DAMPED), (0.0, 0.0, -1.0))
    whole, parts = reference.run(scene), reference.Simulation(scene)
    for _ in range(4):
        parts.advance(scene.steps // 4)
    assert parts.motion().velocity == pytest.approx(whole.velocity, abs=0.0)
    anew = reference.run(scene.replace(setups=(50,)))
    assert 0.0 < np.abs(anew.velocity - whole.velocity).max() < 1e-3


def test_overflow_is_an_error():
    far = Body(radius=R, mass=1e-20, velocity=(1e300, 0.0, 0.0))
    with pytest.raises(EngineNaNError, match="finite"):
        reference.run(Scene(bodies=(far,), step=1e10, steps=10, law=HOOKE))


def test_faults_by_default_change_nothing():
    scene = impact(HOOKE.replace(**DAMPED), (0.0, 0.0, -1.0), every=10)
    first, second = reference.run(scene), reference.run(scene, Rules(), Faults())
    assert np.array_equal(first.velocity, second.velocity)
