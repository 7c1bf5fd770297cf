"""Run scenes in Kratos: ``python run_scenes.py scenes.json``, for Kratos 10.2 to 10.4.

The file is a list of scenes in SI units, each with its law in Kratos's words (``code``). The
samples of scene k are written to ``<k>.json``: ``step`` (samples,), and ``position``,
``velocity``, ``angular_velocity``, ``force`` and ``torque``, each (samples, bodies, 3); ``stages``
(K, 7) are step, time, x, y, vx, vy and wz of the first body at the start and the end of each stage.

An endless row of equal fixed spheres has four of them, as it looks the same from every well: a
first body that leaves the two in the middle is put back by their distance (``code.row``).
"""

from __future__ import annotations

import json
import math
import sys
from itertools import accumulate
from pathlib import Path
from typing import Any

SCENES = ""  # in place of the file, in a script of its own
AXES = "XYZ"
FIRST_WALL = 1_000_000  # number of its material; those of spheres count from 1
PARTS = ("SpheresPart", "ContactPart", "RigidFacePart", "DEMInletPart", "ClusterPart")
# all that Kratos's spheres and rigid faces read or write: what is missing is not checked
OF_SPHERES = (
    "VELOCITY", "DISPLACEMENT", "DELTA_DISPLACEMENT", "TOTAL_FORCES", "CONTACT_FORCES",
    "ELASTIC_FORCES", "RIGID_ELEMENT_FORCE", "LOCAL_CONTACT_FORCE", "DAMP_FORCES",
    "FORCE_REACTION", "MOMENT_REACTION", "EXTERNAL_APPLIED_FORCE", "EXTERNAL_APPLIED_MOMENT",
    "PARTICLE_MOMENT", "ANGULAR_VELOCITY", "LOCAL_ANGULAR_VELOCITY", "DELTA_ROTATION",
    "PARTICLE_ROTATION_ANGLE", "ORIENTATION", "ANGULAR_MOMENTUM", "RADIUS", "NODAL_MASS",
    "REPRESENTATIVE_VOLUME", "NEIGHBOUR_SIZE", "DAMAGE_RATIO", "PARTICLE_MATERIAL",
    "NORMAL_IMPACT_VELOCITY", "TANGENTIAL_IMPACT_VELOCITY", "FACE_NORMAL_IMPACT_VELOCITY",
    "FACE_TANGENTIAL_IMPACT_VELOCITY", "LINEAR_IMPULSE", "PARTICLE_MOMENT_OF_INERTIA",
    "ROLLING_RESISTANCE_MOMENT", "ROLLING_FRICTION", "LOCAL_AUX_ANGULAR_VELOCITY",
    "AUX_ORIENTATION",
)  # fmt: skip
OF_FACES = (
    "ELASTIC_FORCES", "DEM_PRESSURE", "TANGENTIAL_ELASTIC_FORCES", "SHEAR_STRESS",
    "DEM_NODAL_AREA", "CONTACT_FORCES", "TOTAL_FORCES", "VELOCITY", "DELTA_DISPLACEMENT",
    "DISPLACEMENT", "NON_DIMENSIONAL_VOLUME_WEAR", "IMPACT_WEAR", "ANGULAR_VELOCITY",
)  # fmt: skip
STRATEGY = """{"strategy": "sphere_strategy", "RemoveBallsInitiallyTouchingWalls": false,
"do_search_dem_neighbours": true, "do_search_fem_neighbours": true,
"model_import_settings": {}, "material_import_settings": {}}"""
LOOK = 50  # steps between two looks at the first body in a scene with stages
NAN = [math.nan] * 3
MOVED = {"velocity": "VELOCITY", "angular_velocity": "ANGULAR_VELOCITY"}
PLURAL = {"velocity": "velocities", "angular_velocity": "angular_velocities"}  # of a segment


