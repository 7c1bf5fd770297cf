"""A sphere falls in a fluid that drags it, up to its terminal velocity: LAMMPS's fix viscous."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Duration, Gravity
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.theory.contact import dragged


class Drag(ContactSystem):
    """A fall from rest, far from any wall; in SI units. A contact time is here m / drag."""

    drag: float = Field(0.1, ge=1e-12, le=1e12, description="[kg/s] force over velocity")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(2.0, description="[-] in times m / drag")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_words(self, partner=("wall",))

    @property
    def terminal_speed(self) -> float:
        """Return the terminal velocity m g / drag [m/s]."""
        return self.gravity * self.mass / self.drag


class DragCase(ContactCase[Drag]):
    """Speed and distance of a fall in a viscous fluid."""

    name = "drag"
    summary = "A falling sphere reaches its terminal velocity in a viscous fluid."
    formula = "m u' = m g - gamma u: u = v (1 - exp(-gamma t / m)), v = m g / gamma."
    parameters = Drag
    quantities = (
        Quantity("halfway_speed_over_terminal", "1", "speed of the fall over m g / gamma, halfway"),
        Quantity("speed_over_terminal", "1", "speed of the fall over m g / gamma, at the end"),
        Quantity("fall_ratio", "1", "height of the fall over m g / gamma times the time"),
    )
    laws: ClassVar = tables.laws("drag")
    systems: ClassVar = {"in a fluid": {"duration": 2.0}, "terminal": {"duration": 15.0}}
    always = ("terminal",)

    def build(self, p: Drag) -> Scene:
        """Return the sphere alone."""
        seconds = p.duration * p.mass / p.drag
        return Scene(
            bodies=p.bodies(0.0)[:1],
            law=p.stated_law,
            gravity=(0.0, 0.0, -p.gravity),
            drag=p.drag,
            **bounds.quarters(p.duration, p.duration * p.steps_per_contact, seconds),
        )

    def observe(self, p: Drag, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, at the end and on average, over the terminal speed."""
        fall = -motion.velocity[:, 0, 2] / p.terminal_speed
        distance = float(motion.position[0, 0, 2] - motion.position[-1, 0, 2])
        return {
            "halfway_speed_over_terminal": float(fall[len(fall) // 2]),
            "speed_over_terminal": float(fall[-1]),
            "fall_ratio": distance / p.terminal_speed / float(motion.time[-1]),
        }

    def exact(self, p: Drag) -> Mapping[str, float]:
        """Return the exponential approach."""
        (halfway, _), (speed, fallen) = (dragged(t * p.duration) for t in (0.5, 1.0))
        return {
            "halfway_speed_over_terminal": halfway,
            "speed_over_terminal": speed,
            "fall_ratio": fallen / p.duration,
        }


CASE = DragCase()
