"""Run scenes in Yade: ``yade -n -x run_scenes.py scenes.json``, for Yade 2023.02a.

The file is a list of scenes in SI units, each with its law in Yade's words (``code``). The samples
of scene k are written to ``<k>.json``: ``step`` (samples,), and ``position``, ``velocity``,
``angular_velocity``, ``force`` and ``torque``, each (samples, bodies, 3); ``stages`` (K, 7) are
step, time, x, y, vx, vy and wz of the first body at the start and at the end of each stage.

A step of Yade computes the forces at x with v half a step behind, then moves v and x. Samples are
taken between: v is brought to the time of x by half a step of the force.
"""

from __future__ import annotations

import json
import math
import sys
from itertools import accumulate
from pathlib import Path
from typing import Any

SCENES = ""  # in place of the file, in a script of its own
PARTS = ("position", "velocity", "angular_velocity", "force", "torque")
LAWS = {  # materials and law of contacts, by their physics
    "ViscElPhys": ("ViscElMat", "Law2_ScGeom_ViscElPhys_Basic"),
    "CohFrictPhys": ("CohFrictMat", "Law2_ScGeom6D_CohFrictPhys_CohesionMoment"),
    "MindlinPhys": ("FrictMat", "Law2_ScGeom_MindlinPhys_Mindlin"),
}
FAR = 1e8  # [radius of the first sphere] to which a box reaches to each side
# The first forces are those of the velocities at the start, and no spring has moved yet: a step
# of no length. Not zero, lest anything be divided by it.
NO_STEP = 1e-60  # [s]
LOOK = 50  # steps between two looks at the first body in a scene with stages
WIDE = 1e3  # [radius of the first sphere] of a periodic cell across its period
FREE, HELD = 1, 3  # masks: those that share the second bit do not meet


