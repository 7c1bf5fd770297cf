# The frictionless incline: a grain slides over a row of fixed, touching spheres.
#
# Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template, not this file).
#
# Run it as it stands, or with other parameters, on one master and one worker:
#
#     mpirun -np 2 esysparticle incline.py
#     mpirun -np 2 esysparticle incline.py angle=10.5 stiffness=1e7 phases=0,0.5
#
# It ends with lines "RESULT name = value". The verdict is one of
#     moves_on    the grain passes the crests (all of them: motion persists)
#     trapped     it turned back in a well, with less energy than the crest asks for
#     undecided   the time limit came first: this is not "trapped"
#
# Theory (no rebound, rigid): motion persists from 10.2078 deg on.
# SI units; angles in degrees. For ESyS-Particle 2.3.
#
# The contact is Hertz's, never attractive: K (delta^1.5 + A sqrt(delta) d(delta)/dt), K and A from
# the stiffness k and the damping ratio of the linear contact it stands for.
#
# route=passage  start behind a crest with just the energy of that crest, pass one well, and report
#                the energy left over the next crest: its sign is the verdict, its root in the
#                angle the critical angle
# route=steady   start in a well, fast enough to leave it, and pass well after well
# phases         shifts of the start of the passage, in steps (0 to 1), with commas: a row
#                each, side by side; one row is watched in the steady route
# series         file for the motion, a row every `series_every` steps: time, then
#                x, y, vx, vy of each row's grain, to the step at which all are decided

import math
import sys
import traceback

from esys.lsm import GravityPrms, HertzianViscoElasticPrms, LsmMpi, NRotSphere
from esys.lsm.util import BoundingBox, Vec3

PARAMETERS = {
    "route": "passage",
    "angle": 10.2,
    "stiffness": 1000000.0,
    "steps_per_contact": 100.0,
    "gravity": 9.81,
    "diameter": 1.0,
    "density": 1.909859317102744,
    "wells": 10,
    "time_limit": 400.0,
    "damping": "ratio",
    "restitution": 0.0,
    "damping_ratio": 5.0,
    "effective_mass": "full",
    "phases": "0",
    "series_every": 50,
    "speed": 0.48,
    "start": 10.0,
    "series": "grain.csv",
}
FIXED, GRAIN = 1, 2