class Simulation:
    """A scene in Kratos; ``core`` and ``dem`` are its modules."""

    def __init__(self, core: Any, dem: Any, scene: dict[str, Any]) -> None:
        self.core, self.dem, self.code = core, dem, scene["code"]
        self.row, self.scene, self.put_back = scene["bodies"][1:], scene, 0.0
        if self.code["row"]:
            self.scene = {**scene, "bodies": four_of_a_row(scene["bodies"], self.code["row"])}
        starts = accumulate((segment["steps"] for segment in scene["segments"]), initial=0)
        self.segments = dict(zip(starts, scene["segments"], strict=False))  # by their first step
        self.model = core.Model()  # holds the parts
        self.parts = [self.model.CreateModelPart(name) for name in PARTS]
        for part, names in ((self.parts[0], OF_SPHERES), (self.parts[2], OF_FACES)):
            for name in names:
                part.AddNodalSolutionStepVariable(self.variable(name))
        self.nodes = [self.add_sphere(k) for k in range(len(self.scene["bodies"]))]
        for k in range(len(scene["walls"])):
            self.add_wall(k)
        self.strategy = self.make_strategy()

    def variable(self, name: str) -> Any:
        """Return a variable of Kratos, of its core or of the DEM application."""
        return getattr(self.core, name, None) or getattr(self.dem, name)

    def material(self, number: int, young: float) -> Any:
        """Return a new material."""
        material = self.parts[0].CreateNewProperties(number)
        material[self.variable("YOUNG_MODULUS")] = young
        material[self.variable("POISSON_RATIO")] = self.code["poisson"]
        self.resist_rolling(material)
        return material

    def resist_rolling(self, properties: Any) -> None:
        """Set the model of rolling friction, of a body and of a contact alike."""
        if self.code["rolling"]:
            properties[self.variable("DEM_ROLLING_FRICTION_MODEL_NAME")] = self.code["rolling"]
            model = getattr(self.dem, self.code["rolling"])()
            model.SetAPrototypeOfThisInProperties(properties, False)

    def contact(self, number: int, gamma: float) -> Any:
        """Return the contact with the material of a number."""
        contact = self.core.Properties(number)
        for name, value in {**self.code["values"], "DAMPING_GAMMA": gamma}.items():
            contact[self.variable(name)] = value
        getattr(self.dem, self.code["law"])().SetConstitutiveLawInProperties(contact, False)
        self.resist_rolling(contact)
        return contact

    def add_sphere(self, k: int) -> Any:
        """Return the node of a new sphere, with a material of its own."""
        body, count = self.scene["bodies"][k], len(self.scene["bodies"])
        material = self.material(k + 1, self.code["young"])
        volume = 4.0 / 3.0 * math.pi * body["radius"] ** 3
        material[self.variable("PARTICLE_DENSITY")] = body["mass"] / volume
        for other, gamma in enumerate(self.code["gamma"][k]):
            number = other + 1 if other < count else FIRST_WALL + other - count
            if other != k:
                material.AddSubProperties(self.contact(number, gamma))
        scheme = self.dem.VelocityVerletScheme()
        scheme.SetTranslationalIntegrationSchemeInProperties(material, False)
        scheme.SetRotationalIntegrationSchemeInProperties(material, False)
        undamped = self.dem.DEMGlobalDampingNonViscousCstForceDir()
        undamped.SetGlobalDampingModelInProperties(material, False)
        node = self.parts[0].CreateNewNode(k + 1, *body["position"])
        self.parts[0].CreateNewElement("SphericParticle3D", k + 1, [k + 1], material)
        node.SetSolutionStepValue(self.variable("RADIUS"), 0, body["radius"])
        return node

    def add_wall(self, k: int) -> None:
        """Add a wall across an axis: a face of four corners."""
        part, far, wall = self.parts[2], self.code["room"], self.scene["walls"][k]
        axis = max(range(3), key=lambda i: abs(wall["direction"][i]))
        material = self.material(FIRST_WALL + k, self.code["wall_young"][k])
        material[self.variable("COMPUTE_WEAR")] = False
        first = FIRST_WALL + 10 * k
        corners = [(-far, -far), (far, -far), (far, far), (-far, far)]
        for number, corner in enumerate(corners):
            place = list(corner)
            place.insert(axis, wall["point"][axis])
            part.CreateNewNode(first + number, *place)
        part.CreateNewCondition("RigidFace3D4N", first, [first + i for i in range(4)], material)

    def make_strategy(self) -> Any:
        """Return Kratos's strategy after its first look at the spheres."""
        spheres, reach, step = self.parts[0], self.code["room"], self.scene["step"]
        fixed = [self.scene["segments"] or b["motion"] != "free" for b in self.scene["bodies"]]
        for name in (f"{moved}_{axis}" for moved in MOVED.values() for axis in AXES):
            self.core.VariableUtils().AddDof(self.variable(name), spheres)
            for node, is_fixed in zip(self.nodes, fixed, strict=True):
                if is_fixed:
                    node.Fix(self.variable(name))
        information = {
            "GRAVITY": self.core.Array3(self.scene["gravity"]),
            "DELTA_TIME": step,
            "NODAL_MASS_COEFF": 1.0,
            "ROTATION_OPTION": 1,
            "ROLLING_FRICTION_OPTION": int(bool(self.code["rolling"])),
            "SEARCH_CONTROL": 1,
            # a search that finds all there is needs no other
            "SEARCH_RADIUS_INCREMENT": reach,
            "SEARCH_RADIUS_INCREMENT_FOR_WALLS": reach,
        }
        for name, value in information.items():
            spheres.ProcessInfo[self.variable(name)] = value
        settings = self.dem.ExplicitSolverSettings()
        settings.r_model_part, settings.contact_model_part = self.parts[:2]
        settings.fem_model_part, settings.inlet_model_part = self.parts[2:4]
        settings.cluster_model_part = self.parts[4]
        # the third number: every step with TIME_STEPS above 0 searches, none with 0
        strategy = self.dem.IterativeSolverStrategy(
            settings, step, 1, 1.0, 1, self.dem.ParticleCreatorDestructor(),
            self.dem.DEM_FEM_Search(), self.dem.OMP_DEMSearch(),
            self.core.Parameters(STRATEGY),
        )  # fmt: skip
        strategy.RebuildListOfDiscontinuumSphericParticles()
        strategy.SetNormalRadiiOnAllParticlesBeforeInitilization(spheres)
        strategy.SetSearchRadiiOnAllParticles(spheres, reach, 1.0)
        start = {plural: [b[name] for b in self.scene["bodies"]] for name, plural in PLURAL.items()}
        self.set_velocities(self.segments.get(0, start))
        strategy.Initialize()
        return strategy

    def set_velocities(self, segment: dict[str, list[Any]]) -> None:
        """Give the spheres the velocities [m/s] and angular velocities [rad/s] of a segment."""
        for name, variable in MOVED.items():
            for node, vector in zip(self.nodes, segment[PLURAL[name]], strict=True):
                for axis, value in zip(AXES, vector, strict=True):
                    node.SetSolutionStepValue(self.variable(f"{variable}_{axis}"), 0, value)

    def sample(self) -> dict[str, list[list[float]]]:
        """Return the parts of a motion now; forces are those of contacts, unknown on a row."""
        gravity = self.scene["gravity"]
        totals = zip(self.vectors("TOTAL_FORCES"), self.scene["bodies"], strict=True)
        sample = {
            "position": [[node.X, node.Y, node.Z] for node in self.nodes],
            **{part: self.vectors(name) for part, name in MOVED.items()},
            "force": [
                [f - body["mass"] * g for f, g in zip(total, gravity, strict=True)]
                for total, body in totals
            ],
            "torque": self.vectors("PARTICLE_MOMENT"),
        }
        if not self.code["row"]:
            return sample
        sample["position"][0][0] += self.put_back
        still = {name: [body[name] for body in self.row] for name in ("position", *MOVED)}
        unknown = {name: [NAN] * len(self.row) for name in ("force", "torque")}
        return {name: [sample[name][0], *rows] for name, rows in {**still, **unknown}.items()}

    def vectors(self, name: str) -> list[list[float]]:
        """Return a vector of each sphere."""
        names = [self.variable(f"{name}_{axis}") for axis in AXES]
        return [[node.GetSolutionStepValue(variable) for variable in names] for node in self.nodes]

    def run(self) -> dict[str, list[Any]]:
        """Return the samples of all steps, or up to where a look ends the run."""
        information, searches = self.parts[0].ProcessInfo, self.variable("TIME_STEPS")
        samples: dict[str, list[Any]] = {"step": [0]}
        samples |= {name: [rows] for name, rows in self.sample().items()}
        stages, last = [self.stage_row(0)], self.scene["steps"]
        information[searches] = 1
        for number in range(1, last + 1):
            if number - 1 in self.segments:
                self.set_velocities(self.segments[number - 1])
            self.strategy.SolveSolutionStep()
            information[searches] = 0
            if number % self.scene["every"] == 0:
                samples["step"].append(number)
                for name, rows in self.sample().items():
                    samples[name].append(rows)
            if number % LOOK and number < last:
                continue
            if self.scene["stages"] and self.is_over(number, stages):
                break
            if self.code["row"] and self.leaves_well():
                information[searches] = 1
        return {**samples, "stages": stages}

    def stage_row(self, number: int) -> list[float]:
        """Return step, time, x, y, vx, vy and wz of the first body."""
        node = self.nodes[0]
        names = ("VELOCITY_X", "VELOCITY_Y", "ANGULAR_VELOCITY_Z")
        moves = [node.GetSolutionStepValue(self.variable(name)) for name in names]
        return [number, number * self.scene["step"], node.X + self.put_back, node.Y, *moves]

    def is_over(self, number: int, stages: list[list[float]]) -> bool:
        """Look at the first body: return whether the run is over, and keep the end of a stage."""
        row, stage = self.stage_row(number), self.scene["stages"][len(stages) - 1]
        _, _, x, y, vx, vy, _ = row
        body, (gx, gy, _) = self.scene["bodies"][0], self.scene["gravity"]
        energy = body["mass"] * (0.5 * (vx * vx + vy * vy) - gx * x - gy * y)
        beyond = x > stage["place"]
        over = beyond and len(stages) == len(self.scene["stages"])
        over = over or (vx < 0.0 and energy < stage["floor"] and not beyond)
        over = over or number == self.scene["steps"] or not math.isfinite(x + y + vx + vy)
        if beyond or over:
            stages.append(row)
        return over

    def leaves_well(self) -> bool:
        """Put the first body back between the spheres in the middle of a row, if it left them."""
        pitch, node = self.code["row"], self.nodes[0]
        shift = pitch * math.floor((node.X - self.nodes[2].X) / pitch)
        node.X0 -= shift
        node.X -= shift
        self.put_back += shift
        return bool(shift)


def four_of_a_row(bodies: list[dict[str, Any]], pitch: float) -> list[dict[str, Any]]:
    """Return the first body and the four spheres of a row about it."""
    grain, first = bodies[0], bodies[1]
    x, y, z = first["position"]
    behind = x + pitch * math.floor((grain["position"][0] - x) / pitch)
    return [grain, *({**first, "position": [behind + k * pitch, y, z]} for k in (-1, 0, 1, 2))]


def main(text: str) -> None:
    """Run scenes in JSON."""
    import KratosMultiphysics as core
    import KratosMultiphysics.DEMApplication as dem

    core.ParallelUtilities.SetNumThreads(1)  # of a few spheres more threads only wait
    core.Logger.GetDefaultOutput().SetSeverity(core.Logger.Severity.WARNING)
    for place, scene in enumerate(json.loads(text)):
        part = Path(f"{place}.part")  # the file is there when it is whole
        part.write_text(json.dumps(Simulation(core, dem, scene).run()), encoding="utf-8")
        part.rename(f"{place}.json")


if __name__ == "__main__":
    main(SCENES or Path(sys.argv[1]).read_text(encoding="utf-8"))
