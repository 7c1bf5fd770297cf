"""Contacts in surroundings that a scene does not hold: drag, heat, walls that move or are curved.

Scripts are told of them beside the scene. What is expected follows from closed forms, or from the
integration of a scene that has the same motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from harness.cases.contact.contact_case import ContactCase, P
from harness.cases.contact.motion import Motion, default_values, motion_of, values_of
from harness.cases.contact.parameters import ContactSystem
from harness.engines.contract import Job, Output, Template, Value
from harness.parameters.scene import ContactScene

NONE: dict[str, Value] = {
    **{"wall": "plane", "wall_radius": 1.0},
    **{"moves": "none", "amplitude": 0.0, "period": 1.0, "wall_speed": 0.0},
    **{"drag": 0.0, "units": "si"},
    **{"heat": "none", "conductance": 0.0, "heat_capacity": 1.0},
    **dict.fromkeys(("temperature_1", "temperature_2", "wall_temperature"), 0.0),
}
"""Of a contact at a plane at rest, in nothing."""

TEMPLATE = Template(
    name="surroundings",
    variants={
        "plane": {**default_values(bodies=1), **NONE},
        "pair": {**default_values(bodies=2), **NONE},
    },
    notes={
        "plane": "a sphere at a wall that may move or be curved, with drag, with heat.",
        "pair": "two spheres, with drag, with heat.",
    },
)


class SurroundedCase(ContactCase[P]):
    """A case with a script that says more than its scene."""

    template: ClassVar[Template] = TEMPLATE
    has_invariances = False

    def surroundings(self, parameters: P) -> Mapping[str, Value]:
        """Return the values of scripts besides the scene's, by the names in :data:`NONE`."""
        return {}

    def set_up(self, parameters: P) -> ContactScene:
        """Return the scene that scripts begin with."""
        return self.scene(parameters)

    def motion(self, parameters: P, output: Output) -> Motion:
        """Return the samples of a run; raise EngineOutputError where some are missing."""
        return motion_of(output, self.set_up(parameters))

    def job(self, parameters: P) -> Job:
        """Return the job of one run."""
        scene = self.set_up(parameters)
        values = values_of(scene, parameters.interface)
        variant = "plane" if len(scene.bodies) == 1 else "pair"
        return Job(TEMPLATE, {**values, **self.surroundings(parameters)}, variant, sampled=True)


class ClosedFormCase(SurroundedCase[P]):
    """A case whose quantities are all known exactly, and whose scene does not move as it does."""

    def is_integrated(self, parameters: P) -> bool:
        """Return False: no scene moves as the run does."""
        return False


def refused(parameters: ContactSystem, **allowed: tuple[str, ...]) -> None:
    """Raise ValueError for a part of a law that a case does not take, by its name."""
    for name, words in allowed.items():
        value = getattr(parameters, name)
        if value not in words:
            must = ", ".join(words)
            raise ValueError(f"{name} = {value!r}: must be one of {must} in this case")
