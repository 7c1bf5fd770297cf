"""A contact with friction: one or two spheres and horizontal walls, moved by forces or as told.

Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template,
not this file).

Run it as it stands, or with other parameters, with a Python that has Kratos
(pip install KratosMultiphysics KratosDEMApplication):

    python contacts.py
    python contacts.py friction=0.1
    python contacts.py FILE              a list of them in JSON

A linear contact is stated by DEM_D_Linear_viscous_Coulomb, where k_t is at least 4/3 k_n by
DEM_D_Linear_Custom_Constants, one from a material by DEM_D_Hertz_viscous_Coulomb, with attraction
by DEM_D_Hertz_viscous_Coulomb_DMT; a wall is a rigid face. It writes position, velocity, angular
velocity, force and torque of each sphere.
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
    # hooke with none, velocity, mass_velocity or coeff_restitution; hertz with none or
    # coeff_restitution; with a dashpot the tail is clipped always, and there is no friction;
    # dmt with neither
    "normal": "hooke",
    "normal_stiffness": 1000000.0,  # N/m, of hooke
    "youngs_modulus": 0.0,  # Pa, of hertz and dmt, as the next
    "poisson_ratio": 0.0,
    "surface_energy": 0.0,  # J/m2, of dmt: gamma of each surface
    "damping": "none",
    "damping_coefficient": 10.0,  # kg/s, of velocity; 1/s, of mass_velocity
    "restitution": 0.0,  # of coeff_restitution
    "clipped": "yes",
    "tangential": "linear_history",  # none, linear_history (hooke) or mindlin_rescale/force
    "tangential_stiffness": 285714.28571428574,  # N/m, of linear_history
    "friction": 0.3,
    # spheres; a prescribed one moves as it is told
    "bodies": 1,
    "motion_1": "free",  # free, frozen or prescribed
    "radius_1": 0.01,  # m
    "mass_1": 0.01,  # kg
    "x_1": 0.0,
    "y_1": 0.0,
    "z_1": 0.01,
    "vx_1": 0.7071067811865476,
    "vy_1": 0.0,
    "vz_1": -0.7071067811865476,
    "wx_1": 0.0,
    "wy_1": 0.0,
    "wz_1": 0.0,
    "motion_2": "free",  # free, frozen or prescribed
    "radius_2": 0.01,  # m
    "mass_2": 0.01,  # kg
    "x_2": 0.0,
    "y_2": 0.0,
    "z_2": 0.0,
    "vx_2": 0.0,
    "vy_2": 0.0,
    "vz_2": 0.0,
    "wx_2": 0.0,
    "wy_2": 0.0,
    "wz_2": 0.0,
    "planes": 1,  # 0, 1 (a floor at the height z), 2 (and a ceiling)
    "floor": 0.0,  # m
    "ceiling": 0.0,
    "gravity_x": 0.0,  # m/s2
    "gravity_y": 0.0,
    "gravity_z": 0.0,
    "room": 0.0816,  # half the width of a wall, m
    "step_size": 1e-07,  # s
    "steps": 4000,  # of the run
    "series_every": 40,  # steps between two rows
    # a prescribed sphere 1 changes its velocity after so many steps, again and again
    "segments": 0,
    "steps_in_1": 0,
    "vx_in_1": 0.0,
    "vy_in_1": 0.0,
    "vz_in_1": 0.0,
    "wx_in_1": 0.0,
    "wy_in_1": 0.0,
    "wz_in_1": 0.0,
    "steps_in_2": 0,
    "vx_in_2": 0.0,
    "vy_in_2": 0.0,
    "vz_in_2": 0.0,
    "wx_in_2": 0.0,
    "wy_in_2": 0.0,
    "wz_in_2": 0.0,
    "steps_in_3": 0,
    "vx_in_3": 0.0,
    "vy_in_3": 0.0,
    "vz_in_3": 0.0,
    "wx_in_3": 0.0,
    "wy_in_3": 0.0,
    "wz_in_3": 0.0,
    "steps_in_4": 0,
    "vx_in_4": 0.0,
    "vy_in_4": 0.0,
    "vz_in_4": 0.0,
    "wx_in_4": 0.0,
    "wy_in_4": 0.0,
    "wz_in_4": 0.0,
    "steps_in_5": 0,
    "vx_in_5": 0.0,
    "vy_in_5": 0.0,
    "vz_in_5": 0.0,
    "wx_in_5": 0.0,
    "wy_in_5": 0.0,
    "wz_in_5": 0.0,
    "steps_in_6": 0,
    "vx_in_6": 0.0,
    "vy_in_6": 0.0,
    "vz_in_6": 0.0,
    "wx_in_6": 0.0,
    "wy_in_6": 0.0,
    "wz_in_6": 0.0,
    "scheme": "Velocity_Verlet",  # or Symplectic_Euler
    "series": "contacts.csv",  # file for the motion; empty: none
    "results": "",  # file for the RESULT lines; empty: they are printed only
}
WALLS = (11, 12)  # numbers of the materials of floor and ceiling
COLUMNS = "x_m y_m z_m vx_m_per_s vy_m_per_s vz_m_per_s wx_rad_per_s wy_rad_per_s wz_rad_per_s"
COLUMNS += " fx_N fy_N fz_N tx_N_m ty_N_m tz_N_m"


def vector(p, names: str, place):
    """Return three parameters."""
    return [float(getattr(p, f"{name}_{place}")) for name in names.split()]


def damping_ratio(p):
    """Return zeta of the restitution of a linear contact without clipping."""
    logarithm = -math.log(p.restitution)
    return logarithm / math.hypot(math.pi, logarithm)


class Contact:
    """One run: its spheres, walls and materials in Kratos."""

    def __init__(self, p):
        self.p, self.places = p, range(1, p.bodies + 1)
        self.masses = [getattr(p, f"mass_{i}") for i in self.places]
        self.radii = [getattr(p, f"radius_{i}") for i in self.places]
        self.hertz = p.normal in ("hertz", "dmt")
        # 2 (1 - nu) / (2 - nu) is k_t / k_n of both laws of a material
        self.poisson = p.poisson_ratio
        self.custom = False
        if not self.hertz:
            ratio = p.tangential_stiffness / p.normal_stiffness if p.tangential != "none" else 1.0
            self.custom = ratio >= 4.0 / 3.0
            if self.custom:
                ratio = 1.0  # of a material that is not asked for its stiffness
            self.poisson = (2.0 - 2.0 * ratio) / (2.0 - ratio)
        self.model = Kratos.Model()
        self.parts = parts_of(self.model, (*NODAL, *TURNING))
        for name in FACES:
            self.parts[2].AddNodalSolutionStepVariable(variable(name))
        self.nodes = [self.sphere(i) for i in self.places]
        for number, height in list(enumerate((p.floor, p.ceiling)))[: p.planes]:
            self.wall(number, height)
        self.strategy = self.start()

    def young(self):
        """Return the modulus of the spheres [Pa].

        The linear law's stiffness is 1.432 pi 0.31225 E* R* between spheres, pi 0.31225 E* r at a
        wall.
        """
        p = self.p
        if self.hertz:
            return float(p.youngs_modulus)
        reduced = 2.0 * (1.0 - self.poisson**2) * p.normal_stiffness / (math.pi * 0.31225)
        if p.bodies == 1:
            return reduced / self.radii[0]
        return reduced * (1.0 / self.radii[0] + 1.0 / self.radii[1]) / 1.432

    def wall_young(self, radius):
        """Return the modulus of a wall [Pa] that gives a sphere the same stiffness on it."""
        if self.hertz:
            return float(self.p.youngs_modulus)
        both = (1.0 - self.poisson**2) * self.p.normal_stiffness / (math.pi * 0.31225 * radius)
        return 1.0 / (1.0 / both - 1.0 / self.young())

    def gamma(self, mass, own):
        """Return Kratos's gamma of a contact: its dashpot is 2 gamma sqrt(own * stiffness).

        ``mass`` is the effective mass of the law, ``own`` that of Kratos, in which a fixed sphere
        counts. Hertz's stiffness is the tangent, 3/2 of force over overlap.
        """
        p = self.p
        if p.damping == "none":
            return 0.0
        if self.hertz:
            return math.sqrt(5.0 / 6.0 * mass / own) * damping_ratio(p)
        if p.damping == "coeff_restitution":
            return math.sqrt(mass / own) * damping_ratio(p)
        eta = p.damping_coefficient * (mass if p.damping == "mass_velocity" else 1.0)
        return float(eta / 2.0 / math.sqrt(own * p.normal_stiffness))

    def material(self, number, young):
        """Return a new material."""
        made = self.parts[0].CreateNewProperties(number)
        made[variable("YOUNG_MODULUS")] = young
        made[variable("POISSON_RATIO")] = self.poisson
        return made

    def contact(self, number, gamma):
        """Return the contact with the material of a number."""
        made = Kratos.Properties(number)
        friction = self.p.friction if self.p.tangential != "none" else 0.0
        made[variable("STATIC_FRICTION")] = made[variable("DYNAMIC_FRICTION")] = friction
        for name in ("FRICTION_DECAY", "ROLLING_FRICTION", "COEFFICIENT_OF_RESTITUTION"):
            made[variable(name)] = 0.0
        made[variable("DAMPING_GAMMA")] = gamma
        law = "DEM_D_Hertz_viscous_Coulomb" if self.hertz else "DEM_D_Linear_viscous_Coulomb"
        if self.p.normal == "dmt":  # of both surfaces: F = 2 pi PARTICLE_COHESION R*
            law += "_DMT"
            made[variable("PARTICLE_COHESION")] = 2.0 * self.p.surface_energy
        if self.custom:  # a material in which k_t is that much larger there is none
            law = "DEM_D_Linear_Custom_Constants"
            made[variable("K_NORMAL")] = self.p.normal_stiffness
            made[variable("K_TANGENTIAL")] = self.p.tangential_stiffness
        getattr(DEM, law)().SetConstitutiveLawInProperties(made, False)
        return made

    def sphere(self, i):
        """Return the node of a new sphere, with a material of its own."""
        p, mass, radius = self.p, self.masses[i - 1], self.radii[i - 1]
        material = self.material(i, self.young())
        material[variable("PARTICLE_DENSITY")] = mass * 0.75 / math.pi / radius**3
        if p.bodies == 2:
            other = self.masses[2 - i]
            own = mass * other / (mass + other)
            told = self.masses[0] if p.motion_2 == "frozen" else own
            material.AddSubProperties(self.contact(3 - i, self.gamma(told, own)))
        for number in WALLS[: p.planes]:
            material.AddSubProperties(self.contact(number, self.gamma(mass, mass)))
        integrate(material, p.scheme)
        node = self.parts[0].CreateNewNode(i, *vector(p, "x y z", i))
        self.parts[0].CreateNewElement("SphericParticle3D", i, [i], material)
        node.SetSolutionStepValue(variable("RADIUS"), 0, radius)
        return node

    def wall(self, number, height):
        """Add a horizontal wall: a face of four corners."""
        part, far = self.parts[2], self.p.room
        radius = self.radii[min(number, self.p.bodies - 1)]
        material = self.material(WALLS[number], self.wall_young(radius))
        material[variable("COMPUTE_WEAR")] = False
        first = 1000 * (number + 1)
        corners = [(-far, -far), (far, -far), (far, far), (-far, far)]
        for place, (x, y) in enumerate(corners):
            part.CreateNewNode(first + place, x, y, height)
        part.CreateNewCondition("RigidFace3D4N", first, [first + i for i in range(4)], material)

    def start(self):
        """Return Kratos's strategy after its first look at the spheres."""
        p = self.p
        for axis in "XYZ":
            for name in (f"VELOCITY_{axis}", f"ANGULAR_VELOCITY_{axis}"):
                Kratos.VariableUtils().AddDof(variable(name), self.parts[0])
                for i, node in zip(self.places, self.nodes):
                    if getattr(p, f"motion_{i}") != "free":
                        node.Fix(variable(name))
        info = self.parts[0].ProcessInfo
        info[variable("GRAVITY")] = Kratos.Array3(self.gravity)
        info[variable("DELTA_TIME")] = p.step_size
        info[variable("NODAL_MASS_COEFF")] = 1.0
        info[variable("ROTATION_OPTION")] = 1
        info[variable("SEARCH_CONTROL")] = 1
        # a search that finds all there is needs no other
        info[variable("SEARCH_RADIUS_INCREMENT")] = p.room
        info[variable("SEARCH_RADIUS_INCREMENT_FOR_WALLS")] = p.room
        strategy = strategy_of(self.parts, p.scheme, p.step_size, p.room, walls=True)
        for i, node in zip(self.places, self.nodes):
            self.move(node, vector(p, "vx vy vz", i), vector(p, "wx wy wz", i))
        strategy.Initialize()
        return strategy

    def move(self, node, velocity, spin):
        """Give a sphere its velocities."""
        for axis, v, w in zip("XYZ", velocity, spin):
            node.SetSolutionStepValue(variable(f"VELOCITY_{axis}"), 0, v)
            node.SetSolutionStepValue(variable(f"ANGULAR_VELOCITY_{axis}"), 0, w)

    def row(self, step):
        """Return step, places, velocities, forces and torques of the contacts."""
        states = []
        for mass, node in zip(self.masses, self.nodes):
            value = node.GetSolutionStepValue
            force = [
                value(variable(f"TOTAL_FORCES_{axis}")) - mass * g
                for axis, g in zip("XYZ", self.gravity)
            ]
            moment = [value(variable(f"PARTICLE_MOMENT_{axis}")) for axis in "XYZ"]
            moved = [value(variable(f"{n}_{axis}")) for n in MOVED for axis in "XYZ"]
            states.append([node.X, node.Y, node.Z, *moved, *force, *moment])
        return [step, *(state[i] for i in range(len(states[0])) for state in states)]

    @property
    def gravity(self):
        """Return gravity [m/s2]."""
        return [self.p.gravity_x, self.p.gravity_y, self.p.gravity_z]

    def run(self):
        """Return the rows of all samples."""
        p, info, changes, begin = self.p, self.parts[0].ProcessInfo, {}, 0
        for j in range(1, p.segments + 1):
            changes[begin] = j
            begin += getattr(p, f"steps_in_{j}")
        rows = [self.row(0)]
        info[TIME_STEPS] = 1
        for step in range(p.steps):
            if step in changes:
                j = f"in_{changes[step]}"
                self.move(self.nodes[0], vector(p, "vx vy vz", j), vector(p, "wx wy wz", j))
            self.strategy.SolveSolutionStep()
            info[TIME_STEPS] = 0
            if (step + 1) % p.series_every == 0:
                rows.append(self.row(step + 1))
        return rows


