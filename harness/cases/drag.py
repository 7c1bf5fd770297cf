"""A sphere falls in a fluid that drags it, up to its terminal velocity: LAMMPS's fix viscous."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import ContactSystem, Duration, Gravity, counted, meets
from harness.cases.contact.submodels import HOOKE, Told, named
from harness.model.scene import Scene
from harness.parameters.scene import ContactScene
from harness.theory.contact import dragged

SAMPLES = 4


class Drag(ContactSystem):
    """A fall from rest, far from any wall; in SI units. A contact time is here m / drag."""

    drag: float = Field(0.1, ge=1e-12, le=1e12, description="[kg/s] force over velocity")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(2.0, description="[-] in times m / drag")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, "wall")

    @property
    def relaxation(self) -> float:
        """Return m / drag [s]."""
        return self.mass / self.drag

    @property
    def terminal(self) -> float:
        """Return the terminal velocity m g / drag [m/s]."""
        return self.gravity * self.relaxation


class DragCase(ContactCase[Drag]):
    """A falling sphere reaches its terminal velocity in a viscous fluid."""

    name = "drag"
    submodels = named({"viscous": HOOKE})
    systems: ClassVar[Told] = {"in a fluid": {"duration": 2.0}, "terminal": {"duration": 15.0}}
    every_level = ("terminal",)
    sets: ClassVar[Told] = {"falls": HOOKE}

    def scene(self, parameters: Drag) -> ContactScene:
        """Return the sphere alone."""
        n = parameters.steps_per_contact
        counted(parameters, parameters.duration * n)
        every = max(1, round(parameters.duration * n / SAMPLES))
        first, *_ = parameters.bodies(0.0, (0.0, 0.0, 0.0))
        return ContactScene(
            (first,),
            (),
            parameters.law,
            step=parameters.duration * parameters.relaxation / SAMPLES / every,
            steps=SAMPLES * every,
            every=every,
            gravity=(0.0, 0.0, -parameters.gravity),
        )

    def setup(self, parameters: Drag) -> Scene:
        """Return the scene with the drag."""
        return super().setup(parameters).replace(drag=parameters.drag)

    def observed(self, parameters: Drag, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, at the end and on average, over the terminal speed."""
        fall = -motion.velocity[:, 0, 2] / parameters.terminal
        distance = float(motion.position[0, 0, 2] - motion.position[-1, 0, 2])
        return {
            "halfway_speed_over_terminal": float(fall[len(fall) // 2]),
            "speed_over_terminal": float(fall[-1]),
            "fall_ratio": distance / parameters.terminal / float(motion.time[-1]),
        }

    def closed_forms(self, parameters: Drag) -> Mapping[str, float]:
        """Return the exponential approach."""
        (halfway, _), (speed, fallen) = map(dragged, (t * parameters.duration for t in (0.5, 1.0)))
        return {
            "halfway_speed_over_terminal": halfway,
            "speed_over_terminal": speed,
            "fall_ratio": fallen / parameters.duration,
        }


CASE = DragCase()
