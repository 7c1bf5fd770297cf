"""Two spheres that both move meet at an angle: of other densities, and a small one on a large one.

What is judged is relative: it must be the same whatever moves. Codes that add the slip of half a
step to a spring in the plane of a whole one were seen to trap small spheres among large ones (Vyas
et al., Comput. Phys. Commun. 310, 109524 (2025)): an error of the order of the step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import meets
from harness.cases.contact.submodels import (
    ROLLING,
    ROLLING_UNDAMPED,
    SLIDING,
    TANGENTIAL,
    TANGENTIAL_BESIDE,
    Told,
)
from harness.cases.oblique import CASE as OBLIQUE
from harness.cases.oblique import Oblique
from harness.parameters.scene import ContactScene


class Collision(Oblique):
    """An impact of two free spheres at an angle, each with a part of the velocity; SI units."""

    partner_share: float = Field(
        0.5, ge=-10.0, le=10.0, description="[-] of the speed that the second sphere has"
    )

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, "sphere")
        super().check()


class CollisionCase(ContactCase[Collision]):
    """Two moving spheres meet at an angle, of other densities and sizes: velocities and spin."""

    name = "collision"
    submodels = (
        *(
            submodel
            for submodel in TANGENTIAL
            if submodel.name in ("linear_history", "mindlin_rescale/force")
        ),
        *(submodel for submodel in ROLLING if submodel.name == "rolling sds, linear_history"),
        *(submodel for submodel in TANGENTIAL if submodel.name == "mindlin"),
    )
    other_submodels = (*TANGENTIAL_BESIDE, *ROLLING_UNDAMPED)
    sets: ClassVar[Told] = {"usual": {"partner": "sphere", **SLIDING}}
    systems: ClassVar[Told] = {
        "two moving spheres": {"partner_radius": None, "partner_density": None},
        "unequal densities": {"partner_radius": None, "partner_density": 10000.0},
        "size ratio 10": {"partner_radius": 0.1, "partner_share": 0.1},
        "size ratio 100": {"partner_radius": 1.0, "partner_share": 0.1},
    }

    def scene(self, parameters: Collision) -> ContactScene:
        """Return the impact as it is seen where the second sphere moves towards the first."""
        x, _, z = (-parameters.partner_share * v for v in parameters.velocity)
        scene = OBLIQUE.scene(parameters)
        bodies = (
            replace(b, velocity=(b.velocity[0] + x, b.velocity[1], b.velocity[2] + z))
            for b in scene.bodies
        )
        return replace(scene, bodies=tuple(bodies))

    def observed(self, parameters: Collision, motion: Motion) -> Mapping[str, float]:
        """Return ratios of relative velocities, and what the momentum of both changed by."""
        masses = np.array([parameters.mass, parameters.second_mass])
        momentum = masses @ motion.velocity[:, :, 2].T
        size = parameters.reduced_mass * parameters.speed
        return {
            **OBLIQUE.observed(parameters, motion),
            "momentum_change_ratio": float(momentum[-1] - momentum[0]) / size,
        }

    def sizes(self, parameters: Collision) -> Mapping[str, float]:
        """Return the size of the ratio of impulses."""
        return OBLIQUE.sizes(parameters)

    def closed_forms(self, parameters: Collision) -> Mapping[str, float]:
        """Return that no momentum is lost."""
        return {"momentum_change_ratio": 0.0}


CASE = CollisionCase()
