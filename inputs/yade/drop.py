"""A grain that meets one fixed sphere: what a DEM code is qualified with.

Made by dem-harness 0.1.0 (`dem-harness inputs` writes it again; edit the template).

Run it as it stands (a head-on collision), with other parameters, or for a list of them in a
JSON file:

    yade -n -x drop.py
    yade -n -x drop.py gravity=9.81 speed=0 gap=0.1
    yade -n -x drop.py mode=young-en restitution=1e-20
    yade -n -x drop.py runs.json

The sphere's centre is the origin; the grain starts above it and moves down. It ends with lines
"RESULT name = value". SI units. Written for Yade 2023.02a.
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
    "stiffness": 1000000.0,  # normal stiffness k, N/m
    "steps_per_contact": 2000.0,  # steps per contact time pi sqrt(m/k)
    "gravity": 0.0,  # m/s2, downward
    "diameter": 1.0,  # of both spheres, m
    "density": 1.909859317102744,  # of the grain, kg/m3; this one: 1 kg at 1 m
    "gap": 0.001,  # between grain and sphere at the start, m
    "speed": 1.0,  # downward, at the start, m/s
    "sideways": 0.0,  # along x, at the start, m/s
    # eta = 2 zeta sqrt(k m_eff), with zeta from the restitution (e = 0: critical damping) or
    # given, as "damping" says
    "damping": "restitution",  # restitution or ratio
    "restitution": 0.5,
    "damping_ratio": 1.0,
    "effective_mass": "full",  # against a fixed sphere: full (m) or half (m/2)
    # who makes the coefficients of the contact. Only the first is what the parameters say:
    #   coefficients  this script: k and eta
    #   tc-en         Yade, from a contact time and the restitution, as if the tail attracted,
    #                 and with m/2 against a fixed sphere
    #   young-en      Yade, from a modulus and the restitution, with m/2; for a restitution close
    #                 to 0 its search fails, and it leaves the dashpot out with a warning
    "mode": "coefficients",
    "newton_damping": 0.0,  # of the forces, by NewtonIntegrator, whose own default is 0.2
    "steps": 6000,  # of the run
    "series": "drop.csv",  # file for the grain's motion
    "series_every": 1,  # steps between its rows
    "results": "",  # file for the lines RESULT, beside the screen
}


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


def dashpot(p, mass):
    """Return eta = 2 zeta sqrt(k m_eff) [N s/m]: the force is k overlap - eta * separation speed.

    Stated, never left to Yade.
    """
    zeta = p.damping_ratio
    if p.damping == "restitution":
        zeta = 1.0
        if p.restitution > 0:
            logarithm = -math.log(p.restitution)
            zeta = logarithm / math.hypot(math.pi, logarithm)
    effective = mass / 2 if p.effective_mass == "half" else mass
    return 2 * zeta * math.sqrt(p.stiffness * effective)


def material(p, mass):
    """Return the material of both spheres, by the mode."""
    if p.mode == "coefficients":
        return stated(p.stiffness, dashpot(p, mass))
    logarithm = -math.log(p.restitution)
    of_time = {"tc": math.sqrt(mass / p.stiffness) * math.hypot(math.pi, logarithm)}
    of_modulus = {"young": 2 * p.stiffness / p.diameter, "poisson": 0.3}
    told = {"tc-en": of_time, "young-en": of_modulus}[p.mode]
    made = ViscElMat(**told, en=p.restitution, et=1.0, frictionAngle=0.0)
    return O.materials[O.materials.append(made)]


class Motion:
    """One run of a given number of steps."""

    def __init__(self, p):
        self.p, self.results = p, Results(p.results)
        self.series = Series(p.series, ["time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s"])
        mass = p.density * math.pi / 6 * p.diameter**3
        self.step = math.pi * math.sqrt(mass / p.stiffness) / p.steps_per_contact
        start_over(self.step)
        both = material(p, mass)
        sphere((0, 0, 0), p.diameter, mass, both, fixed=True)
        self.grain = sphere((0, p.diameter + p.gap, 0), p.diameter, mass, both).state
        self.grain.vel = (p.sideways, -p.speed, 0)
        record = PyRunner(iterPeriod=p.series_every, command="motion.record()", initRun=True)
        O.engines = engines(p.diameter, (0, -p.gravity, 0), before=[record])
        O.engines[-1].damping = p.newton_damping

    def record(self):
        """Write a row of the path."""
        place, velocity = self.grain.pos, self.grain.vel
        self.series.add(O.iter * self.step, place[0], place[1], velocity[0], velocity[1])

    def run(self):
        """Run all steps."""
        started = time.perf_counter()
        O.run(self.p.steps, wait=True)
        if O.iter % self.p.series_every == 0:
            self.record()
        self.series.write()
        self.results.add("seconds", time.perf_counter() - started)
        self.results.add("step_s", self.step)
        self.results.add("steps", O.iter)
        velocity = self.grain.vel
        self.results.add("final_velocity_m_per_s", velocity[0], velocity[1])
        self.results.add("verdict", "finished")


leave_nothing()
for parameters in runs():
    motion = Motion(parameters)
    motion.run()
