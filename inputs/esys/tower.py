# The tower: a grain runs into a row of equal spheres at rest.
#
# Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template, not this file).
#
# Run it as it stands, or with other parameters, on one master and one worker:
#
#     mpirun -np 2 esysparticle tower.py
#     mpirun -np 2 esysparticle tower.py height=19 stiffness=1e7 speed=4
#
# ESyS-Particle moves by v+ = v + h a(x), x+ = x + h v+: leap-frog, whose velocities belong half
# a step before the positions. So they start (v - h a / 2), and so they are read.
#
# The grain is particle 0; the motion is along x, and so is gravity; particle `height` is the
# base. It writes the motion of all particles to a file, the grain's in the columns [1], and ends
# with lines "RESULT name = value". SI units. For ESyS-Particle 2.3.

import math
import sys
import traceback

from esys.lsm import GravityPrms, LsmMpi, NRotElasticPrms, NRotSphere
from esys.lsm.util import BoundingBox, Vec3

PARAMETERS = {
    "stiffness": 1000000.0,
    "mass": 1.0,
    "diameter": 1.0,
    "height": 2,
    "speed": 2.0,
    "gravity": 9.81,
    "base": "fixed",
    "start": "touching",
    "gap": 0.0,
    "duration": 3.0,
    "steps_per_contact": 1000.0,
    "series_every": 4,
    "series": "tower.csv",
}
FIXED, MOBILE = 1, 2


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


def place(p, i):
    """Return where particle i starts [m]: contact j of a preloaded tower bears j - 1 particles."""
    d = p["diameter"]
    if p["start"] == "gapped":
        return i * (d + p["gap"])
    if p["start"] == "preloaded":
        return i * d - p["mass"] * p["gravity"] / p["stiffness"] * (i * (i - 1) // 2)
    return i * d


def acceleration(p, i):
    """Return the acceleration of particle i at the start: a preloaded tower is in balance."""
    fixed = i == p["height"] and p["base"] == "fixed"
    resting = p["start"] == "preloaded" and i > 0
    return 0.0 if fixed or resting else p["gravity"]


def state(sim):
    """Return position and velocity along x of the particles in order.

    Not their forces: `getForce` of such a copy of a particle crashes.
    """
    spheres = sorted(sim.getParticleList(), key=lambda sphere: sphere.getId())
    return [(sphere.getPosn()[0], sphere.getLinearVelocity()[0]) for sphere in spheres]


def main(p):
    """Run the tower."""
    k, m, d, g, n = p["stiffness"], p["mass"], p["diameter"], p["gravity"], p["height"]
    omega = math.sqrt(k / m)
    t0 = 2.0 / omega * (math.pi - math.atan2(p["speed"] * omega, g))
    steps = round(p["duration"] * t0 / (math.pi / omega / p["steps_per_contact"]))
    step = p["duration"] * t0 / steps
    time = (steps + 1) * step
    reach = p["speed"] * time + 0.5 * g * time**2 + 4.0 * d
    low, high = (-reach, -2.0 * d, -2.0 * d), (place(p, n) + reach, 2.0 * d, 2.0 * d)
    sim = simulation(d, low, high, step, steps + 1)
    speeds = [p["speed"]] + n * [0.0]
    start = [(place(p, i), speeds[i] - 0.5 * step * acceleration(p, i)) for i in range(n + 1)]
    for i, (x, v) in enumerate(start):
        tag = FIXED if i == n and p["base"] == "fixed" else MOBILE
        add(sim, i, tag, (x, 0.0, 0.0), (v, 0.0, 0.0), d, m)
    if p["base"] == "fixed":
        sim.setParticleNonDynamic(FIXED)  # a tag, not the number of a particle
    sim.createInteractionGroup(NRotElasticPrms(name="contact", normalK=k, scaling=False))
    sim.createInteractionGroup(GravityPrms(name="weight", acceleration=Vec3(g, 0.0, 0.0)))
    with open(p["series"], "w") as series:
        names = ("x_m", "vx_m_per_s", "fx_N")
        columns = [f"{name}[{i + 1}]" for name in names for i in range(n + 1)]
        series.write(",".join(["step", *columns]) + "\n")
        before = start  # ESyS-Particle crashes when it is asked before the first step
        for count in range(1, steps + 2):
            sim.runTimeStep()
            sampled, due = (count - 1) % p["series_every"] == 0, count % p["series_every"] == 0
            if not (sampled or due):
                continue
            after = state(sim)
            if sampled:
                changes = [(v, then) for (_, v), (_, then) in zip(before, after)]
                places = [x for x, _ in before]
                middle = [0.5 * (v + then) for v, then in changes]
                forces = [m * (then - v) / step for v, then in changes]
                series.write(row(count - 1, *places, *middle, *forces))
            before = after
    sim.exit()
    result("contact_time_s", t0)
    result("step_s", step)
    result("steps", steps)
    result("verdict", "finished")


if __name__ == "__main__":
    try:
        main(parameters(sys.argv[1:]))
    except Exception:
        # left to itself ESyS-Particle would wait for its workers for ever
        traceback.print_exc()
        sys.exit(1)
