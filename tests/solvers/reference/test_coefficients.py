"""A coefficient off by 1e-6 moves a scene, where the trials of the contact cases have it not.

For all others ``tests/cases/contacts/test_coefficients.py`` has each law of each case. Each
coefficient of a law is in one of the two.
"""

import pytest

from harness.model.law import COEFFICIENTS
from harness.solvers import reference
from tests.cases.contacts.common import CASES
from tests.solvers.reference.scenes import (
    HERTZ,
    MDR,
    MINDLIN,
    STILL,
    YIELDS,
    R,
    difference,
    guided,
    impact,
)  # fmt: skip

SHALLOW = 4 * R - 5.1e-4  # psi of an elastic side at the depth d is (4 R - 2 d) / (4 R - d)
SHARE = (SHALLOW - 5.1e-4) / SHALLOW * (1.0 - 5e-7)


def slanted(law):
    return impact(law, (0.5, 0.3, -1.0), every=20, spin=(9.0, 5.0, 7.0))


def confined(law):
    """Return a sphere on its way into the floor, which it leaves dented."""
    return guided(law, (1000, (0.0, 0.0, -1.0), STILL), (200, (0.0, 0.0, 1.0), STILL), every=20)


SCENES = [
    ("normal_modulus", slanted(HERTZ.replace(normal_modulus=1e8))),
    ("tangential_modulus", slanted(MINDLIN.replace(tangential_modulus=3e8))),
    ("bulk_share", confined(MDR.replace(bulk_share=SHARE))),
    *((name, confined(YIELDS.replace(bulk_share=0.3)))
      for name in ("yield_stress", "youngs_modulus", "poisson_ratio")),
]  # fmt: skip


def test_every_coefficient_is_tested_here_or_in_a_contact_case():
    laws = [trial.parameters.stated_law for case in CASES for trial in case.trials]
    in_cases = {name for name in COEFFICIENTS for law in laws if getattr(law, name)}
    assert in_cases | {name for name, _ in SCENES} == COEFFICIENTS


@pytest.mark.parametrize(("name", "scene"), SCENES)
def test_coefficient(name, scene):
    off = scene.law.replace(**{name: getattr(scene.law, name) * (1.0 + 1e-6)})
    assert difference(reference.run(scene), reference.run(scene.replace(law=off))) > 1e-9


@pytest.mark.parametrize("name", ["inertia", "position"])
def test_bodies(name):
    scene = slanted(MINDLIN)
    body = scene.bodies[0]
    x, y, z = body.position
    near = {"inertia": body.moment_of_inertia * (1.0 + 1e-6), "position": (x, y, z * (1.0 + 1e-6))}
    off = scene.replace(bodies=(body.replace(**{name: near[name]}),))
    assert difference(reference.run(scene), reference.run(off)) > 1e-10
