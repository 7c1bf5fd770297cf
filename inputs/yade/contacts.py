"""A contact with friction: one or two spheres and horizontal walls, moved by forces or as told.

Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template).

Run it as it stands (an oblique impact on a wall), with other parameters, or for a list of them in
a JSON file:

    yade -n -x contacts.py
    yade -n -x contacts.py friction=0.1 damping=none
    yade -n -x contacts.py runs.json

A linear contact is stated by Law2_ScGeom_ViscElPhys_Basic, with resistance to rolling or twisting
by Law2_ScGeom6D_CohFrictPhys_CohesionMoment without cohesion, one from a material by
Law2_ScGeom_MindlinPhys_Mindlin. It writes position, velocity, angular velocity, force and torque
of each sphere to a CSV and ends with lines "RESULT name = value". SI units. Written for Yade
2023.02a.
"""

import json
import math
import sys
import time
from pathlib import Path
from types import SimpleNamespace

from yade import (
    Bo1_Box_Aabb,
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    CohFrictMat,
    ForceResetter,
    FrictMat,
    Ig2_Box_Sphere_ScGeom6D,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom6D,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_CohFrictMat_CohFrictMat_CohFrictPhys,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom6D_CohFrictPhys_CohesionMoment,
    Law2_ScGeom_MindlinPhys_Mindlin,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    Vector3,
    ViscElMat,
    utils,
)

PARAMETERS = {
    # normal and damping: hooke with none, velocity, mass_velocity or coeff_restitution; hertz with
    # none or coeff_restitution; dmt with none. With a dashpot the tail is clipped always.
    "normal": "hooke",
    "normal_stiffness": 1000000.0,  # N/m, of hooke
    "youngs_modulus": 0.0,  # Pa, of hertz and dmt, as the next
    "poisson_ratio": 0.0,
    "surface_energy": 0.0,  # J/m2, of dmt
    "damping": "velocity",
    "damping_coefficient": 10.0,  # kg/s, of velocity; 1/s, of mass_velocity
    "restitution": 0.0,  # of coeff_restitution
    "clipped": "yes",
    "tangential": "linear_history",  # none, linear_history (hooke) or mindlin/force
    "tangential_stiffness": 285714.28571428574,  # N/m, of linear_history
    "tangential_damping": 0.0,  # over the normal one
    "friction": 0.3,
    # none, or sds, without a dashpot: beside hertz, or hooke without damping; with walls, one sphere
    "rolling": "none",
    "rolling_stiffness": 0.0,  # N/m
    "rolling_friction": 0.0,
    "twisting": "none",  # none, or sds beside hooke, likewise
    "twisting_stiffness": 0.0,  # N m
    "twisting_friction": 0.0,  # m
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
    "step_size": 1e-07,  # s
    "steps": 4000,  # of the run
    "series": "contacts.csv",  # file for the samples
    "series_every": 40,  # steps between them
    "results": "",  # file for the lines RESULT, beside the screen
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
}


ALLOWED = {}


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


COLUMNS = "x_m y_m z_m vx_m_per_s vy_m_per_s vz_m_per_s wx_rad_per_s wy_rad_per_s wz_rad_per_s"
COLUMNS += " fx_N fy_N fz_N tx_N_m ty_N_m tz_N_m"


def vector(p, names, place):
    """Return three parameters as a vector."""
    return Vector3(*(getattr(p, f"{name}_{place}") for name in names.split()))


def damping_ratio(p):
    """Return zeta of the restitution of a linear contact."""
    logarithm = -math.log(p.restitution)
    return logarithm / math.hypot(math.pi, logarithm)


class Plain:
    """Geometry of laws that turn nothing: spheres and walls."""

    def wall(self, height, side, material):  # noqa: ARG002
        """Return a horizontal wall."""
        return utils.wall(height, axis=2, material=material)

    def geometry(self):
        """Return the boxes that bodies are looked for in, and how they meet."""
        shapes = [
            Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False),
            Ig2_Wall_Sphere_ScGeom(hertzian=True, noRatch=False),
        ]
        return [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], shapes


class Linear(Plain):
    """Law2_ScGeom_ViscElPhys_Basic: a spring and a dashpot along and across."""

    def __init__(self, p, masses, pair):
        self.p, self.masses, self.pair = p, masses, pair

    def dashpot(self, mass):
        """Return eta_n [kg/s] of a contact with an effective mass."""
        eta = {"none": 0.0, "velocity": 1.0, "mass_velocity": mass}.get(self.p.damping)
        if eta is None:
            return 2 * damping_ratio(self.p) * math.sqrt(self.p.normal_stiffness * mass)
        return eta * self.p.damping_coefficient

    def materials(self):
        """Return the materials of spheres and of the walls below the first and above the last.

        Yade puts those of a contact in series, and leaves out a dashpot of 0.
        """
        etas = [self.dashpot(mass) for mass in self.masses]
        own = [2 * eta for eta in etas]
        if len(etas) > 1:
            own = [2 * self.dashpot(self.pair)] * 2
            if self.p.damping == "mass_velocity" and self.p.planes:
                own = etas
        walls = [0.0 if a == b else 1 / (1 / b - 1 / a) for a, b in zip(own, etas)]
        return [self.material(eta) for eta in own], [self.material(walls[i]) for i in (0, -1)]

    def material(self, eta):
        """Return a material with its share of the coefficients of contacts."""
        p, history = self.p, self.p.tangential != "none"
        return ViscElMat(
            kn=2 * p.normal_stiffness,
            cn=eta,
            ks=2 * p.tangential_stiffness * history,
            cs=p.tangential_damping * eta,
            frictionAngle=math.atan(p.friction),
        )

    def functors(self):
        """Return what makes the contact from two materials, and its law."""
        return [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]


