"""The reference is exact: its tolerance reduced, its events, and what runs are made of."""

import dataclasses

import numpy as np
import pytest

from harness.parameters.submodels import TANGENTIAL
from harness.solvers.pair.integration import integrate
from tests.solvers.pair.scenes import HERTZ, LINEAR, collision, impact

SPINNING = ((1.0, 0.5, -1.0), (30.0, 100.0, 200.0))
ROLLING = {"rolling": "sds", "rolling_stiffness": 1e5, "rolling_damping": 1.0}
LAWS = {
    "linear": LINEAR,
    "clipped": LINEAR.replace(clipped=True),
    "no history": LINEAR.replace(tangential="linear_nohistory"),
    "rolling": LINEAR.replace(**ROLLING, rolling_friction=0.05),
    "twisting": LINEAR.replace(
        twisting="sds", twisting_stiffness=1.0, twisting_damping=1e-5, twisting_friction=1e-3
    ),
    "marshall": HERTZ.replace(twisting="marshall"),
    **{
        name: HERTZ.replace(tangential=name)
        for name in TANGENTIAL
        if name.startswith("mindlin") and name != "mindlin_classic"
    },
    "viscoelastic": HERTZ.replace(damping="viscoelastic", damping_coefficient=1e8),
    "mass_velocity": HERTZ.replace(damping="mass_velocity", damping_coefficient=1e3),
    "dmt": HERTZ.replace(normal="dmt", damping="none", surface_energy=10.0),
    "jkr": HERTZ.replace(normal="jkr", damping="none", surface_energy=10.0),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("scene", [lambda law: impact(law, *SPINNING), collision])
def test_results_agree_to_1e_10_where_the_tolerance_is_ten_times_larger(law, scene):
    fine = integrate(scene(law))
    coarse = integrate(scene(law), tolerance=1e-14)
    size = np.abs(fine.velocities).max()
    radius = np.array([[body.radius] for body in scene(law).bodies])
    assert np.abs(fine.velocities - coarse.velocities).max() < 1e-10 * size
    assert np.abs((fine.omegas - coarse.omegas) * radius).max() < 1e-10 * size
    assert [e.kind for e in fine.events] == [e.kind for e in coarse.events]


@pytest.mark.parametrize("law", [LINEAR, HERTZ])
def test_errors_fall_with_the_tolerance(law):
    runs = [integrate(impact(law, *SPINNING), tolerance=t) for t in (1e-8, 1e-11, 1e-15)]
    *errors, _ = (np.abs(run.velocities[-1] - runs[-1].velocities[-1]).max() for run in runs)
    assert errors[1] < 0.05 * errors[0]
    assert runs[0].steps < runs[2].steps


def test_samples_do_not_change_the_motion():
    many = integrate(impact(HERTZ, *SPINNING, samples=97))
    once = integrate(impact(HERTZ, *SPINNING))
    assert many.times.shape == (98,)
    assert many.velocities[-1] == pytest.approx(once.velocities[-1], rel=1e-12)


def test_events_stand_where_the_law_says():
    path = integrate(impact(LINEAR, *SPINNING))
    kinds = [event.kind for event in path.events]
    assert kinds == ["begins", "slides", "sticks", "turns", "slides", "attracts", "sticks", "ends"]
    turns, attracts, ends = (path.of_kind(kind)[0] for kind in ("turns", "attracts", "ends"))
    assert abs(attracts.force) < 1e-10 * turns.force
    assert abs(ends.overlap) < 1e-11 * turns.overlap
    assert ends.force < 0.0


def test_mindlin_with_damping_pushes_along_the_sliding_at_first():
    """The spring, cut back against the dashpot, is stretched forward; it stiffens as a grows."""
    scene = impact(HERTZ, (3.0, 0.0, -1.0), time=1e-6)
    path = integrate(scene)
    assert path.velocities[-1, 0, 0] > 3.0
    force = integrate(dataclasses.replace(scene, law=HERTZ.replace(tangential="mindlin/force")))
    assert force.velocities[-1, 0, 0] < 3.0
