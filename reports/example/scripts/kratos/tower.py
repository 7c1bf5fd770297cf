"""Equal spheres in the plane without friction: the scene of the case tower.

Made by dem-harness 1.0.0 (`dem-harness inputs --engine kratos` writes it again).

Run it as it stands, or with other parameters, with a Python that has Kratos
(pip install KratosMultiphysics KratosDEMApplication):

    python tower.py
    python tower.py stiffness=1e7 steps=1000 vx=[1,0]
    python tower.py FILE              a list of them in JSON

It writes the motion to a file. Kratos's contacts always clip the tail: they never attract.
Lines "RESULT name = value" end each run; the series has 17 digits. SI units.
Written for Kratos 10.2.3, 10.4.3, 10.4.4, one thread unless OMP_NUM_THREADS says more.
"""

import json
import math
import os
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import KratosMultiphysics as Kratos
import KratosMultiphysics.DEMApplication as DEM

PARAMETERS = {
    # spheres, the first of them mobile: places [m], velocities [m/s], 1 for one that is fixed
    "x": [0.0, 1.0, 2.0],
    "y": [0.0, 0.0, 0.0],
    "vx": [2.0, 0.0, 0.0],
    "vy": [0.0, 0.0, 0.0],
    "fixed": [0, 0, 1],
    "mass": 1.0,  # of each, kg
    "diameter": 1.0,  # of each, m
    "period": 0.0,  # of the endless row that the fixed ones are of, m; 0: there is no row
    "gravity_x": 9.81,  # m/s2
    "gravity_y": 0.0,
    "stiffness": 1000000.0,  # k, N/m
    "damping": 0.0,  # of each contact, eta, N s/m
    "step": 3.1415926535897933e-06,  # s
    "steps": 3009,  # of the run at most
    # the run ends when the first sphere, looked at every 50 steps, is beyond the last of
    # these x [m], or moves back before the next one with less energy [J] than its floor
    "places": [],
    "floors": [],
    "every": 4,  # steps between samples; 0: none
    "forces": 1,  # 1: all spheres and their forces along x are sampled, 0: the first
    "scheme": "Velocity_Verlet",  # or Symplectic_Euler
    "search_tolerance": 0.25,  # of the contact search, in diameters
    "search_tolerance_against_walls": 0.25,  # the one that Kratos goes by, see below
    "search_every": 50,  # steps between two searches, fewer where a sphere is fast
    "series": "tower.csv",  # file for the samples
    "results": "",  # file for the lines RESULT, beside the screen
}
LOOK = 50


