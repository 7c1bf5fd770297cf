# A grain that meets one fixed sphere.
#
# Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template, not this file).
#
# Run it as it stands, or with other parameters, on one master and one worker:
#
#     mpirun -np 2 esysparticle drop.py
#     mpirun -np 2 esysparticle drop.py restitution=0.1 series=other.csv
#
# The sphere's centre is the origin; the grain starts at (0, diameter + gap), moves down with
# `speed` and along x with `sideways`; gravity points down. It writes the grain's motion to a
# file and ends with lines "RESULT name = value". SI units. For ESyS-Particle 2.3.
#
# The contact is Hertz's, never attractive: K (delta^1.5 + A sqrt(delta) d(delta)/dt), K and A from
# the stiffness k and the damping ratio of the linear contact it stands for. `mode=dashpot` is
# the linear spring with ESyS's LinearDashpot, which also brakes along the tangent.

import math
import sys
import traceback

from esys.lsm import (
    GravityPrms,
    HertzianViscoElasticPrms,
    LinearDashpotPrms,
    LsmMpi,
    NRotElasticPrms,
    NRotSphere,
)
from esys.lsm.util import BoundingBox, Vec3

PARAMETERS = {
    "stiffness": 1000000.0,
    "steps_per_contact": 2000.0,
    "gravity": 0.0,
    "diameter": 1.0,
    "density": 1.909859317102744,
    "gap": 0.001,
    "speed": 1.0,
    "sideways": 0.0,
    "steps": 6000,
    "series_every": 1,
    "damping": "restitution",
    "restitution": 0.5,
    "damping_ratio": 1.0,
    "effective_mass": "full",
    "mode": "hertz",
    "series": "drop.csv",
}
FIXED, GRAIN = 1, 2


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


def contact(sim, p, m):
    """Give the model its contact."""
    k, d, v0 = p["stiffness"], p["diameter"], math.hypot(p["speed"], p["sideways"])
    if p["mode"] == "hertz":
        K, A = hertz(p, m, math.hypot(v0, math.sqrt(p["gravity"] * d)))
        result("hertz_coefficient_N_per_m1.5", K)
        result("relaxation_s", A)
        sim.createInteractionGroup(hertz_group(K, A, d))
        return
    # force = damp * (area / distance) * relative velocity, area that of a disc of diameter d
    m_eff = 0.5 * m if p["effective_mass"] == "half" else m
    eta = 2.0 * damping_ratio(p) * math.sqrt(k * m_eff)
    sim.createInteractionGroup(NRotElasticPrms(name="contact", normalK=k, scaling=False))
    damp = eta * d / (math.pi * (0.5 * d) ** 2)
    sim.createInteractionGroup(LinearDashpotPrms(name="dashpot", damp=damp, cutoff=1.0))


def main(p):
    """Run the drop."""
    d, g = p["diameter"], p["gravity"]
    m = p["density"] * math.pi / 6.0 * d**3
    if p["mode"] == "hertz":
        refuse_unsound(p)
    step = math.pi * math.sqrt(m / p["stiffness"]) / p["steps_per_contact"]
    time = p["steps"] * step
    reach = (math.hypot(p["speed"], p["sideways"]) + g * time) * time + abs(p["gap"]) + 4.0 * d
    sim = simulation(d, (-reach, -reach, -2.0 * d), (reach, reach, 2.0 * d), step, p["steps"])
    add(sim, 0, FIXED, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), d, m)
    add(sim, 1, GRAIN, (0.0, d + p["gap"], 0.0), (p["sideways"], -p["speed"], 0.0), d, m)
    sim.setParticleNonDynamic(FIXED)  # a tag, not the number of a particle
    contact(sim, p, m)
    sim.createInteractionGroup(GravityPrms(name="weight", acceleration=Vec3(0.0, -g, 0.0)))
    with open(p["series"], "w") as series:
        series.write("time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n")
        series.write(row(0.0, 0.0, d + p["gap"], p["sideways"], -p["speed"]))
        for count in range(1, p["steps"] + 1):
            sim.runTimeStep()
            if count % p["series_every"] == 0:
                (grain,) = sim.getParticleList([1])
                x, v = grain.getPosn(), grain.getLinearVelocity()
                series.write(row(count * step, x[0], x[1], v[0], v[1]))
    sim.exit()
    result("step_s", step)
    result("final_velocity_m_per_s", v[1])
    result("verdict", "finished")


if __name__ == "__main__":
    try:
        main(parameters(sys.argv[1:]))
    except Exception:
        # left to itself ESyS-Particle would wait for its workers for ever
        traceback.print_exc()
        sys.exit(1)
