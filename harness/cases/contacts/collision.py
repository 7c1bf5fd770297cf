"""Two spheres that both move collide at an angle: of other densities, a small one on a large one.

What is judged is relative: it must be the same whatever moves. Codes that add the slip of half a
step to a spring in the plane of a whole one were seen to trap small spheres among large ones (Vyas
et al., Comput. Phys. Commun. 310, 109524 (2025)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.oblique import CASE as OBLIQUE
from harness.cases.contacts.oblique import QUANTITIES, Oblique, velocity_ratios
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.model.scene import Scene


class Collision(Oblique):
    """An impact of two free spheres at an angle, each with a part of the velocity; SI units."""

    partner_share: float = Field(
        0.5, ge=-10.0, le=10.0, description="[-] of the speed that the second sphere has"
    )

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_words(self, partner=("sphere",))
        super().check()


class CollisionCase(ContactCase[Collision]):
    """Relative velocities, spin and momentum of two moving spheres."""

    name = "collision"
    summary = "Two moving spheres collide at an angle, of other densities and sizes."
    formula = (
        "As an oblique impact, whatever moves, with m* and R* of both spheres. Where it slides "
        "throughout, vx'/vx = 1 - mu (1 + e) vn/vx of the relative velocity. The momentum of both "
        "stays."
    )
    parameters = Collision
    quantities: ClassVar[Sequence[Quantity[Any]]] = (
        *QUANTITIES,
        Quantity(
            "momentum_change_ratio", "1",
            "along the normal, of both, after less before, over m* times the speed",
        ),
    )  # fmt: skip
    laws: ClassVar = tables.pick(
        "linear_history", "mindlin_rescale/force", "rolling sds, linear_history", "mindlin"
    ) | tables.laws("further_tangential", "undamped_rolling")
    systems: ClassVar = {
        "two moving spheres": {"partner_radius": None, "partner_density": None},
        "unequal densities": {"partner_radius": None, "partner_density": 10000.0},
        "size ratio 10": {"partner_radius": 0.1, "partner_share": 0.1},
        "size ratio 100": {"partner_radius": 1.0, "partner_share": 0.1},
    }

    def build(self, p: Collision) -> Scene:
        """Return the impact seen where the second sphere moves towards the first."""
        x, _, z = (-p.partner_share * v for v in p.velocity)
        scene = OBLIQUE.build(p)

        def moving(velocity: Vector) -> Vector:
            return (velocity[0] + x, velocity[1], velocity[2] + z)

        bodies = (body.replace(velocity=moving(body.velocity)) for body in scene.bodies)
        return scene.replace(bodies=tuple(bodies))

    def observe(self, p: Collision, motion: Motion) -> Mapping[str, float]:
        """Return ratios of relative velocities, and the change of the momentum of both."""
        masses = np.array([p.mass, p.second_mass])
        momentum = masses @ motion.velocity[:, :, 2].T
        size = p.effective_mass * p.speed
        return {
            **velocity_ratios(p, motion),
            "momentum_change_ratio": float(momentum[-1] - momentum[0]) / size,
        }

    def exact(self, p: Collision) -> Mapping[str, float]:
        """Return that no momentum is lost."""
        return {"momentum_change_ratio": 0.0}


CASE = CollisionCase()