ALLOWED = {
    "stiffness": (
        lambda value: not (value <= 0 or value != value),
        ": must be greater than 0",
    ),
    "mass": (
        lambda value: not (value <= 0 or value != value),
        ": must be greater than 0",
    ),
    "diameter": (
        lambda value: not (value <= 0 or value != value),
        ": must be greater than 0",
    ),
    "step": (
        lambda value: not (value <= 0 or value != value),
        ": must be greater than 0",
    ),
    "steps": (
        lambda value: not (value < 1 or value != value),
        ": must be a whole number, greater than or equal to 1",
    ),
    "damping": (
        lambda value: not (value < 0 or value != value),
        ": must be greater than or equal to 0",
    ),
    "period": (
        lambda value: not (value < 0 or value != value),
        ": must be greater than or equal to 0",
    ),
    "every": (
        lambda value: not (value < 0 or value != value),
        ": must be a whole number, greater than or equal to 0",
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
        value = json.loads(text) if kind is list and isinstance(text, str) else kind(text)
    except ValueError:
        what = {int: "a whole number", list: "a list"}.get(kind, "a number")
        sys.exit(f"ERROR: {name} = {text}: must be {what}")
    if name in ALLOWED and not ALLOWED[name][0](value):
        sys.exit(f"ERROR: {name} = {text}{ALLOWED[name][1]}")
    return value


def runs():
    """Return the parameters of each run: of a JSON file (a list of them), or of NAME=VALUE."""
    batch, named = [{}], {}
    for word in sys.argv[1:]:
        name, equals, value = word.partition("=")
        if equals:
            named[name] = value
        else:
            batch = json.loads(Path(word).read_text(encoding="utf-8"))
    return [checked({**one, **named}) for one in batch]


def checked(given):
    """Return all parameters, those given in the place of the defaults."""
    values = {name: value_of(name, value) for name, value in given.items()}
    return SimpleNamespace(**{**PARAMETERS, **values})


class Results:
    """The lines "RESULT name = value": printed, and written to a file when the run is over."""

    def __init__(self, path):
        self.path, self.lines = path, []

    def add(self, name, *values):
        """Print a line and keep it; the last one of a run is its verdict."""
        words = [f"{value:.17g}" if isinstance(value, float) else str(value) for value in values]
        self.lines.append(f"RESULT {name} = {' '.join(words)}")
        print(self.lines[-1], flush=True)
        if self.path and name == "verdict":
            Path(self.path).write_text("\n".join(self.lines) + "\n", encoding="utf-8")


class Series:
    """A CSV of numbers with 17 digits, written when the run is over; nothing without a name."""

    def __init__(self, path, columns):
        self.path, self.lines = path, [",".join(columns)]

    def add(self, *values):
        """Add a row."""
        if self.path:
            self.lines.append(",".join(f"{value:.17g}" for value in values))

    def write(self):
        """Write the file."""
        if self.path:
            Path(self.path).write_text("\n".join(self.lines) + "\n", encoding="utf-8")


def columns(p, force):
    """Return the columns of a series; ``force`` names that of the forces."""
    if not p.forces:
        return ["time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s"]
    count = len(p.x) - (force == "contact_force_N")
    numbers = [f"[{i}]" for i in range(1, len(p.x) + 1)]
    named = [name + number for name in ("x_m", "vx_m_per_s") for number in numbers]
    return ["time_s", *named, *(force + number for number in numbers[:count])]


class Watch:
    """What becomes of the first sphere: a line "stage" of its start, and where each stage ends."""

    def __init__(self, p, results):
        self.p, self.results, self.stage = p, results, 0
        self.steps, self.over = p.steps, False
        unit = math.sqrt(p.mass / p.stiffness)
        zeta = p.damping / 2 / math.sqrt(p.stiffness * p.mass)
        # in a well the motion normal to the row feels 3/2 of the spring and of the dashpot
        longest = 2 * (math.sqrt(zeta * zeta + 2 / 3) - zeta) * unit
        if p.period and p.step > longest * (1 + 1e-12):
            sys.exit(f"ERROR: step = {p.step} s: must be less than {longest:.6g} at these values")
        if p.places:
            self.tell(0, p.x[0], p.y[0], p.vx[0], p.vy[0])

    def tell(self, steps, *state):
        """Write where the sphere is."""
        self.results.add("stage", steps, steps * self.p.step, *map(float, state))

    def look(self, steps, *state):
        """Return whether the run is over.

        Dissipation only lowers the energy: a sphere that turns back with less than the floor
        never passes.
        """
        p, (x, _, vx, _) = self.p, state
        if not all(map(math.isfinite, state)):
            self.steps, self.over = steps, True
            return True
        passes = x > p.places[self.stage]
        stops = not passes and vx < 0 and self.energy(*state) < p.floors[self.stage]
        self.stage += passes
        self.over = stops or self.stage == len(p.places) or steps >= p.steps
        self.steps = steps if self.over else p.steps
        if passes or self.over:
            self.tell(steps, *state)
        return self.over

    def energy(self, x, y, vx, vy):
        """Return motion, height above the centre of a sphere of the row at x = 0, and springs."""
        p, d = self.p, self.p.diameter
        behind = p.x[1] + d * math.floor((x - p.x[1]) / d)
        overlaps = [d - math.hypot(x - behind - away, y - p.y[1]) for away in (0, d)]
        springs = sum(0.5 * p.stiffness * max(overlap, 0) ** 2 for overlap in overlaps)
        motion = 0.5 * p.mass * (vx * vx + vy * vy)
        return motion - p.mass * (p.gravity_x * x + p.gravity_y * y) + springs

    def finish(self, started, *state):
        """Write what ends every run; ``started`` is a time of time.perf_counter."""
        self.results.add("mass_kg", self.p.mass)
        self.results.add("step_s", self.p.step)
        self.results.add("steps", self.steps)
        self.results.add("seconds", time.perf_counter() - started)
        sound = all(map(math.isfinite, state))
        self.results.add("verdict", "finished" if sound else "not_a_number")


LAW = "DEM_D_Linear_viscous_Coulomb"


def run(p):
    """Let the spheres move until the run is over."""
    began = time.perf_counter()
    watch = Watch(p, Results(p.results))
    series = Series(p.series if p.every else "", columns(p, "contacts_fx_N"))
    spheres = Spheres(p)
    every, forces = p.every or p.steps + 1, variable("CONTACT_FORCES_X")
    # Symplectic_Euler takes the forces where a step begins: those of a row are known one step
    # later. Velocity_Verlet takes them where it ends.
    late = int(bool(p.forces) and p.scheme != "Velocity_Verlet")
    count, ahead, over = 0, 0, False
    while True:
        here = spheres.first(put_back=count > 0)
        if count % every == 0 and p.forces:
            states = [spheres.state(node) for node in spheres.nodes]
            spheres.advance(late)
            ahead, found = late, [node.GetSolutionStepValue(forces) for node in spheres.nodes]
            series.add(count * p.step, *(s[0] for s in states), *(s[2] for s in states), *found)
        elif count % every == 0:
            series.add(count * p.step, *here)
        if p.places and count and (count % LOOK == 0 or count == p.steps):
            over = watch.look(count, *here)
        if over or count == p.steps:
            break
        steps = min(LOOK - count % LOOK, every - count % every, p.steps - count)
        spheres.advance(steps - ahead)
        count, ahead = count + steps, 0
    series.write()
    watch.finish(began, *here)


class Spheres:
    """Equal spheres without friction, some of them fixed: set up in Kratos without files.

    An endless row has four spheres: it looks the same from every well. A sphere that left the two
    in the middle is put back by a diameter.
    """

    def __init__(self, p):
        self.p, self.behind = p, 0.0
        centres, self.fixed = list(zip(p.x, p.y)), p.fixed
        if p.period:
            centres = [centres[0], *((p.x[1] + i * p.diameter, p.y[1]) for i in (-1, 0, 1, 2))]
            self.fixed = [0, 1, 1, 1, 1]
        self.reach = p.search_tolerance * p.diameter
        self.model = Kratos.Model()
        parts = parts_of(self.model, NODAL)
        self.part = parts[0]
        material = self._material()
        self.nodes = [self._sphere(i, x, y, material) for i, (x, y) in enumerate(centres, 1)]
        self._free()
        self.mobile = [node for node, fixed in zip(self.nodes, self.fixed) if not fixed]
        self.searched = [(node.X, node.Y) for node in self.mobile]
        self.until_search, self.steps_planned = 0, 1
        self._inform()
        self.strategy = strategy_of(parts, p.scheme, p.step, self.reach, walls=False)
        for node, vx, vy, fixed in zip(self.nodes, p.vx, p.vy, self.fixed):
            if not fixed:
                node.SetSolutionStepValue(VELOCITY_X, 0, vx)
                node.SetSolutionStepValue(VELOCITY_Y, 0, vy)
        self.strategy.Initialize()  # Kratos's first look

    def advance(self, steps):
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

    def _plan_search(self):
        """Decide after how many steps the next search but this one comes.

        What a search finds is right until a pair that it left out has closed in by the
        tolerance. The steps to the next one shall take an eighth of that, and half of it
        is refused.
        """
        now = [self.state(node) for node in self.mobile]
        fastest = max(math.hypot(vx, vy) for _, _, vx, vy in now)
        if not math.isfinite(fastest):
            sys.exit("a velocity is not a number")
        for (x, y, _, _), (x0, y0) in zip(now, self.searched):
            if self.steps_planned > 1 and math.hypot(x - x0, y - y0) > 0.5 * self.reach:
                sys.exit("a sphere moved by half the search tolerance between two searches")
        self.searched = [(x, y) for x, y, _, _ in now]
        affordable = 0.125 * self.reach
        count = self.p.search_every
        if fastest * self.p.step * count > affordable:
            count = max(1, int(affordable / (fastest * self.p.step)))
        self.until_search = self.steps_planned = count

    def first(self, put_back):
        """Return the state of the first sphere, and put it back into the middle of a row if asked.

        Contacts are searched for again before the next forces.
        """
        node, d = self.mobile[0], self.p.diameter
        x, *others = self.state(node)
        here = (x + self.behind, *others)
        way = d * math.floor((node.X - self.p.x[1]) / d) if self.p.period else 0.0
        if put_back and way:
            node.X0 -= way
            node.X -= way
            self.searched = [(x - way, y) for x, y in self.searched]
            self.until_search = 0
            self.behind += way
        return here

    def state(self, node):
        """Return position [m] and velocity [m/s] of a sphere."""
        value = node.GetSolutionStepValue
        return node.X, node.Y, value(VELOCITY_X), value(VELOCITY_Y)

    def _material(self):
        """Return the material whose contact with itself has stiffness and damping as asked for.

        The law's stiffness is 1.432 pi 0.31225 E* R*, with E* = E / 2 for Poisson's ratio
        0 and R* = d / 4; its dashpot 2 gamma sqrt(k m / 2), also against a fixed sphere.
        Set by itself, gamma does not go through Kratos's table of restitutions.
        """
        p, material = self.p, self.part.CreateNewProperties(1)
        young = 8.0 * p.stiffness / (1.432 * math.pi * 0.31225 * p.diameter)
        material[variable("YOUNG_MODULUS")] = young
        material[variable("POISSON_RATIO")] = 0.0
        material[variable("PARTICLE_DENSITY")] = p.mass * 6.0 / math.pi / p.diameter**3
        contact = Kratos.Properties(1)
        for name in ("STATIC_FRICTION", "DYNAMIC_FRICTION", "FRICTION_DECAY", "ROLLING_FRICTION"):
            contact[variable(name)] = 0.0
        contact[variable("COEFFICIENT_OF_RESTITUTION")] = 0.0
        gamma = p.damping / (2.0 * math.sqrt(p.stiffness * p.mass / 2.0))
        contact[variable("DAMPING_GAMMA")] = gamma
        getattr(DEM, LAW)().SetConstitutiveLawInProperties(contact, False)
        material.AddSubProperties(contact)
        integrate(material, p.scheme)
        return material

    def _free(self):
        """Let mobile spheres move in the plane, and the others not at all."""
        for axis in "XYZ":
            Kratos.VariableUtils().AddDof(variable(f"VELOCITY_{axis}"), self.part)
            Kratos.VariableUtils().AddDof(variable(f"ANGULAR_VELOCITY_{axis}"), self.part)
        for fixed, node in zip(self.fixed, self.nodes):
            for axis in "XYZ" if fixed else "Z":
                node.Fix(variable(f"VELOCITY_{axis}"))

    def _inform(self):
        """Give Kratos step, gravity and the tolerances of its contact search.

        Its first search alone goes by the tolerance for spheres: every later one goes by
        the tolerance against walls, also where there is no wall.
        """
        p, info = self.p, self.part.ProcessInfo
        info[variable("GRAVITY")] = Kratos.Array3([p.gravity_x, p.gravity_y, 0.0])
        info[variable("DELTA_TIME")] = p.step
        info[variable("NODAL_MASS_COEFF")] = 1.0
        info[variable("SEARCH_CONTROL")] = 1
        info[variable("SEARCH_RADIUS_INCREMENT")] = self.reach
        against_walls = p.search_tolerance_against_walls * p.diameter
        info[variable("SEARCH_RADIUS_INCREMENT_FOR_WALLS")] = against_walls

    def _sphere(self, number, x, y, material):
        """Return the node of a new sphere."""
        node = self.part.CreateNewNode(number, x, y, 0.0)
        self.part.CreateNewElement("SphericParticle3D", number, [number], material)
        node.SetSolutionStepValue(variable("RADIUS"), 0, 0.5 * self.p.diameter)
        return node


def variable(name):
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
    "do_search_fem_neighbours": %s, "RemoveBallsInitiallyTouchingWalls": false,
    "model_import_settings": {}, "material_import_settings": {}
}"""


def parts_of(model, nodal):
    """Return the parts of a new model; its spheres have the variables of these names."""
    names = ("SpheresPart", "ContactPart", "RigidFacePart", "DEMInletPart", "ClusterPart")
    parts = [model.CreateModelPart(name) for name in names]
    for name in nodal:
        parts[0].AddNodalSolutionStepVariable(variable(name))
    return parts


def integrate(material, scheme):
    """Let spheres of a material move by a scheme, without a damping of their motion."""
    made = getattr(DEM, scheme.replace("_", "") + "Scheme")()
    made.SetTranslationalIntegrationSchemeInProperties(material, False)
    made.SetRotationalIntegrationSchemeInProperties(material, False)
    DEM.DEMGlobalDampingNonViscousCstForceDir().SetGlobalDampingModelInProperties(material, False)


def strategy_of(parts, scheme, step, reach, walls):
    """Return Kratos's strategy for the parts of a model, which finds contacts within a reach."""
    settings = DEM.ExplicitSolverSettings()
    settings.r_model_part, settings.contact_model_part = parts[:2]
    settings.fem_model_part, settings.inlet_model_part = parts[2:4]
    settings.cluster_model_part = parts[4]
    verlet = scheme == "Velocity_Verlet"
    kind = DEM.IterativeSolverStrategy if verlet else DEM.ExplicitSolverStrategy
    # the third number: every step with TIME_STEPS above 0 searches, none with 0
    strategy = kind(
        settings, step, 1, 1.0, 1, DEM.ParticleCreatorDestructor(), DEM.DEM_FEM_Search(),
        DEM.OMP_DEMSearch(), Kratos.Parameters(STRATEGY % ("true" if walls else "false")),
    )  # fmt: skip
    strategy.RebuildListOfDiscontinuumSphericParticles()
    strategy.SetNormalRadiiOnAllParticlesBeforeInitilization(parts[0])
    strategy.SetSearchRadiiOnAllParticles(parts[0], reach, 1.0)
    return strategy


def main():
    """Run what the command line names."""
    if "OMP_NUM_THREADS" not in os.environ:  # of a few spheres more threads only wait
        Kratos.ParallelUtilities.SetNumThreads(1)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    for p in runs():
        run(p)


if __name__ == "__main__":
    main()