MOVED = ("VELOCITY", "ANGULAR_VELOCITY")


def run(p):
    """Run the contact and write its samples."""
    began, results = time.perf_counter(), Results(p.results)
    names = [f"{name}[{i}]" for name in COLUMNS.split() for i in range(1, p.bodies + 1)]
    series = Series(p.series, ["step", *names])
    for row in Contact(p).run():
        series.add(*row)
    series.write()
    results.add("seconds", time.perf_counter() - began)
    results.add("steps", p.steps)
    results.add("verdict", "finished")


# of spheres that turn
TURNING = (
    "PARTICLE_MOMENT_OF_INERTIA", "ROLLING_RESISTANCE_MOMENT", "ROLLING_FRICTION",
    "LOCAL_AUX_ANGULAR_VELOCITY", "AUX_ORIENTATION",
)  # fmt: skip
# all that Kratos's rigid faces read or write
FACES = (
    "ELASTIC_FORCES", "DEM_PRESSURE", "TANGENTIAL_ELASTIC_FORCES", "SHEAR_STRESS",
    "DEM_NODAL_AREA", "CONTACT_FORCES", "TOTAL_FORCES", "VELOCITY", "DELTA_DISPLACEMENT",
    "DISPLACEMENT", "NON_DIMENSIONAL_VOLUME_WEAR", "IMPACT_WEAR", "ANGULAR_VELOCITY",
)  # fmt: skip


ALLOWED = {
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
