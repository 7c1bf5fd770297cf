"""The tower: a grain runs into a row of equal spheres at rest.

Made by dem-harness 0.1.0 (`dem-harness inputs` writes it again; edit the template).

Run it as it stands, with other parameters, or for a list of them in a JSON file:

    yade -n -x tower.py
    yade -n -x tower.py height=19 stiffness=1e7 speed=4 series=tower.csv
    yade -n -x tower.py runs.json

The grain is particle 1; the motion is along x, and so is gravity; particle height + 1 is the
base. Contacts are springs without damping, their force the overlap law's. It ends with lines
"RESULT name = value". SI units. Written for Yade 2023.02a.

Yade's velocities stand half a step behind its places. This script starts them there and moves
what it writes to the time of the places, both by half a step of the acceleration: so is the
error of second order in the step.
"""

import json
import math
import sys
import time
from pathlib import Path
from types import SimpleNamespace

from yade import (
    Bo1_Sphere_Aabb,
    ForceResetter,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    ViscElMat,
    utils,
)

PARAMETERS = {
    "height": 2,  # contacts of the tower, particles less one
    "stiffness": 1000000.0,  # normal stiffness k, N/m
    "mass": 1.0,  # of each particle, kg
    "diameter": 1.0,  # m
    "speed": 2.0,  # of the grain at the start, m/s
    "gravity": 9.81,  # along the motion, m/s2; 0 is the air hockey table
    "base": "fixed",  # the last particle: fixed or free
    "start": "touching",  # touching, preloaded (by the weight above) or gapped
    "gap": 0.0,  # at every contact of a gapped start, m
    "duration": 3.0,  # in t0, the contact of the grain with one fixed particle
    "steps_per_contact": 1000.2100823896989,  # steps per pi sqrt(m/k)
    "series": "tower.csv",  # file for the motion of all particles and the force of all contacts
    "series_every": 1,  # steps between its rows
    "results": "",  # file for the lines RESULT, beside the screen
}