class Turning:
    """Law2_ScGeom6D_CohFrictPhys_CohesionMoment: springs also of rolling and twisting, and limits.

    A wall is a box: Yade has no other that turns, but facets, and gives it the sphere's radius.
    """

    WIDE = 1e8
    """Radii that a box reaches to each side."""

    def __init__(self, p):
        self.p, self.radii = p, [p.radius_1, p.radius_2][: p.bodies]
        # R*, and the product of the radii that Yade has in the stiffnesses
        self.reduced = p.radius_1
        if p.bodies > 1:
            self.reduced = p.radius_1 * p.radius_2 / (p.radius_1 + p.radius_2)
        self.product = self.radii[0] * self.radii[-1]

    def materials(self):
        """Return the materials of spheres and of the walls below the first and above the last."""
        own = [self.material(radius) for radius in self.radii]
        return own, [own[0], own[-1]]

    def material(self, radius):
        """Return the material of a body: Yade takes the harmonic mean of k_n, k_t / k_n and alpha.

        k_n is young times the radius, the stiffness of rolling or twisting alpha k_t r_1 r_2; the
        torques are at most the smaller eta times radius, times the normal force.
        """
        p = self.p
        own = p.tangential_stiffness * self.product
        rolls, twists = p.rolling != "none", p.twisting != "none"
        return CohFrictMat(
            young=p.normal_stiffness / radius,
            poisson=p.tangential_stiffness / p.normal_stiffness,
            frictionAngle=math.atan(p.friction),
            alphaKr=rolls * p.rolling_stiffness * self.reduced**2 / own,
            etaRoll=rolls * p.rolling_friction * self.reduced / radius,
            alphaKtw=twists * p.twisting_stiffness / own,
            etaTwist=twists * p.twisting_friction / radius,
            momentRotationLaw=True,
        )

    def wall(self, height, side, material):
        """Return a box with a face at a height, whose body lies on a side: -1 below, 1 above."""
        deep, wide = self.p.radius_1, self.WIDE * self.p.radius_1
        place = Vector3(0, 0, height + side * deep)
        return utils.box(place, (wide, wide, deep), material=material, fixed=True)

    def geometry(self):
        """Return the boxes that bodies are looked for in, and how they meet."""
        shapes = [
            Ig2_Sphere_Sphere_ScGeom6D(avoidGranularRatcheting=False),
            Ig2_Box_Sphere_ScGeom6D(),
        ]
        return [Bo1_Sphere_Aabb(), Bo1_Box_Aabb()], shapes

    def functors(self):
        """Return what makes the contact from two materials, and its law.

        Only by increments do the springs forget what the limits cut back.
        """
        law = Law2_ScGeom6D_CohFrictPhys_CohesionMoment(
            always_use_moment_law=True, useIncrementalForm=True
        )
        return [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys()], [law]


class Solid(Plain):
    """Law2_ScGeom_MindlinPhys_Mindlin: Hertz and Mindlin from the material, and rolling."""

    FAR = 1e8
    """Radii by which the radius of a wall exceeds a sphere's, with hertzian=True."""

    def __init__(self, p):
        self.p = p

    def materials(self):
        """Return the materials of the spheres and of the walls: one and the same."""
        p = self.p
        one = FrictMat(
            young=p.youngs_modulus, poisson=p.poisson_ratio, frictionAngle=math.atan(p.friction)
        )
        return [one] * p.bodies, [one] * 2

    def functors(self):
        """Return what makes the contact from two materials, and its law.

        betan is the share of critical damping with the tangent stiffness: sqrt(5/6) of the damping
        ratio of a linear contact gives the same restitution at every speed.
        """
        p = self.p
        told = {"gamma": p.surface_energy}
        if p.damping != "none":
            told["betan"] = math.sqrt(5 / 6) * damping_ratio(p)
            alike = math.sqrt(2 * (1 - p.poisson_ratio) / (2 - p.poisson_ratio))
            told["betas"] = told["betan"] * p.tangential_damping / alike
        if p.rolling != "none":
            second = p.radius_2 if p.bodies > 1 else self.FAR * p.radius_1
            reduced = p.radius_1 * second / (p.radius_1 + second)
            told["krot"] = p.rolling_stiffness * reduced**2
            told["eta"] = p.rolling_friction * reduced / (0.5 * (p.radius_1 + second))
        law = Law2_ScGeom_MindlinPhys_Mindlin(
            includeAdhesion=p.normal == "dmt", includeMoment=p.rolling != "none"
        )
        return [Ip2_FrictMat_FrictMat_MindlinPhys(**told)], [law]