ALLOWED = {
    "angle": (
        lambda value: not (value < 0 or value > 30 or value != value),
        " deg: must be greater than or equal to 0 and less than or equal to 30",
    ),
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
        lambda value: not (value <= 0 or value != value),
        " m/s2: must be greater than 0",
    ),
    "wells": (
        lambda value: not (value < 1 or value > 10000 or value != value),
        ": must be a whole number, greater than or equal to 1 and less than or equal to 10000",
    ),
    "time_limit": (
        lambda value: not (value <= 0 or value != value),
        ": must be greater than 0",
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
    "route": (
        lambda value: value in ["passage", "steady"],
        ": must be one of passage, steady",
    ),
    "speed": (
        lambda value: not (value <= 0 or value > 10 or value != value),
        " sqrt(g d): must be greater than 0 and less than or equal to 10",
    ),
    "start": (
        lambda value: not (value <= 0 or value > 30 or value != value),
        " deg: must be greater than 0 and less than or equal to 30",
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
        what = {int: "a whole number", list: "a list"}.get(kind, "a number")
        sys.exit(f"ERROR: {name} = {text}: must be {what}")
    if name in ALLOWED and not ALLOWED[name][0](value):
        sys.exit(f"ERROR: {name} = {text}{ALLOWED[name][1]}")
    return value


def parameters(words):
    """Return the parameters, with what the command line says of them."""
    values = dict(PARAMETERS)
    for word in words:
        name, _, text = word.partition("=")
        values[name] = value_of(name, text)
    return values


def result(name, value):
    """Print a result, numbers with all their digits."""
    print(f"RESULT {name} = {value if isinstance(value, (str, int)) else format(value, '.17g')}")


def damping_ratio(p):
    """Return zeta, stated or from the restitution (e = 0: critical damping)."""
    if p["damping"] == "ratio":
        return p["damping_ratio"]
    if p["restitution"] == 0.0:
        return 1.0
    return -math.log(p["restitution"]) / math.hypot(math.pi, math.log(p["restitution"]))


def hertz(p, m, speed):
    """Return K and A of the force K (delta^1.5 + A sqrt(delta) d(delta)/dt).

    An undamped impact at the speed reaches the overlap that it reaches with the stiffness k, and
    there the dashpot's coefficient is 2 zeta sqrt(k m_eff).
    """
    k = p["stiffness"]
    m_eff = 0.5 * m if p["effective_mass"] == "half" else m
    overlap = speed * math.sqrt(m / k)
    return 1.25 * k / math.sqrt(overlap), 1.6 * damping_ratio(p) * math.sqrt(m_eff / k)


def refuse_unsound(p, softest=0.0):
    """End for a stiffness below one [N/m], or a step that is unstable in a well.

    There the motion normal to the row feels 3/2 of the spring and of the dashpot, and the spring
    at its stiffest is 15/8 of the linear one.
    """
    zeta = damping_ratio(p) * (math.sqrt(0.5) if p["effective_mass"] == "half" else 1.0)
    fewest = 15 * math.pi / 16 / (math.sqrt(zeta * zeta + 5 / 4) - zeta)
    for name, least in (("steps_per_contact", fewest), ("stiffness", softest)):
        if p[name] < least * (1 - 1e-12):
            sys.exit(f"ERROR: {name} = {p[name]}: must be greater than {least:.6g} at these values")


def hertz_group(K, A, d):
    """Return ESyS's contact, 2 E sqrt(R) / 3 / (1 - nu^2) for K, with R = d/4 and nu = 0."""
    return HertzianViscoElasticPrms(name="contact", A=A, E=3.0 * K / math.sqrt(d), nu=0.0)


def simulation(d, low, high, step, steps):
    """Return an empty model in a box, which is searched for contacts 0.2 d ahead."""
    sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
    # cells as wide as this at least, and no more of them along a long box than memory bears
    cell = max(2.5 * d, max(b - a for a, b in zip(low, high)) / 200.0)
    sim.initNeighbourSearch(particleType="NRotSphere", gridSpacing=cell, verletDist=0.2 * d)
    sim.setSpatialDomain(BoundingBox(Vec3(*low), Vec3(*high)))
    sim.setTimeStepSize(step)
    sim.setNumTimeSteps(steps)
    return sim


def add(sim, number, tag, place, velocity, d, m):
    """Put a sphere into the model; those of tag FIXED stay where they are."""
    sphere = NRotSphere(id=number, posn=Vec3(*place), radius=0.5 * d, mass=m)
    sphere.setTag(tag)
    sphere.setLinearVelocity(Vec3(*velocity))
    sim.createParticle(sphere)


def row(*values):
    """Return a row of the table, with all digits."""
    return ",".join(format(value, ".17g") for value in values) + "\n"


class Row:
    """What the motion is measured by: the weight, the spring, the crests and their energy."""

    def __init__(self, p):
        self.d, self.g, self.tilt = p["diameter"], p["gravity"], math.radians(p["angle"])
        self.m = p["density"] * math.pi / 6.0 * self.d**3
        self.step = math.pi * math.sqrt(self.m / p["stiffness"]) / p["steps_per_contact"]
        refuse_unsound(p, 100 * self.m * self.g / self.d)
        self.K, self.A = hertz(p, self.m, math.sqrt(self.g * self.d))
        damping = self.A / math.sqrt(self.m / p["stiffness"])
        # the dashpot alone stops the grain, which leaves where the force vanishes: a bound
        self.rebound = (1.2 / damping) ** (2.0 / 3.0) / damping if damping > 1.0 else 1.0
        self.weight = self.m * self.g
        self.rest = self.overlap(self.weight)  # of a grain at rest on a crest
        self.crest_energy = self.weight * (self.d - self.rest) + self.spring(self.rest)

    def overlap(self, force):
        """Return the overlap that bears a force."""
        return (force / self.K) ** (2.0 / 3.0)

    def spring(self, overlap):
        """Return the energy of the spring."""
        return 0.4 * self.K * max(overlap, 0.0) ** 2.5

    def overlaps(self, x, y):
        """Return the overlaps with the spheres behind and ahead."""
        behind = self.d * math.floor(x / self.d)
        return [self.d - math.hypot(x - behind - away, y) for away in (0.0, self.d)]

    def margin(self, well, x, y, vx, vy):
        """Return the energy above that of a grain at rest on the crest after so many wells.

        Dissipation only lowers it: a grain that turns back with a negative one is trapped.
        """
        height = y * math.cos(self.tilt) - x * math.sin(self.tilt)
        height += well * self.d * math.sin(self.tilt)
        springs = sum(self.spring(overlap) for overlap in self.overlaps(x, y))
        motion = 0.5 * self.m * (vx * vx + vy * vy)
        return motion + self.weight * height + springs - self.crest_energy

    def behind_crest(self, start, phase):
        """Return the grain behind the crest with just the energy of the crest.

        The overlap balances the weight less the centrifugal force, m g (3 cos(phi) - 2) at
        the angle phi from the crest, and the rate of phi follows from the energy.
        """
        phi = math.radians(start)
        phi += phase * math.sqrt(2.0 * self.g * (1.0 - math.cos(phi)) / self.d) * self.step
        force = self.weight * (3.0 * math.cos(phi) - 2.0)
        delta = self.overlap(force)
        slope = 2.0 * self.weight * math.sin(phi) * delta / force  # of the distance r, by phi
        r = self.d - delta
        motion = self.crest_energy - self.weight * r * math.cos(phi) - self.spring(delta)
        rate = math.sqrt(2.0 * motion / self.m / (r * r + slope * slope))
        cos, sin = math.cos(phi - self.tilt), math.sin(phi - self.tilt)
        return r * sin, r * cos, rate * (r * cos + slope * sin), rate * (slope * cos - r * sin)

    def in_well(self, speed):
        """Return the grain in a well, along the tangent of the sphere ahead."""
        v = speed * math.sqrt(self.g * self.d)
        return 0.5 * self.d, math.sqrt(0.75) * self.d, v * math.sqrt(0.75), 0.5 * v

    def crest(self, well, before=0.0):
        """Return the x of a crest, or of the place so many radians before it."""
        return well * self.d - (self.d - self.rest) * math.sin(self.tilt + before)

    def settled(self):
        """Return the angle before the next crest at which the contact has settled.

        Eight times of its slowest rate and the hops before, at the speed after the shock (about
        0.35 sqrt(g d), which turned by 60 deg), are left between the well and the place,
        which is 10 deg before the crest at most.
        """
        omega = math.sqrt(1.5 * self.K * math.sqrt(self.rest) / self.m)
        zeta = self.A * omega / 3.0
        slowest = zeta + math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else 1.0 / (zeta + 1e-9)
        swept = 8.0 * slowest / omega * 0.35 * math.sqrt(self.g / self.d)
        if self.rebound > 0.0:
            hops = 2.0 * self.rebound / (1.0 - min(self.rebound, 0.99))
            swept += hops * 0.35 * math.tan(math.pi / 3.0) / math.cos(math.pi / 6.0) * 0.35
        return min(max(math.pi / 6.0 - self.tilt - swept, 0.0), math.radians(10.0))


class Watch:
    """Watches one grain well after well."""

    def __init__(self, p, rules):
        self.rules, self.well, self.verdict, self.margin = rules, 1, "undecided", 0.0
        self.passage, self.wells = p["route"] == "passage", p["wells"]
        self.before = rules.settled() if self.passage else 0.0

    def look(self, state):
        """See what became of the grain."""
        if self.verdict != "undecided":
            return
        self.margin = self.rules.margin(self.well, *state)
        if state[0] > self.rules.crest(self.well, self.before):
            if self.passage and self.margin < 0.0:
                self.verdict = "trapped"
            elif self.passage or self.well == self.wells:
                self.verdict = "moves_on"
            else:
                self.well += 1
        elif state[2] < 0.0 and self.margin < 0.0:
            self.verdict = "trapped"


def build(p, rules, starts):
    """Return the model: rows of spheres side by side, a grain on each, gravity tilted."""
    d, m = rules.d, rules.m
    last = 3 if p["route"] == "passage" else p["wells"] + 2
    low = (-4.0 * d, -4.0 * d, -4.0 * d)
    high = ((last + 3) * d, (last + 4) * d, (3 * len(starts) + 1) * d)
    steps = math.ceil(p["time_limit"] * math.sqrt(d / rules.g) / rules.step)
    sim = simulation(d, low, high, rules.step, steps)
    for number, (x, y, vx, vy) in enumerate(starts):
        z = 3.0 * number * d
        add(sim, number, GRAIN, (x, y, z), (vx, vy, 0.0), d, m)
        for i in range(-2, last + 1):
            sphere = len(starts) + number * (last + 3) + i + 2
            add(sim, sphere, FIXED, (i * d, 0.0, z), (0.0, 0.0, 0.0), d, m)
    sim.setParticleNonDynamic(FIXED)  # a tag, not the number of a particle
    sim.createInteractionGroup(hertz_group(rules.K, rules.A, d))
    pull = (rules.g * math.sin(rules.tilt), -rules.g * math.cos(rules.tilt), 0.0)
    sim.createInteractionGroup(GravityPrms(name="weight", acceleration=Vec3(*pull)))
    return sim, steps


def states(sim, count):
    """Return x, y, vx, vy of each row's grain."""
    grains = sorted(sim.getParticleList(list(range(count))), key=lambda sphere: sphere.getId())
    moves = [(grain.getPosn(), grain.getLinearVelocity()) for grain in grains]
    return [(x[0], x[1], v[0], v[1]) for x, v in moves]


def main(p):
    """Run the incline."""
    rules = Row(p)
    shifts = [float(text) for text in str(p["phases"]).split(",")]
    if p["route"] == "passage":
        starts = [rules.behind_crest(p["start"], shift) for shift in shifts]
    else:
        starts = [rules.in_well(p["speed"])]
    watches = [Watch(p, rules) for _ in starts]
    sim, steps = build(p, rules, starts)
    with open(p["series"], "w") as series:
        names = ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
        columns = [f"{name}[{i + 1}]" for i in range(len(starts)) for name in names]
        series.write(",".join(["time_s", *columns]) + "\n")
        series.write(row(0.0, *(value for start in starts for value in start)))
        for count in range(1, steps + 1):
            sim.runTimeStep()
            if count % p["series_every"] and count < steps:
                continue
            now = states(sim, len(starts))
            series.write(row(count * rules.step, *(value for state in now for value in state)))
            for watch, state in zip(watches, now):
                watch.look(state)
            if all(watch.verdict != "undecided" for watch in watches):
                break
    sim.exit()
    result("mass_kg", rules.m)
    result("step_s", rules.step)
    result("hertz_coefficient_N_per_m1.5", rules.K)
    result("relaxation_s", rules.A)
    result("steps", count)
    for watch in watches:
        result("margin_J", watch.margin)
        result("verdict", watch.verdict)


if __name__ == "__main__":
    try:
        main(parameters(sys.argv[1:]))
    except Exception:
        # left to itself ESyS-Particle would wait for its workers for ever
        traceback.print_exc()
        sys.exit(1)
