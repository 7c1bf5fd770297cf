# Equal spheres in the plane without friction, in ESyS-Particle: the scene of the case drop.
#
# Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template, not this file).
#
# Run it as it stands, or with other parameters, on one master and one worker:
#
#     mpirun -np 2 esysparticle drop.py
#     mpirun -np 2 esysparticle drop.py stiffness=1e7 steps=1000 vx=[1,0]
#
#     mpirun -np 2 esysparticle drop.py runs.json
#
# It writes the motion to a file and ends with lines "RESULT name = value". The runs of a file (a
# list of parameters) go side by side in one model: they may differ in the first sphere's start.
# SI units. For ESyS-Particle 2.3.
#
# A contact with a dashpot is Hertz's, never attractive: K (delta^1.5 + A sqrt(delta) d(delta)/dt);
# with K = 0 it is a linear spring.
#
# ESyS-Particle moves by v+ = v + h a(x), x+ = x + h v+: leap-frog, whose velocities belong half
# a step before the positions. Where forces are sampled they start so (v - h a / 2), and so they
# are read, a force being what changes the velocity.

import json
import math
import sys
import time
import traceback
from pathlib import Path
from types import SimpleNamespace

from esys.lsm import GravityPrms, HertzianViscoElasticPrms, LsmMpi, NRotElasticPrms, NRotSphere
from esys.lsm.util import BoundingBox, Vec3

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
    "coefficient": 39528470.752104744,  # of the force K (delta^1.5 + A sqrt(delta) d(delta)/dt)
    "relaxation": 0.0003447260191459949,  # A, s
    "stiffness": 1000000.0,  # k of the linear spring that it stands for, N/m
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
        zeta = p.relaxation / 1.6 / unit
        # the motion feels 3/2 of the dashpot in a well, and of the spring, at its stiffest 15/8 k
        longest = 16 / 15 * (math.sqrt(zeta * zeta + 5 / 4) - zeta) * unit
        if p.coefficient and p.step > longest * (1 + 1e-12):
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
        springs = sum(0.4 * p.coefficient * max(overlap, 0) ** 2.5 for overlap in overlaps)
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


FIXED, MOBILE = 1, 2


class Model:
    """Runs side by side in one model, each in a row of its own along x."""

    def __init__(self, runs):
        self.p, self.runs = runs[0], runs
        p, d, count = self.p, self.p.diameter, len(runs)
        self.last = 0
        if p.period:
            # a row without an end: as many spheres as the grain may come to
            self.last = math.ceil(p.places[-1] / d) + 2 if p.places else len(p.x)
            low = (-4.0 * d, -4.0 * d, -4.0 * d)
            high = ((self.last + 3) * d, (self.last + 4) * d, (3 * count + 1) * d)
        else:
            low, high = self.reach()
        self.sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
        # cells as wide as this at least, and no more of them along a long box than memory bears
        cell = max(2.5 * d, max(b - a for a, b in zip(low, high)) / 200.0)
        self.sim.initNeighbourSearch(
            particleType="NRotSphere", gridSpacing=cell, verletDist=0.2 * d
        )
        self.sim.setSpatialDomain(BoundingBox(Vec3(*low), Vec3(*high)))
        self.sim.setTimeStepSize(p.step)
        self.sim.setNumTimeSteps(p.steps + p.forces)
        self.started = []
        self.build()
        self.sim.setParticleNonDynamic(FIXED)  # a tag, not the number of a particle
        self.sim.createInteractionGroup(self.contact())
        pull = Vec3(p.gravity_x, p.gravity_y, 0.0)
        self.sim.createInteractionGroup(GravityPrms(name="weight", acceleration=pull))

    def reach(self):
        """Return the corners of a box that the spheres cannot leave."""
        p, d = self.p, self.p.diameter
        time = (p.steps + p.forces) * p.step
        speed = max(math.hypot(*v) for v in zip(p.vx, p.vy))
        pull = math.hypot(p.gravity_x, p.gravity_y)
        far = (speed + pull * time) * time + 4.0 * d
        across = 2.0 * d if p.forces else far
        low, high = (min(p.x) - far, min(p.y) - across), (max(p.x) + far, max(p.y) + across)
        return (*low, -2.0 * d), (*high, 3.0 * d * len(self.runs) - d)

    def build(self):
        """Put all spheres into the model, the first ones of the runs first."""
        p, count = self.p, len(self.runs)
        if p.period:
            places = [(p.x[1] + i * p.diameter, p.y[1]) for i in range(-2, self.last + 1)]
            others = [(x, y, 0.0, 0.0, FIXED) for x, y in places]
        else:
            tags = [FIXED if fixed else MOBILE for fixed in p.fixed]
            others = list(zip(p.x, p.y, p.vx, p.vy, tags))[1:]
        for number, run in enumerate(self.runs):
            self.add(number, number, run.x[0], run.y[0], run.vx[0], run.vy[0], MOBILE)
            for i, other in enumerate(others):
                self.add(number, count + number * len(others) + i, *other)

    def add(self, number, key, x, y, vx, vy, tag):
        """Put a sphere into the row of a run; those of tag FIXED stay where they are."""
        p = self.p
        place = Vec3(x, y, 3.0 * number * p.diameter)
        sphere = NRotSphere(id=key, posn=place, radius=0.5 * p.diameter, mass=p.mass)
        sphere.setTag(tag)
        if p.forces and tag == MOBILE:
            vx -= 0.5 * p.step * self.acceleration(key)
        self.started.append(vx)
        sphere.setLinearVelocity(Vec3(vx, vy, 0.0))
        self.sim.createParticle(sphere)

    def acceleration(self, i):
        """Return the acceleration of sphere i in a line at the start, 0 in balance."""
        p, d = self.p, self.p.diameter
        overlaps = [d - (b - a) for a, b in zip(p.x, p.x[1:])]
        before, after = (overlaps[j] if 0 <= j < len(overlaps) else 0.0 for j in (i - 1, i))
        found = p.stiffness / p.mass * (max(before, 0.0) - max(after, 0.0)) + p.gravity_x
        # what is left of a balance is the rounding of places
        rounding = 16 * sys.float_info.epsilon * max(map(abs, p.x)) * p.stiffness / p.mass
        return found if abs(found) > rounding else 0.0

    def contact(self):
        """Return ESyS's contact, 2 E sqrt(R) / 3 / (1 - nu^2) for K, with R = d/4 and nu = 0."""
        p = self.p
        if not p.coefficient:
            return NRotElasticPrms(name="contact", normalK=p.stiffness, scaling=False)
        modulus = 3.0 * p.coefficient / math.sqrt(p.diameter)
        return HertzianViscoElasticPrms(name="contact", A=p.relaxation, E=modulus, nu=0.0)

    def states(self, keys):
        """Return x, y, vx, vy of spheres.

        Not their forces: `getForce` of such a copy of a particle crashes.
        """
        found = sorted(self.sim.getParticleList(keys), key=lambda sphere: sphere.getId())
        moves = [(sphere.getPosn(), sphere.getLinearVelocity()) for sphere in found]
        return [(x[0], x[1], v[0], v[1]) for x, v in moves]