class Contact:
    """One run.

    A step computes the forces at x, v standing half a step behind, then moves v and x. Samples
    are taken between: v is brought to the time of x by half a step of the force.
    """

    def __init__(self, p):
        self.p, self.results = p, Results(p.results)
        places = range(1, p.bodies + 1)
        names = [f"{name}[{i}]" for name in COLUMNS.split() for i in places]
        self.series = Series(p.series, ["step", *names])
        O.reset()
        O.dt = p.step_size
        self.gravity = Vector3(p.gravity_x, p.gravity_y, p.gravity_z)
        masses = [getattr(p, f"mass_{i}") for i in places]
        pair = masses[0]
        if p.bodies > 1 and p.motion_2 != "frozen":
            pair = masses[0] * masses[1] / (masses[0] + masses[1])
        if p.normal in ("hertz", "dmt"):
            law = Solid(p)
        elif p.rolling != "none" or p.twisting != "none":
            law = Turning(p)
        else:
            law = Linear(p, masses, pair)
        spheres, walls = law.materials()
        self.spheres = [self.sphere(i, spheres[i - 1]) for i in places]
        planes = zip((p.floor, p.ceiling), (-1, 1), walls)
        for height, side, material in list(planes)[: p.planes]:
            O.bodies.append(law.wall(height, side, material))
        self.changes = self.segments()
        O.engines = self.engines(*law.geometry(), *law.functors())

    def sphere(self, place, material):
        """Add a sphere and return its body; it starts to move after the first sample."""
        p = self.p
        held = getattr(p, f"motion_{place}") != "free"
        radius, mass = getattr(p, f"radius_{place}"), getattr(p, f"mass_{place}")
        body = utils.sphere(vector(p, "x y z", place), radius, material=material, fixed=held)
        body.state.mass = mass
        body.state.inertia = Vector3(1, 1, 1) * 0.4 * mass * radius**2
        O.bodies.append(body)
        return body

    def engines(self, bounds, shapes, makers, laws):
        """Return the engines of a step; velocities at the contact are those of its point."""
        boxes = InsertionSortCollider(bounds, verletDist=0.1 * self.p.radius_1)
        every = 1 if self.changes else self.p.series_every
        look = PyRunner(iterPeriod=every, command="contact.look()", initRun=True)
        newton = NewtonIntegrator(damping=0, gravity=self.gravity)
        return [ForceResetter(), boxes, InteractionLoop(shapes, makers, laws), look, newton]

    def segments(self):
        """Return the velocities of sphere 1 by the step at which it takes them."""
        p, changes, begin = self.p, {}, 0
        for j in range(1, p.segments + 1):
            steps = getattr(p, f"steps_in_{j}")
            if steps:
                changes[begin] = vector(p, "vx vy vz", f"in_{j}"), vector(p, "wx wy wz", f"in_{j}")
            begin += steps
        return changes

    def look(self):
        """Take a sample where one is due, and set velocities that change."""
        first = O.iter == 0
        if first:
            for place, body in enumerate(self.spheres, 1):
                body.state.vel = vector(self.p, "vx vy vz", place)
                body.state.angVel = vector(self.p, "wx wy wz", place)
        if O.iter % self.p.series_every == 0:
            self.record(first)
        if first:
            for body in self.spheres:
                linear, angular = self.half_step(body)
                body.state.vel -= linear
                body.state.angVel -= angular
        if O.iter in self.changes:
            self.spheres[0].state.vel, self.spheres[0].state.angVel = self.changes[O.iter]

    def half_step(self, body):
        """Return what half a step of the forces adds to both velocities."""
        if not body.dynamic:
            return Vector3(0, 0, 0), Vector3(0, 0, 0)
        half = 0.5 * self.p.step_size
        force, torque = O.forces.f(body.id, True), O.forces.t(body.id, True)
        linear = force / body.state.mass + self.gravity
        return half * linear, half * torque / body.state.inertia[0]

    def record(self, first):
        """Write a row of the spheres."""
        rows = []
        for body in self.spheres:
            linear, angular = self.half_step(body)
            late = 0 if first else 1
            velocity, spin = body.state.vel + late * linear, body.state.angVel + late * angular
            force, torque = O.forces.f(body.id, True), O.forces.t(body.id, True)
            rows.append([*body.state.pos, *velocity, *spin, *force, *torque])
        self.series.add(O.iter, *(row[i] for i in range(len(rows[0])) for row in rows))

    def run(self):
        """Run all steps, and the forces of one more: the last sample."""
        started = time.perf_counter()
        O.run(self.p.steps + 1, wait=True)
        self.series.write()
        self.results.add("seconds", time.perf_counter() - started)
        self.results.add("steps", self.p.steps)
        self.results.add("verdict", "finished")


# Yade makes a folder below /tmp at its start and does not remove it
Path(O.tmpFilename()).parent.rmdir()
for parameters in runs():
    contact = Contact(parameters)
    contact.run()
