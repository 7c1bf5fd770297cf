"""A grain meets one fixed sphere: what tells the rules of a contact.

Made by dem-harness 0.1.0 (`dem-harness inputs` writes it again; edit the template,
not this file).

Run it as it stands, or with other parameters, with a Python that has Kratos
(pip install KratosMultiphysics KratosDEMApplication):

    python drop.py
    python drop.py restitution=0.8 effective_mass=half
    python drop.py --cases FILE      a case a line, its parameters separated by spaces

The sphere's centre is the origin, the grain starts above it.
Lines "RESULT name = value" end each run; the series has 17 digits. SI units.
Written for Kratos 10.2.3, 10.4.3, 10.4.4, one thread.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import KratosMultiphysics as Kratos
import KratosMultiphysics.DEMApplication as DEM

PARAMETERS = {
    "stiffness": 1000000.0,  # normal stiffness k, N/m
    "steps_per_contact": 2000.0,  # steps per contact time pi sqrt(m/k)
    "gravity": 0.0,  # m/s2, downward
    "diameter": 1.0,  # of both spheres, m
    "density": 1.909859317102744,  # of the grain, kg/m3; this one: 1 kg at 1 m
    "gap": 0.001,  # m, from the sphere; negative: pressed
    "speed": 1.0,  # m/s, downward
    "sideways": 0.0,  # m/s, along x
    "steps": 6000,
    "series_every": 1,  # steps between two rows
    # The dashpot is stated as its coefficient, eta = 2 zeta sqrt(k m_eff), never left to Kratos's
    # restitution. Kratos never lets a contact attract: the tail is clipped.
    "damping": "restitution",  # restitution or ratio
    "restitution": 0.5,  # e = 0: critical damping
    "damping_ratio": 1.0,  # zeta
    "effective_mass": "full",  # against a fixed sphere: full (m) or half (m/2)
    "scheme": "Velocity_Verlet",  # or Symplectic_Euler
    "search_tolerance": 0.25,  # of the contact search, in diameters
    "search_tolerance_against_walls": 0.25,  # the one that Kratos goes by, see below
    "search_every": 50,  # steps between two searches, fewer where a sphere is fast
    "series": "drop.csv",  # file for the motion; empty: none
    "results": "",  # file for the RESULT lines; empty: they are printed only
}


def run(p: SimpleNamespace) -> None:
    """Drop the grain and write its path."""
    began = time.perf_counter()
    mass = p.density * math.pi * p.diameter**3 / 6.0
    step = math.pi * math.sqrt(mass / p.stiffness) / p.steps_per_contact
    centres = [(0.0, 0.0), (0.0, p.diameter + p.gap)]
    spheres = Spheres(p, mass, dashpot(p, mass), step, (0.0, -p.gravity), centres, [1])
    spheres.begin({1: (p.sideways, -p.speed)})
    grain = spheres.nodes[1]
    rows: Rows = [[0.0, *spheres.state(grain)]]
    for count in range(p.series_every, p.steps + 1, p.series_every):
        spheres.advance(p.series_every)
        rows.append([count * step, *spheres.state(grain)])
    write_series(p, "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s", rows)
    results = [
        ("damping_coefficient_N_s_per_m", dashpot(p, mass)),
        ("step_s", step),
        ("final_velocity_m_per_s", rows[-1][4]),
        ("seconds", time.perf_counter() - began),
        ("verdict", "finished"),
    ]
    finish(p, results)


def dashpot(p: SimpleNamespace, mass: float) -> float:
    """Return eta = 2 zeta sqrt(k m_eff) [N s/m]."""
    zeta = p.damping_ratio
    if p.damping == "restitution":
        zeta = 1.0
        if p.restitution > 0.0:
            logarithm = math.log(p.restitution)
            zeta = -logarithm / math.hypot(math.pi, logarithm)
    effective = 0.5 * mass if p.effective_mass == "half" else mass
    return 2.0 * zeta * math.sqrt(p.stiffness * effective)


LAW = "DEM_D_Linear_viscous_Coulomb"
LOOK = 50  # steps between two looks at the motion
Rows = list[list[float]]


class Spheres:
    """Equal spheres without friction, some of them fixed: set up in Kratos without files.

    ``damping`` is the dashpot's coefficient [N s/m] of every contact.
    """

    def __init__(
        self,
        p: SimpleNamespace,
        mass: float,
        damping: float,
        step: float,
        gravity: tuple[float, float],
        centres: list[tuple[float, float]],
        mobile: list[int],
    ) -> None:
        self.step, self.search_every = step, p.search_every
        self.reach = p.search_tolerance * p.diameter
        self.model = Kratos.Model()
        self.part, settings = self._parts()
        material = self._material(p, mass, damping)
        self.nodes = [self._sphere(p, i, x, y, material) for i, (x, y) in enumerate(centres, 1)]
        self._free(mobile)
        self.mobile = [self.nodes[i] for i in mobile]
        self.searched = [(node.X, node.Y) for node in self.mobile]
        self.until_search, self.steps_planned = 0, 1
        self._inform(p, gravity)
        verlet = p.scheme == "Velocity_Verlet"
        kind = DEM.IterativeSolverStrategy if verlet else DEM.ExplicitSolverStrategy
        # the third number: every step with TIME_STEPS above 0 searches, none with 0
        self.strategy = kind(
            settings, step, 1, 1.0, 1, DEM.ParticleCreatorDestructor(), DEM.DEM_FEM_Search(),
            DEM.OMP_DEMSearch(), Kratos.Parameters(STRATEGY),
        )  # fmt: skip
        self.strategy.RebuildListOfDiscontinuumSphericParticles()
        self.strategy.SetNormalRadiiOnAllParticlesBeforeInitilization(self.part)
        self.strategy.SetSearchRadiiOnAllParticles(self.part, self.reach, 1.0)

    def begin(self, speeds: dict[int, tuple[float, float]]) -> None:
        """Give mobile spheres their velocities [m/s] and let Kratos take its first look."""
        for i, speed in speeds.items():
            self.nodes[i].SetSolutionStepValue(variable("VELOCITY_X"), 0, speed[0])
            self.nodes[i].SetSolutionStepValue(variable("VELOCITY_Y"), 0, speed[1])
        self.strategy.Initialize()

    def advance(self, steps: int) -> None:
        """Take so many steps, and search for contacts often enough to find every one in time."""
        solve, info = self.strategy.SolveSolutionStep, self.part.ProcessInfo
        while steps > 0:
            if self.until_search == 0:
                self._plan_search()
                info[TIME_STEPS] = 1
                solve()
                info[TIME_STEPS] = 0
                taken = 1
            else:
                taken = min(steps, self.until_search)
                for _ in range(taken):
                    solve()
            steps -= taken
            self.until_search -= taken

    def _plan_search(self) -> None:
        """Decide after how many steps the next search but this one comes.

        What a search finds is right until a pair that it left out has closed in by the
        tolerance. The steps to the next one shall take an eighth of that, and half of it
        is refused.
        """
        now = [self.state(node) for node in self.mobile]
        fastest = max(math.hypot(vx, vy) for _, _, vx, vy in now)
        if not math.isfinite(fastest):
            sys.exit("a velocity is not a number")
        for (x, y, _, _), (x0, y0) in zip(now, self.searched, strict=True):
            if self.steps_planned > 1 and math.hypot(x - x0, y - y0) > 0.5 * self.reach:
                sys.exit("a sphere moved by half the search tolerance between two searches")
        self.searched = [(x, y) for x, y, _, _ in now]
        affordable = 0.125 * self.reach
        count = self.search_every
        if fastest * self.step * count > affordable:
            count = max(1, int(affordable / (fastest * self.step)))
        self.until_search = self.steps_planned = count

    def shift(self, way: float) -> None:
        """Move the one mobile sphere along x by so much [m], and search before the next forces."""
        node = self.mobile[0]
        node.X0 += way
        node.X += way
        self.searched = [(x + way, y) for x, y in self.searched]
        self.until_search = 0

    def state(self, node: Any) -> tuple[float, float, float, float]:
        """Return position [m] and velocity [m/s] of a sphere."""
        value = node.GetSolutionStepValue
        return node.X, node.Y, value(VELOCITY_X), value(VELOCITY_Y)

    def _parts(self) -> tuple[Any, Any]:
        """Return the part of the model for the spheres, and the strategy's settings."""
        names = ("SpheresPart", "ContactPart", "RigidFacePart", "DEMInletPart", "ClusterPart")
        parts = [self.model.CreateModelPart(name) for name in names]
        for name in NODAL:
            parts[0].AddNodalSolutionStepVariable(variable(name))
        settings = DEM.ExplicitSolverSettings()
        settings.r_model_part, settings.contact_model_part = parts[0], parts[1]
        settings.fem_model_part, settings.inlet_model_part = parts[2], parts[3]
        settings.cluster_model_part = parts[4]
        return parts[0], settings

    def _material(self, p: SimpleNamespace, mass: float, damping: float) -> Any:
        """Return the material whose contact with itself has stiffness and damping as asked for.

        The law's stiffness is 1.432 pi 0.31225 E* R*, with E* = E / 2 for Poisson's ratio
        0 and R* = d / 4; its dashpot 2 gamma sqrt(k m / 2), also against a fixed sphere.
        Set by itself, gamma does not go through Kratos's table of restitutions.
        """
        material = self.part.CreateNewProperties(1)
        young = 8.0 * p.stiffness / (1.432 * math.pi * 0.31225 * p.diameter)
        material[variable("YOUNG_MODULUS")] = young
        material[variable("POISSON_RATIO")] = 0.0
        material[variable("PARTICLE_DENSITY")] = mass * 6.0 / math.pi / p.diameter**3
        contact = Kratos.Properties(1)
        for name in ("STATIC_FRICTION", "DYNAMIC_FRICTION", "FRICTION_DECAY", "ROLLING_FRICTION"):
            contact[variable(name)] = 0.0
        contact[variable("COEFFICIENT_OF_RESTITUTION")] = 0.0
        contact[variable("DAMPING_GAMMA")] = damping / (2.0 * math.sqrt(p.stiffness * mass / 2.0))
        getattr(DEM, LAW)().SetConstitutiveLawInProperties(contact, False)
        material.AddSubProperties(contact)
        scheme = getattr(DEM, p.scheme.replace("_", "") + "Scheme")()
        scheme.SetTranslationalIntegrationSchemeInProperties(material, False)
        scheme.SetRotationalIntegrationSchemeInProperties(material, False)
        DEM.DEMGlobalDampingNonViscousCstForceDir().SetGlobalDampingModelInProperties(
            material, False
        )
        return material

    def _free(self, mobile: list[int]) -> None:
        """Let mobile spheres move in the plane, and the others not at all."""
        for axis in "XYZ":
            Kratos.VariableUtils().AddDof(variable(f"VELOCITY_{axis}"), self.part)
            Kratos.VariableUtils().AddDof(variable(f"ANGULAR_VELOCITY_{axis}"), self.part)
        for i, node in enumerate(self.nodes):
            for axis in "Z" if i in mobile else "XYZ":
                node.Fix(variable(f"VELOCITY_{axis}"))

    def _inform(self, p: SimpleNamespace, gravity: tuple[float, float]) -> None:
        """Give Kratos step, gravity and the tolerances of its contact search.

        Its first search alone goes by the tolerance for spheres: every later one goes by
        the tolerance against walls, also where there is no wall.
        """
        info = self.part.ProcessInfo
        info[variable("GRAVITY")] = Kratos.Array3([*gravity, 0.0])
        info[variable("DELTA_TIME")] = self.step
        info[variable("NODAL_MASS_COEFF")] = 1.0
        info[variable("SEARCH_CONTROL")] = 1
        info[variable("SEARCH_RADIUS_INCREMENT")] = self.reach
        against_walls = p.search_tolerance_against_walls * p.diameter
        info[variable("SEARCH_RADIUS_INCREMENT_FOR_WALLS")] = against_walls

    def _sphere(self, p: SimpleNamespace, number: int, x: float, y: float, material: Any) -> Any:
        """Return the node of a new sphere."""
        node = self.part.CreateNewNode(number, x, y, 0.0)
        self.part.CreateNewElement("SphericParticle3D", number, [number], material)
        node.SetSolutionStepValue(variable("RADIUS"), 0, 0.5 * p.diameter)
        return node


