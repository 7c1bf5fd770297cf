"""Equal spheres in the plane without friction, in Yade: the scene of the case drop.

Made by dem-harness 1.0.0 (`dem-harness inputs --engine yade` writes it again).

Run it as it stands, with other parameters, or for a list of them in a JSON file:

    yade -n -x drop.py
    yade -n -x drop.py stiffness=1e7 steps=1000 vx=[1,0]
    yade -n -x drop.py runs.json

It writes the motion to a file and ends with lines "RESULT name = value". Yade's contacts always
clip the tail: they never attract. SI units. Written for Yade 2023.02a.

Yade's velocities stand half a step behind its places. Where forces are sampled, this script
starts them there and moves what it writes to the time of the places, both by half a step of the
acceleration: so is the error of second order in the step.
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
    # spheres, the first of them mobile: places [m], velocities [m/s], 1 for one that is fixed
    "x": [0.0, 0.0],
    "y": [1.001, 0.0],
    "vx": [0.0, 0.0],
    "vy": [-1.0, 0.0],
    "fixed": [0, 1],
    "mass": 1.0,  # of each, kg
    "diameter": 1.0,  # of each, m
    "period": 0.0,  # of the endless row that the fixed ones are of, m; 0: there is no row
    "gravity_x": 0.0,  # m/s2
    "gravity_y": -0.0,
    "stiffness": 1000000.0,  # k, N/m
    "damping": 430.9075239324936,  # of each contact, eta, N s/m
    "step": 1.5707963267948967e-06,  # s
    "steps": 6000,  # of the run at most
    # the run ends when the first sphere, looked at every 50 steps, is beyond the last of
    # these x [m], or moves back before the next one with less energy [J] than its floor
    "places": [],
    "floors": [],
    "every": 1,  # steps between samples; 0: none
    "forces": 0,  # 1: all spheres and their forces along x are sampled, 0: the first
    "series": "drop.csv",  # file for the samples
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


class Motion:
    """One run: spheres in Yade, looked at until the motion is over."""

    def __init__(self, p):
        self.p = p
        self.series = Series(p.series if p.every else "", columns(p, "contact_force_N"))
        self.watch = Watch(p, Results(p.results))
        O.reset()
        O.dt = p.step
        if p.period:
            O.periodic = True  # places run on over the boundary
            O.cell.setBox(p.period, 1000 * p.diameter, 1000 * p.diameter)
        # Yade puts the two materials of a contact in series: each has twice the contact's values
        material = ViscElMat(
            kn=2 * p.stiffness, cn=2 * p.damping, ks=0.0, cs=0.0, frictionAngle=0.0
        )
        O.materials.append(material)
        self.spheres = [self.sphere(i, material) for i in range(len(p.x))]
        O.engines = self.engines()

    def sphere(self, i, material):
        """Add a sphere and return its body. Fixed spheres do not search for each other."""
        p, fixed = self.p, bool(self.p.fixed[i])
        place, mask = (p.x[i], p.y[i], 0), 3 if fixed else 1
        body = utils.sphere(place, p.diameter / 2, material=material, fixed=fixed, mask=mask)
        body.state.mass = p.mass
        body.state.vel = (p.vx[i], p.vy[i], 0)
        O.bodies.append(body)
        return body

    def engines(self):
        """Return the engines of a step.

        The leapfrog moves v, which stands half a step behind x, and then x: with the force
        at (x, v) this is the semi-implicit Euler scheme. Newton's own damping is off.
        """
        p, before, between = self.p, [], []
        if p.every:
            before = [PyRunner(iterPeriod=p.every, command="motion.record()", initRun=True)]
        if p.forces:  # before the motion: places and forces are those of the same time
            set_back = PyRunner(nDo=1, iterPeriod=1, command="motion.set_back()", initRun=True)
            before, between = [], [set_back, *before]
        if p.places:
            before = [*before, PyRunner(iterPeriod=LOOK, command="motion.look()")]
        collider = InsertionSortCollider(
            [Bo1_Sphere_Aabb()], verletDist=0.1 * p.diameter, avoidSelfInteractionMask=2
        )
        contacts = InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom()],
            [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
            [Law2_ScGeom_ViscElPhys_Basic()],
        )
        newton = NewtonIntegrator(damping=0, gravity=(p.gravity_x, p.gravity_y, 0))
        return [*before, ForceResetter(), collider, contacts, *between, newton]

    def run(self):
        """Run until the watch ends it; forces of the last sample are those of one step more."""
        p, started = self.p, time.perf_counter()
        O.run(p.steps + p.forces, wait=True)
        if not p.forces and not self.watch.over:
            if p.every and O.iter % p.every == 0:
                self.record()
            self.look()
        self.series.write()
        self.watch.finish(started, *self.now())

    def now(self):
        """Return place and velocity of the first sphere, in Yade's own numbers."""
        place, velocity = self.spheres[0].state.pos, self.spheres[0].state.vel
        return place[0], place[1], velocity[0], velocity[1]

    def look(self):
        """Pause where the run is over."""
        if self.p.places and self.watch.look(O.iter, *self.now()):
            O.pause()

    def record(self):
        """Write a row: of the first sphere, or places, velocities and forces of all."""
        if not self.p.forces:
            return self.series.add(O.iter * self.p.step, *self.now())
        places = [body.state.pos[0] for body in self.spheres]
        velocities = [b.state.vel[0] + kick for b, kick in zip(self.spheres, self.kicks())]
        forces = [self.force(i) for i in range(len(places) - 1)]
        return self.series.add(O.iter * self.p.step, *places, *velocities, *forces)

    def kicks(self):
        """Return half a step of each sphere's acceleration along x, by Yade's own forces."""
        p, ids = self.p, [body.id for body in self.spheres]
        return [
            0.0 if fixed else p.step / 2 * (O.forces.f(i)[0] / p.mass + p.gravity_x)
            for i, fixed in zip(ids, p.fixed)
        ]

    def set_back(self):
        """Move the velocities of the start to where Yade has them, half a step before."""
        for body, kick in zip(self.spheres, self.kicks()):
            body.state.vel = (body.state.vel[0] - kick, 0, 0)

    def force(self, i):
        """Return the force of contact i + 1 as Yade has it, 0 where there is none."""
        first, second = self.spheres[i].id, self.spheres[i + 1].id
        if not O.interactions.has(first, second, onlyReal=True):
            return 0.0
        return O.interactions[first, second].phys.normalForce.norm()


# Yade makes a folder below /tmp at its start and does not remove it
Path(O.tmpFilename()).parent.rmdir()
for parameters in runs():
    motion = Motion(parameters)
    motion.run()
