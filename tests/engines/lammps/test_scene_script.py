"""Scripts: each value and coefficient is in them, and what LAMMPS cannot state is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.drop import TEMPLATE, Drop, values_of
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.scene import rules, script
from harness.errors import Unsupported
from harness.model.scene import Wall, sphere
from tests.engines.lammps.scenes import (
    BOWL,
    HEATED,
    LAWS,
    LINEAR,
    LOW,
    MASS,
    MINDLIN,
    MIXED,
    PIPE,
    SIDE,
    SYSTEMS,
    TILTED,
    R,
    off_by,
    on_wall,
)


def test_the_committed_input_is_generated(inputs):
    script = Lammps.script(TEMPLATE)
    assert (inputs / script.name).read_text(encoding="utf-8") == script.text


@given(st.floats(0.0, 1e-2), st.floats(1e5, 1e12))
def test_numbers_reach_lammps_at_full_precision(gap, stiffness):
    values = values_of(Drop(gap=gap, stiffness=stiffness))
    texts = {name: Lammps.literal(value) for name, value in values.items()}
    assert (float(texts["gap"]), float(texts["stiffness"])) == (gap, stiffness)
    assert " " not in "".join(texts.values())


def test_share_of_bulk_reaches_the_script():
    """Alone of all coefficients no motion shows that it is off by a millionth."""
    for system in ("wall", "spheres"):
        scene = SYSTEMS[system](LAWS["mdr, bulk"])
        other = scene.replace(law=off_by("mdr, bulk", "bulk_share"))
        assert script(scene) != script(other)


def three(law):
    """Return three spheres of different sizes, two of one type."""
    bodies = [
        sphere(R * k, 2500.0, position=(9.0 * R * k, 0.0, 0.0), type=max(k - 1, 1))
        for k in (1, 2, 3)
    ]
    return SYSTEMS["spheres"](law).replace(bodies=tuple(bodies))


OLD_HISTORY = LAWS["gran/hooke/history"]
SHELL = sphere(R, 2500.0, inertia=0.6 * MASS * R**2)
OSCILLATES = {"amplitude": (1e-5, 0.0, 1e-5), "frequency": 600.0}
UNSUPPORTED = {
    "two materials of one type": three(MINDLIN.replace(**MIXED)),
    "two materials at a wall": SYSTEMS["wall"](MINDLIN.replace(**MIXED)),
    "friction of each of gran/*": SYSTEMS["spheres"](OLD_HISTORY.replace(partner_friction=0.1)),
    "constant torque": SYSTEMS["wall"](LINEAR.replace(rolling="constant", rolling_friction=0.1)),
    "heat of gran/*": SYSTEMS["wall"](LAWS["gran/hooke"].replace(**HEATED)),
    "two laws of gran/*": three(LINEAR).replace(laws={(1, 1): LAWS["gran/hooke"]}),
    "shell": SYSTEMS["wall"](LINEAR).replace(bodies=(SHELL,)),
    "oblique oscillation": on_wall(Wall(**OSCILLATES), LOW),
    "oscillating bowl": on_wall(BOWL.replace(**OSCILLATES), LOW),
    "tilted shear": on_wall(Wall(direction=TILTED, surface_velocity=(0.0, 0.1, 0.0)), LOW),
    "tilted cylinder": on_wall(PIPE.replace(direction=TILTED), SIDE),
    "wall of a group": on_wall(Wall(bodies=(0,)), LOW),
    "spin across": on_wall(PIPE.replace(spin=(1.0, 0.0, 0.0)), SIDE),
}


@pytest.mark.parametrize("name", UNSUPPORTED)
def test_unsupported(name):
    with pytest.raises(Unsupported):
        rules(UNSUPPORTED[name])


@pytest.mark.parametrize(
    ("law", "release"),
    [("coeff_restitution of hertz", 2024), ("mdr, yield", 2025), ("mindlin_classic", 2023)],
)
def test_release_lacks_submodel(law, release):
    scene = SYSTEMS["wall"](LAWS[law])
    with pytest.raises(Unsupported, match=rf"23 Jun 2022 has no .*: LAMMPS .* {release} has it"):
        rules(scene, "23 Jun 2022")
    assert rules(scene, "22 Jul 2025") == rules(scene)