class Simulation:
    """A scene in Yade; ``yade`` is the module of that name."""

    def __init__(self, yade: Any, scene: dict[str, Any]) -> None:
        self.yade, self.scene = yade, scene
        starts = accumulate((segment["steps"] for segment in scene["segments"]), initial=0)
        self.segments = dict(zip(starts, scene["segments"], strict=False))  # by their first step
        self.samples: dict[str, list[Any]] = {name: [] for name in ("step", *PARTS)}
        self.stages: list[list[float]] = []
        code = scene["code"]
        self.turns = code["law"] == "CohFrictPhys"
        yade.O.reset()
        yade.O.dt = NO_STEP
        if scene["period"][0]:
            yade.O.periodic = True  # places run on over the boundary
            wide = WIDE * scene["bodies"][0]["radius"]
            yade.O.cell.setBox(scene["period"][0], wide, wide)
        material, law = LAWS[code["law"]]
        materials = iter([getattr(yade, material)(**words) for words in code["materials"]])
        self.spheres = [self.add_sphere(body, next(materials)) for body in scene["bodies"]]
        for wall in scene["walls"]:
            self.add_wall(wall, next(materials))
        physics = getattr(yade, f"Ip2_{material}_{material}_{code['law']}")(**code["physics"])
        yade.O.engines = self.engines(physics, getattr(yade, law)(**code["options"]))
        if 0 in self.segments:
            self.set_velocities(self.segments[0])

    def add_sphere(self, body: dict[str, Any], material: Any) -> Any:
        """Return the body of a new sphere."""
        yade, fixed = self.yade, bool(self.scene["segments"]) or body["motion"] != "free"
        place = yade.Vector3(*body["position"])
        mask = HELD if fixed and not self.scene["segments"] else FREE
        sphere = yade.utils.sphere(place, body["radius"], material=material, fixed=fixed, mask=mask)
        moment = 0.4 * body["mass"] * body["radius"] ** 2
        sphere.state.mass, sphere.state.inertia = body["mass"], yade.Vector3(moment, moment, moment)
        sphere.state.vel = yade.Vector3(*body["velocity"])
        sphere.state.angVel = yade.Vector3(*body["angular_velocity"])
        yade.O.bodies.append(sphere)
        return sphere

    def add_wall(self, wall: dict[str, Any], material: Any) -> None:
        """Add a wall across an axis: a box where springs turn, which Yade's walls do not."""
        yade, normal = self.yade, wall["direction"]
        axis = max(range(3), key=lambda k: abs(normal[k]))
        place = wall["point"][axis]
        if not self.turns:
            yade.O.bodies.append(yade.utils.wall(place, axis=axis, material=material))
            return
        deep = self.scene["bodies"][0]["radius"]
        middle, size = [0.0] * 3, [FAR * deep] * 3
        middle[axis], size[axis] = place - deep * normal[axis], deep
        yade.O.bodies.append(yade.utils.box(middle, size, material=material, fixed=True))

    def engines(self, physics: Any, law: Any) -> list[Any]:
        """Return the engines of a step; velocities at a contact are those of its point."""
        yade, every = self.yade, 1 if self.segments else self.scene["every"]
        if self.turns:
            bounds = [yade.Bo1_Sphere_Aabb(), yade.Bo1_Box_Aabb()]
            pair = yade.Ig2_Sphere_Sphere_ScGeom6D(avoidGranularRatcheting=False)
            shapes = [pair, yade.Ig2_Box_Sphere_ScGeom6D()]
        else:
            bounds = [yade.Bo1_Sphere_Aabb(), yade.Bo1_Wall_Aabb()]
            pair = yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False)
            shapes = [pair, yade.Ig2_Wall_Sphere_ScGeom(hertzian=True, noRatch=False)]
        skin = 0.1 * min(body["radius"] for body in self.scene["bodies"])
        looks = [yade.PyRunner(iterPeriod=every, command="simulation.look()", initRun=True)]
        if self.scene["stages"]:
            looks += [yade.PyRunner(iterPeriod=LOOK, command="simulation.watch()", initRun=True)]
        self.watcher = looks[-1]
        return [
            yade.ForceResetter(),
            yade.InsertionSortCollider(bounds, verletDist=skin, avoidSelfInteractionMask=2),
            yade.InteractionLoop(shapes, [physics], [law]),
            *looks,
            yade.NewtonIntegrator(damping=0, gravity=yade.Vector3(*self.scene["gravity"])),
        ]

    def look(self) -> None:
        """Take a sample where one is due, and set velocities that change."""
        number = self.yade.O.iter
        if number % self.scene["every"] == 0:
            self.samples["step"].append(number)
            states = [self.state(body) for body in self.spheres]
            for part, name in enumerate(PARTS):
                rows = [[float(value) for value in state[part]] for state in states]
                self.samples[name].append(rows)
        if number == 0:
            self.yade.O.dt = self.scene["step"]
            for body in self.spheres:
                linear, angular = self.half_kick(body)
                body.state.vel -= linear
                body.state.angVel -= angular
        if number in self.segments:
            self.set_velocities(self.segments[number])

    def watch(self) -> None:
        """Look at the first sphere, and pause where the run is over."""
        number, stages, body = self.yade.O.iter, self.scene["stages"], self.spheres[0]
        x, v, spin, *_ = self.state(body)
        row = [number, number * self.scene["step"], x[0], x[1], v[0], v[1], spin[2]]
        remaining, stage = self.scene["steps"] - number, max(len(self.stages) - 1, 0)
        height = sum(g * place for g, place in zip(self.scene["gravity"], x, strict=True))
        square = sum(value * value for value in v)
        energy = body.state.mass * (0.5 * square - height)
        beyond = x[0] > stages[stage]["place"]
        over = remaining <= 0 or (v[0] < 0 and energy < stages[stage]["floor"] and not beyond)
        over = over or (beyond and stage + 1 == len(stages)) or not square < math.inf
        if number == 0 or beyond or over:
            self.stages.append([float(value) for value in row])
        if number and over:
            self.yade.O.pause()
        self.watcher.iterPeriod = max(1, min(LOOK, remaining))

    def state(self, body: Any) -> tuple[Any, ...]:
        """Return the parts of a sample of a sphere."""
        linear, angular = self.half_kick(body)
        state, forces = body.state, self.yade.O.forces
        moves = state.vel + linear, state.angVel + angular
        return (state.pos, *moves, forces.f(body.id, True), forces.t(body.id, True))

    def half_kick(self, body: Any) -> tuple[Any, Any]:
        """Return what half a step of the forces adds to both velocities."""
        yade, half = self.yade, 0.5 * self.yade.O.dt
        if not body.dynamic:
            return yade.Vector3(0, 0, 0), yade.Vector3(0, 0, 0)
        force, torque = yade.O.forces.f(body.id, True), yade.O.forces.t(body.id, True)
        linear = force / body.state.mass + yade.Vector3(*self.scene["gravity"])
        return half * linear, half * torque / body.state.inertia[0]

    def set_velocities(self, segment: dict[str, Any]) -> None:
        """Give the spheres the velocities of a segment."""
        moves = zip(segment["velocities"], segment["angular_velocities"], strict=True)
        for body, (velocity, spin) in zip(self.spheres, moves, strict=True):
            body.state.vel = self.yade.Vector3(*velocity)
            body.state.angVel = self.yade.Vector3(*spin)

    def run(self) -> dict[str, list[Any]]:
        """Return the samples of all steps; the last ones are of the forces of one step more."""
        self.yade.O.run(self.scene["steps"] + 1, wait=True)
        return {**self.samples, "stages": self.stages}


if __name__ == "__main__":
    import yade as module

    # Yade makes a folder below /tmp at its start and does not remove it
    Path(module.O.tmpFilename()).parent.rmdir()
    text = SCENES or Path(sys.argv[1]).read_text(encoding="utf-8")
    for place, scene in enumerate(json.loads(text)):
        simulation = Simulation(module, scene)  # the name that PyRunner's command calls
        part = Path(f"{place}.part")  # the file is there when it is whole
        part.write_text(json.dumps(simulation.run()), encoding="utf-8")
        part.rename(f"{place}.json")