def variable(name: str) -> Any:
    """Return a variable of Kratos, of its core or of the DEM application."""
    return getattr(Kratos, name, None) or getattr(DEM, name)


TIME_STEPS, VELOCITY_X, VELOCITY_Y = map(variable, ("TIME_STEPS", "VELOCITY_X", "VELOCITY_Y"))
# all that Kratos's spheres read or write, here or not: what is missing is not checked
NODAL = (
    "VELOCITY", "DISPLACEMENT", "DELTA_DISPLACEMENT", "TOTAL_FORCES", "CONTACT_FORCES",
    "ELASTIC_FORCES", "RIGID_ELEMENT_FORCE", "LOCAL_CONTACT_FORCE", "DAMP_FORCES",
    "FORCE_REACTION", "MOMENT_REACTION", "EXTERNAL_APPLIED_FORCE", "EXTERNAL_APPLIED_MOMENT",
    "PARTICLE_MOMENT", "ANGULAR_VELOCITY", "LOCAL_ANGULAR_VELOCITY", "DELTA_ROTATION",
    "PARTICLE_ROTATION_ANGLE", "ORIENTATION", "ANGULAR_MOMENTUM", "RADIUS", "NODAL_MASS",
    "REPRESENTATIVE_VOLUME", "NEIGHBOUR_SIZE", "DAMAGE_RATIO", "PARTICLE_MATERIAL",
    "NORMAL_IMPACT_VELOCITY", "TANGENTIAL_IMPACT_VELOCITY", "FACE_NORMAL_IMPACT_VELOCITY",
    "FACE_TANGENTIAL_IMPACT_VELOCITY", "LINEAR_IMPULSE",
)  # fmt: skip
STRATEGY = """{
    "strategy": "sphere_strategy", "do_search_dem_neighbours": true,
    "do_search_fem_neighbours": false, "RemoveBallsInitiallyTouchingWalls": false,
    "model_import_settings": {}, "material_import_settings": {}
}"""