def together(runs):
    """Run side by side until all are over."""
    began, p = time.perf_counter(), runs[0]
    watches = [Watch(one, Results(one.results)) for one in runs]
    tables = [Series(one.series if p.every else "", columns(one, "fx_N")) for one in runs]
    model = Model(runs)
    now = whole_line(model, tables[0]) if p.forces else first_spheres(model, watches, tables)
    model.sim.exit()
    share = (time.perf_counter() - began) / len(runs)
    for watch, table, state in zip(watches, tables, now):
        table.write()
        watch.finish(time.perf_counter() - share, *state)


def first_spheres(model, watches, tables):
    """Move until every first sphere is over, and return where they are."""
    p, every = model.p, model.p.every or model.p.steps + 1
    keys, now = list(range(len(watches))), [(r.x[0], r.y[0], r.vx[0], r.vy[0]) for r in model.runs]
    for count in range(p.steps + 1):
        if count:  # ESyS-Particle crashes when it is asked before the first step
            model.sim.runTimeStep()
        sampled, looked = count % every == 0, p.places and count and count % LOOK == 0
        if not (sampled or looked or count == p.steps):
            continue
        now = model.states(keys) if count else now
        for watch, table, state in zip(watches, tables, now):
            if sampled and not watch.over:
                table.add(count * p.step, *state)
            if p.places and count and (looked or count == p.steps) and not watch.over:
                watch.look(count, *state)
        if all(watch.over for watch in watches):
            break
    return now


def whole_line(model, table):
    """Move all spheres of a line over all steps and one, and return where they are."""
    p, keys = model.p, list(range(len(model.p.x)))
    before = list(zip(p.x, p.y, model.started, p.vy))
    for count in range(1, p.steps + 2):
        model.sim.runTimeStep()
        sampled, due = (count - 1) % p.every == 0, count % p.every == 0
        if not (sampled or due):
            continue
        after = model.states(keys)
        if sampled:
            changes = [(one[2], then[2]) for one, then in zip(before, after)]
            middle = [0.5 * (v + then) for v, then in changes]
            forces = [p.mass * (then - v) / p.step for v, then in changes]
            table.add((count - 1) * p.step, *(one[0] for one in before), *middle, *forces)
        before = after
    return before


if __name__ == "__main__":
    try:
        together(runs())
    except Exception:
        # left to itself ESyS-Particle would wait for its workers for ever
        traceback.print_exc()
        sys.exit(1)
