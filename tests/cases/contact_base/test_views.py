"""Views of a scene, by the reference integration: the same motion comes back, or a fault shows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.contact import transformations
from harness.cases.contact.motion import Motion, values_of
from harness.cases.contact.transformations import EXCHANGED, MIRRORED, SMALLER, TURNED
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane, Segment
from harness.solvers.pair.integration import integrate

LAW = ContactLaw(
    normal="hertz", youngs_modulus=1e8, damping="viscoelastic", damping_coefficient=4e5,
    tangential="mindlin", tangential_damping=0.5, friction=0.3,
    rolling="sds", rolling_stiffness=2e4, rolling_damping=0.5, rolling_friction=0.05,
    twisting="sds", twisting_stiffness=1.0, twisting_damping=1e-4, twisting_friction=1e-2,
)  # fmt: skip
FIRST = Body(0.01, 0.01, (0.0, 0.0, 0.01), (0.3, -0.2, -1.0), (20.0, 40.0, -70.0))
SECOND = Body(0.02, 0.08, (0.0, 0.0, -0.02), (0.1, 0.0, 0.0), (0.0, -5.0, 11.0))
FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
ON_FLOOR = ContactScene((FIRST,), (FLOOR,), LAW, 1e-6, 600, every=50, gravity=(300.0, 0.0, -900.0))
PAIR = ContactScene((FIRST, SECOND), (), LAW, 1e-6, 600, every=50)

VIEWS = {
    "turned": transformations.View(TURNED),
    "mirrored": transformations.View(MIRRORED),
    "exchanged": transformations.View(EXCHANGED),
    "units": SMALLER,
}


def motion(scene):
    path = integrate(scene)
    return Motion(
        path.times, path.positions, path.velocities, path.omegas, path.forces, path.torques
    )


def test_the_materials_of_two_are_renumbered_with_them():
    law = LAW.replace(partner_youngs_modulus=4e8, partner_poisson_ratio=0.1)
    other = transformations.Renumbered().scene(replace(PAIR, law=law)).law
    assert other.materials == law.materials[::-1]
    assert transformations.Renumbered().scene(PAIR).law == LAW
    smaller = SMALLER.scene(replace(PAIR, law=law)).law
    scale = smaller.youngs_modulus / law.youngs_modulus
    assert smaller.partner_youngs_modulus / law.partner_youngs_modulus == scale


def apart(one, other):
    """Return the largest difference of two motions, part by part, over the part's size."""
    return max(
        np.abs(getattr(one, part) - getattr(other, part)).max() / np.abs(getattr(one, part)).max()
        for part in transformations.PARTS
    )


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("scene", [ON_FLOOR, PAIR], ids=["floor", "pair"])
def test_the_motion_of_a_view_comes_back(view, scene):
    # the reference integration is exact to 1e-10, whatever the axes
    assert apart(motion(scene), view.back(motion(view.scene(scene)))) < 1e-9


def test_the_motion_of_renumbered_bodies_and_of_a_moving_frame_comes_back():
    renumbered, moving = (
        transformations.Renumbered(),
        transformations.View(TURNED, (3.0, -2.0, 1.0)),
    )
    for view in (renumbered, moving):
        assert apart(motion(PAIR), view.back(motion(view.scene(PAIR)))) < 1e-9


@pytest.mark.parametrize(
    "fault",
    [
        lambda seen: replace(seen, gravity=ON_FLOOR.gravity),
        lambda seen: replace(seen, planes=ON_FLOOR.planes),
        lambda seen: replace(
            seen,
            bodies=(replace(seen.bodies[0], omega=tuple(-w for w in seen.bodies[0].omega)),),
        ),
    ],
    ids=["gravity", "plane", "spin"],
)
def test_a_part_of_the_scene_that_is_not_turned_shows(fault):
    view = transformations.View(MIRRORED)
    assert apart(motion(ON_FLOOR), view.back(motion(fault(view.scene(ON_FLOOR))))) > 1e-3


@pytest.mark.parametrize(
    "name", sorted({*transformations.DIMENSIONS} & {*LAW.model_dump(exclude_none=True)})
)
def test_a_coefficient_without_its_dimension_shows(name, monkeypatch):
    monkeypatch.delitem(transformations.DIMENSIONS, name)
    units = transformations.Units(0.5, 0.5, 0.25)
    assert apart(motion(PAIR), units.back(motion(units.scene(PAIR)))) > 1e-7


def test_every_coefficient_with_a_dimension_has_one():
    units = {name: f.description.split("]")[0][1:] for name, f in ContactLaw.model_fields.items()}
    bare = {name for name, unit in units.items() if unit in ("-", "1")}
    assert units.keys() - bare - transformations.DIMENSIONS.keys() == set()
    assert bare & transformations.DIMENSIONS.keys() == set()


def test_an_elastic_run_goes_back_and_one_with_a_dashpot_does_not():
    elastic = ContactLaw(normal="hertz", youngs_modulus=1e8)
    damped = elastic.replace(damping="viscoelastic", damping_coefficient=4e5)
    for law, returns in ((elastic, True), (damped, False)):
        scene = replace(PAIR, law=law)
        there = motion(scene)
        back = transformations.run_backwards(motion(transformations.turned_back(scene, there)))
        assert (np.abs(there.velocity - back.velocity).max() < 1e-8) == returns


def test_scripts_are_told_of_planes_of_any_direction_at_rest_or_moving():
    assert "walls_as" not in values_of(ON_FLOOR)
    told = values_of(transformations.View(EXCHANGED).scene(ON_FLOOR))
    assert (told["walls_as"], told["up_x"], told["planes"]) == ("xplane", 1.0, 1)
    assert values_of(transformations.View(TURNED).scene(ON_FLOOR))["walls_as"] == "region"
    told = values_of(transformations.View(velocity=(0.0, 0.0, 2.0)).scene(ON_FLOOR))
    assert (told["walls_as"], told["up_z"], told["drift_z"]) == ("region", 1.0, 2.0)
    lid = Plane((0.0, 0.0, 0.05), (0.0, 0.0, -1.0))
    told = values_of(transformations.View(TURNED).scene(replace(ON_FLOOR, planes=(FLOOR, lid))))
    assert told["ceiling"] == pytest.approx(0.05)
    for wrong in (replace(lid, normal=(0.0, 1.0, 0.0)), replace(lid, velocity=(1.0, 0.0, 0.0))):
        with pytest.raises(RequestError, match="none, a floor, or a floor and a ceiling"):
            values_of(replace(ON_FLOOR, planes=(FLOOR, wrong)))


def test_scripts_move_one_body_whichever_it_is():
    still, pushed = (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)
    piece = Segment(600, (pushed, still), (still, still))
    bodies = tuple(replace(body, velocity=still, omega=still) for body in (FIRST, SECOND))
    guided = replace(PAIR, bodies=bodies, segments=(piece,))
    assert "mover" not in values_of(guided)
    told = values_of(transformations.Renumbered().scene(guided))
    assert (told["mover"], told["vz_in_1"]) == (2, -1.0)
    both = replace(piece, velocities=(pushed, pushed))
    with pytest.raises(RequestError, match="scripts move one body"):
        values_of(replace(guided, segments=(both,)))


def test_the_reference_integration_refuses_a_plane_that_moves():
    with pytest.raises(RequestError, match="takes those at rest"):
        integrate(replace(ON_FLOOR, planes=(replace(FLOOR, velocity=(1.0, 0.0, 0.0)),)))
    with pytest.raises(RequestError, match=r"velocity = .* three finite numbers"):
        replace(FLOOR, velocity=(math.nan, 0.0, 0.0))
