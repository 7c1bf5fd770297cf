import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.solvers.pair.system import effective_moduli
from harness.upstream.definition import COLUMNS
from harness.upstream.scene import NotReadError, granular_law, old_law, scene_of

STATE = {name: np.zeros(2) for name in COLUMNS} | {
    "type": np.ones(2),
    "z": np.array([-0.01, 0.01]),
    "radius": np.full(2, 0.01),
    "mass": np.full(2, 0.5),
}
LOG = """
pair_style granular
pair_coeff * * hooke ${k} 0 tangential linear_history 2e5 0 0.5 damping velocity
pair_coeff * * hooke 1e6 0 tangential linear_history 2e5 0 0.5 damping velocity
fix move all nve/sphere
fix weight all gravity 9.81 vector 0 0 -2
"""


def law(text):
    return granular_law(text.split())


def test_a_command_counts_as_lammps_filled_it_in():
    scene = scene_of(LOG, STATE, 100, 1e-6)
    assert scene.law.normal_stiffness == 1e6
    assert scene.law.tangential == "linear_history"
    assert scene.law.friction == 0.5
    assert scene.gravity == (0.0, 0.0, -9.81)
    assert [body.position[2] for body in scene.bodies] == [-0.01, 0.01]


def test_walls_on_both_sides_look_into_the_room():
    one = {name: values[:1] for name, values in STATE.items()}
    wall = "fix w all wall/gran granular hooke 1e6 0 damping velocity zplane -0.1 0.2"
    scene = scene_of(f"fix move all nve/sphere\n{wall}", one, 10, 1e-6)
    assert [(p.point[2], p.normal[2]) for p in scene.planes] == [(-0.1, 1.0), (0.2, -1.0)]


def test_two_materials_are_those_of_both_types():
    types = {**STATE, "type": np.array([1.0, 2.0])}
    log = (
        "pair_style granular\npair_coeff 1 1 hertz/material 4e8 0 0.2 damping velocity\n"
        "pair_coeff 2 2 hertz/material 6e8 0 0.4 damping velocity\nfix move all nve/sphere"
    )
    scene = scene_of(log, types, 10, 1e-6)
    assert scene.law.materials == ((4e8, 0.2), (6e8, 0.4))


def test_spheres_that_forces_do_not_move_go_on_as_they_are():
    scene = scene_of(LOG.replace("nve/sphere", "nve/noforce"), STATE, 100, 1e-6)
    assert scene.segments[0].steps == 100


@given(st.floats(1e3, 1e12), st.floats(1.0, 1.99))
def test_k_n_and_k_t_are_those_of_a_material(k_n, ratio):
    stated = law(f"hertz {k_n!r} 0 tangential mindlin {ratio * k_n!r} 0 0.5 damping velocity")
    modulus, shear = effective_moduli(stated)
    assert 4.0 / 3.0 * modulus == pytest.approx(k_n, rel=1e-12)
    assert 8.0 * shear == pytest.approx(ratio * k_n, rel=1e-12)


def test_an_old_style_takes_half_of_its_dashpot_along_the_surface():
    stated = old_law("hooke/history", ["1e4", "NULL", "10", "NULL", "0.5", "1"])
    assert stated.damping == "mass_velocity"
    assert stated.tangential_stiffness == pytest.approx(2e4 / 7.0)
    assert stated.tangential_damping == 0.5


@pytest.mark.parametrize(
    ("log", "named"),
    [
        (LOG + "fix drag all viscous 1", "fix viscous"),
        (LOG + "fix weight all gravity 9.81 chute 20", "gravity chute"),
        (LOG.replace("all nve", "some nve"), "group some"),
        (LOG.replace("hooke", "mdr"), "mdr"),
        (LOG + "read_restart x", "read_restart"),
        (LOG + "fix w all wall/gran granular hooke 1 0 zplane 0 NULL wiggle z 1 2", "wall/gran"),
        (LOG + "fix w all wall/gran granular hooke 1 0 zplane 0 NULL", "several laws"),
        (LOG.replace("2e5 0 0.5", "2e5 0 0.5 heat area 1"), "heat"),
    ],
)
def test_what_a_scene_does_not_describe_is_named(log, named):
    with pytest.raises(NotReadError, match=named):
        scene_of(log, STATE, 100, 1e-6)