ALLOWED = {
    "stiffness": (
        lambda value: not (value <= 0 or value != value),
        " N/m: must be greater than 0",
    ),
    "steps_per_contact": (
        lambda value: not (value <= 0 or value > 100000 or value != value),
        ": must be greater than 0 and less than or equal to 100000",
    ),
    "diameter": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "density": (
        lambda value: not (value <= 0 or value != value),
        " kg/m3: must be greater than 0",
    ),
    "gravity": (
        lambda value: not (value < 0 or value != value),
        " m/s2: must be greater than or equal to 0",
    ),
    "gap": (
        lambda value: not (value <= -0.25 or value > 10 or value != value),
        " m: must be greater than -0.25 and less than or equal to 10",
    ),
    "damping": (
        lambda value: value in ["restitution", "ratio"],
        ": must be one of restitution, ratio",
    ),
    "restitution": (
        lambda value: not (value < 0 or value > 1 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 1",
    ),
    "damping_ratio": (
        lambda value: not (value < 0 or value > 100 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 100",
    ),
    "effective_mass": (
        lambda value: value in ["full", "half"],
        ": must be one of full, half",
    ),
    "steps": (
        lambda value: not (value < 1 or value != value),
        ": must be a whole number, greater than or equal to 1",
    ),
    "series_every": (
        lambda value: not (value < 1 or value != value),
        ": must be a whole number, greater than or equal to 1",
    ),
    "scheme": (
        lambda value: value in ["Velocity_Verlet", "Symplectic_Euler"],
        ": must be one of Velocity_Verlet, Symplectic_Euler",
    ),
}


def value_of(name, text):
    """Return a parameter given as text, of the type of its default; end for one not allowed."""
    if name not in PARAMETERS:
        sys.exit(f"ERROR: {name}: no such parameter; there are {', '.join(PARAMETERS)}")
    kind = type(PARAMETERS[name])
    try:
        value = kind(text)
    except ValueError:
        what = {int: "a whole number", list: "a list"}.get(kind, "a number")
        sys.exit(f"ERROR: {name} = {text}: must be {what}")
    if name in ALLOWED and not ALLOWED[name][0](value):
        sys.exit(f"ERROR: {name} = {text}{ALLOWED[name][1]}")
    return value


def parameters(words: list[str]) -> SimpleNamespace:
    """Return the parameters, with those given as NAME=VALUE in place of the defaults."""
    values: dict[str, Any] = dict(PARAMETERS)
    for word in words:
        name, _, text = word.partition("=")
        values[name] = value_of(name, text)
    return SimpleNamespace(**values)


def write_series(p: SimpleNamespace, header: str, rows: Rows) -> None:
    """Write rows of numbers with 17 digits, if a file was asked for."""
    if p.series:
        lines = (",".join(f"{value:.17g}" for value in row) for row in rows)
        Path(p.series).write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")


def finish(p: SimpleNamespace, results: list[tuple[str, object]]) -> None:
    """Print the results, and write them to a file if one was asked for."""
    lines = [f"RESULT {name} = {show(value)}" for name, value in results]
    print("\n".join(lines), flush=True)
    if p.results:
        Path(p.results).write_text("\n".join(lines) + "\n", encoding="utf-8")


def show(value: object) -> str:
    """Return a result as text, numbers with 17 digits."""
    return f"{value:.17g}" if isinstance(value, float) else str(value)


def main() -> None:
    """Run the case that the command line names, or every line of a file of cases."""
    Kratos.ParallelUtilities.SetNumThreads(1)  # a few spheres: more threads only wait
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    if len(sys.argv) == 3 and sys.argv[1] == "--cases":
        cases = Path(sys.argv[2]).read_text(encoding="utf-8").splitlines()
        for case in cases:
            run(parameters(case.split()))
    else:
        run(parameters(sys.argv[1:]))


if __name__ == "__main__":
    main()