ALLOWED = {
    "height": (
        lambda value: not (value < 1 or value > 10000000 or value != value),
        ": must be a whole number, greater than or equal to 1 and less than or equal to 10000000",
    ),
    "stiffness": (
        lambda value: not (value <= 0 or value != value),
        " N/m: must be greater than 0",
    ),
    "mass": (
        lambda value: not (value <= 0 or value != value),
        " kg: must be greater than 0",
    ),
    "diameter": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "speed": (
        lambda value: not (value < 0 or value != value),
        " m/s: must be greater than or equal to 0",
    ),
    "gravity": (
        lambda value: not (value < 0 or value != value),
        " m/s2: must be greater than or equal to 0",
    ),
    "base": (
        lambda value: value in ["fixed", "free"],
        ": must be one of fixed, free",
    ),
    "start": (
        lambda value: value in ["touching", "preloaded", "gapped"],
        ": must be one of touching, preloaded, gapped",
    ),
    "gap": (
        lambda value: not (value < 0 or value != value),
        " m: must be greater than or equal to 0",
    ),
    "duration": (
        lambda value: not (value <= 0 or value != value),
        " t0: must be greater than 0",
    ),
    "steps_per_contact": (
        lambda value: not (value <= 3.141592653589793 or value != value),
        ": must be greater than 3.14159265359",
    ),
    "series_every": (
        lambda value: not (value < 1 or value != value),
        ": must be a whole number, greater than or equal to 1",
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
        sys.exit(f"ERROR: {name} = {text}: must be a {'whole ' if kind is int else ''}number")
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


def leave_nothing():
    """Remove the folder below /tmp that Yade makes at its start and does not remove."""
    Path(O.tmpFilename()).parent.rmdir()


def start_over(step):
    """Empty Yade's scene, with a step [s] for the next."""
    O.reset()
    O.dt = step


def sphere(place, diameter, mass, material, *, fixed=False):
    """Add a sphere and return its body. Fixed spheres do not search for each other."""
    body = utils.sphere(place, diameter / 2, material=material, fixed=fixed, mask=3 if fixed else 1)
    body.state.mass = mass
    O.bodies.append(body)
    return body


def engines(diameter, gravity, *, before=(), between=()):
    """Return the engines of a step, with others before the forces, and before the motion.

    The leapfrog moves v, which stands half a step behind x, and then x: with the force
    at (x, v) this is the semi-implicit Euler scheme. Newton's own damping is off.
    """
    collider = InsertionSortCollider(
        [Bo1_Sphere_Aabb()], verletDist=0.1 * diameter, avoidSelfInteractionMask=2
    )
    contacts = InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()],
        [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
        [Law2_ScGeom_ViscElPhys_Basic()],
    )
    newton = NewtonIntegrator(damping=0, gravity=gravity)
    return [*before, ForceResetter(), collider, contacts, *between, newton]


def stated(stiffness, eta):
    """Return a frictionless material of which two make a contact with k and eta.

    Yade puts the two materials of a contact in series: each has twice the contact's values.
    """
    return O.materials[
        O.materials.append(
            ViscElMat(kn=2 * stiffness, cn=2 * eta, ks=0.0, cs=0.0, frictionAngle=0.0)
        )
    ]


class Motion:
    """One run of a given number of steps."""

    def __init__(self, p):
        self.p, self.results = p, Results(p.results)
        numbers = range(1, p.height + 2)
        columns = [f"x_m[{i}]" for i in numbers] + [f"vx_m_per_s[{i}]" for i in numbers]
        columns += [f"contact_force_N[{i}]" for i in numbers[:-1]]
        self.series = Series(p.series, ["time_s", *columns])
        omega = math.sqrt(p.stiffness / p.mass)
        self.t0 = 2 / omega * (math.pi - math.atan2(p.speed * omega, p.gravity))
        self.step = math.pi / omega / p.steps_per_contact
        self.steps = round(p.duration * self.t0 / self.step)
        self.build()

    def build(self):
        """Set up the row and the engines."""
        p = self.p
        start_over(self.step)
        material = stated(p.stiffness, 0.0)
        self.particles = [
            sphere(
                (self.place(i), 0, 0),
                p.diameter,
                p.mass,
                material,
                fixed=p.base == "fixed" and i == p.height,
            )
            for i in range(p.height + 1)
        ]
        self.particles[0].state.vel = (p.speed, 0, 0)
        # before the motion: places and forces are those of the same time
        observe = [
            PyRunner(nDo=1, iterPeriod=1, command="motion.set_back()", initRun=True),
            PyRunner(iterPeriod=p.series_every, command="motion.record()", initRun=True),
        ]
        O.engines = engines(p.diameter, (p.gravity, 0, 0), between=observe)

    def place(self, i):
        """Return where particle i + 1 starts.

        Contact i of a preloaded tower carries the i particles above it: it is pressed by their
        weight over k, and the sum of these down to particle i + 1 is i (i - 1) / 2.
        """
        p = self.p
        if p.start == "preloaded":
            return i * p.diameter - p.mass * p.gravity / p.stiffness * (i * (i - 1) / 2)
        return i * (p.diameter + (p.gap if p.start == "gapped" else 0))

    def kicks(self):
        """Return half a step of each particle's acceleration, by Yade's own forces."""
        p = self.p
        mobile = [particle.dynamic for particle in self.particles]
        forces = [O.forces.f(particle.id)[0] for particle in self.particles]
        return [
            self.step / 2 * (force / p.mass + p.gravity) if moves else 0.0
            for force, moves in zip(forces, mobile, strict=True)
        ]

    def set_back(self):
        """Move the velocities of the start to where Yade has them, half a step before."""
        for particle, kick in zip(self.particles, self.kicks(), strict=True):
            particle.state.vel = (particle.state.vel[0] - kick, 0, 0)

    def record(self):
        """Write a row: places, velocities and contact forces of one time."""
        places = [particle.state.pos[0] for particle in self.particles]
        self.velocities = [
            particle.state.vel[0] + kick
            for particle, kick in zip(self.particles, self.kicks(), strict=True)
        ]
        forces = [self.force(i) for i in range(self.p.height)]
        self.series.add(O.iter * self.step, *places, *self.velocities, *forces)

    def force(self, i):
        """Return the force of contact i + 1 as Yade has it, 0 where there is none."""
        first, second = self.particles[i].id, self.particles[i + 1].id
        if not O.interactions.has(first, second, onlyReal=True):
            return 0.0
        return O.interactions[first, second].phys.normalForce.norm()

    def run(self):
        """Run all steps; the last row is taken in the step after them."""
        p, add = self.p, self.results.add
        started = time.perf_counter()
        O.run(self.steps + 1, wait=True)
        self.series.write()
        add("seconds", time.perf_counter() - started)
        add("contact_time_s", self.t0)
        add("step_s", self.step)
        add("steps", self.steps)
        add("final_velocity_m_per_s", self.velocities[0])
        left = p.mass * (p.speed - self.velocities[0])
        add("impulse_Ns", left + p.mass * p.gravity * self.steps * self.step)
        add("verdict", "finished")


leave_nothing()
for parameters in runs():
    motion = Motion(parameters)
    motion.run()
