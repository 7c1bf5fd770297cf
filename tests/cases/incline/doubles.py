"""The energy map in place of an engine, and faults of scenes."""

import math

import numpy as np

from harness.cases.incline.runs import Fate, Run
from harness.engines.base import Output
from harness.engines.output import Provenance
from harness.theory.incline import passage_margin

MAP = Output((), Provenance("map", "1"))


class EnergyMap:
    """Measures cases by the energy map of the theory, with jitter, or by a fate of the angle."""

    def __init__(self, shock=0.25, shift=None, fate=None, margin=None, touching=True):
        self.shock, self.shift, self.fate = shock, shift or (lambda _: 0.0), fate
        self.margin, self.touching, self.cases = margin, touching, []

    def __call__(self, cases):
        self.cases += cases
        return [self._run(case) for case in cases]

    def _run(self, case):
        angle = case.angle + self.shift(case)
        left = self.margin(angle) if self.margin else passage_margin(angle, self.shock)
        fate = Fate.MOVES_ON if left >= 0.0 else Fate.TRAPPED
        fate = self.fate(case.angle) if self.fate else fate
        return Run(case, fate, left, self.touching, 1.0, 10, np.empty(0), MAP)


# ---- faults of a scene, off by a factor: functions of a scene


def changed(thing, name, factor):
    """Return a thing with a number off by a factor, or another word; unchanged without one."""
    value = getattr(thing, name)
    if value is None:
        return thing
    return thing.replace(**{name: factor if isinstance(factor, str | bool) else value * factor})


def scaled(name, factor=1.0 + 1e-7):
    """Return a fault of a number of the scene."""
    return lambda scene: changed(scene, name, factor)


def coefficient(name, factor=1.0 + 1e-7):
    """Return a fault of a coefficient or a word of the law."""
    return lambda scene: scene.replace(law=changed(scene.law, name, factor))


def grain(name, factor=1.0 + 1e-7):
    """Return a fault of a number of the grain."""

    def change(scene):
        first, *row = scene.bodies
        stated = first.replace(inertia=first.moment_of_inertia)
        return scene.replace(bodies=(changed(stated, name, factor), *row))

    return change


def diameters(factor=1.0 + 1e-7):
    """Return a fault of all radii."""
    return lambda scene: scene.replace(
        bodies=tuple(changed(body, "radius", factor) for body in scene.bodies)
    )


def turned(by=1e-7):
    """Return a fault of the tilt, by a relative error."""

    def change(scene):
        along, down, _ = scene.gravity
        g, tilt = math.hypot(along, down), math.atan2(along, -down) * (1.0 + by)
        return scene.replace(gravity=(g * math.sin(tilt), -g * math.cos(tilt), 0.0))

    return change
