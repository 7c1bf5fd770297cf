# A contact with friction: one or two spheres and horizontal walls.
#
# Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template, not this file).
#
# Run it as it stands, or with other parameters, on one master and one worker:
#
#     mpirun -np 2 esysparticle contacts.py
#     mpirun -np 2 esysparticle contacts.py friction=0.1 series=other.csv
#
# It writes place, velocity and angular velocity of each sphere to a file and ends with lines
# "RESULT name = value"; no forces, which ESyS-Particle does not tell. SI units. For 2.3.
#
# Friction, and a linear spring with it, is RotFriction's; a linear spring alone RotElastic's; a
# Hertzian contact HertzianElastic's or, with a dashpot and never attractive,
# HertzianViscoElastic's. A wall is NRotElasticWall: a spring without friction.

import json
import sys
import time
import traceback
from pathlib import Path
from types import SimpleNamespace

from esys.lsm import (
    GravityPrms,
    HertzianElasticPrms,
    HertzianViscoElasticPrms,
    LsmMpi,
    NRotElasticWallPrms,
    RotElasticPrms,
    RotFrictionPrms,
    RotSphere,
)
from esys.lsm.util import BoundingBox, Vec3

PARAMETERS = {
    "normal": "hooke",  # or hertz
    "normal_stiffness": 1000000.0,  # N/m, of hooke
    "youngs_modulus": 0.0,  # Pa, of hertz, as the next
    "poisson_ratio": 0.0,
    "damping": "none",  # or viscoelastic, of hertz
    "damping_coefficient": 0.0,  # 1/(m s)
    "clipped": "yes",
    "tangential": "none",  # or linear_history, of hooke between spheres
    "tangential_stiffness": 285714.28571428574,  # N/m
    "friction": 0.3,
    "bodies": 1,
    "motion_1": "free",  # or frozen
    "radius_1": 0.01,
    "mass_1": 0.01,
    "x_1": 0.0,
    "y_1": 0.0,
    "z_1": 0.01,
    "vx_1": 0.7071067811865476,
    "vy_1": 0.0,
    "vz_1": -0.7071067811865476,
    "wx_1": 0.0,
    "wy_1": 0.0,
    "wz_1": 0.0,
    "motion_2": "free",  # or frozen
    "radius_2": 0.01,
    "mass_2": 0.01,
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
    "floor": 0.0,
    "ceiling": 0.0,
    "gravity_x": 0.0,
    "gravity_y": 0.0,
    "gravity_z": 0.0,
    "room": 0.0816,  # half the width of the box
    "step_size": 1e-07,
    "steps": 4000,
    "series_every": 40,
    "series": "contacts.csv",
    "results": "",  # file for the lines RESULT, beside the screen
}
FROZEN, FREE = 1, 2
COLUMNS = "x_m y_m z_m vx_m_per_s vy_m_per_s vz_m_per_s wx_rad_per_s wy_rad_per_s wz_rad_per_s"

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


def vector(p, names, i):
    """Return three parameters of a sphere."""
    return Vec3(*(getattr(p, f"{name}_{i}") for name in names.split()))


def contact(sim, p):
    """Give the model the contact of two spheres."""
    if p.normal == "hertz":
        told = {"name": "contact", "E": p.youngs_modulus, "nu": p.poisson_ratio}
        if p.damping == "none":
            sim.createInteractionGroup(HertzianElasticPrms(**told))
            return
        # its dashpot is 4/3 E* A times the contact radius
        m = p.mass_1
        if p.motion_2 != "frozen":
            m = m * p.mass_2 / (m + p.mass_2)
        modulus = p.youngs_modulus / 2.0 / (1.0 - p.poisson_ratio**2)
        relaxation = 0.75 * p.damping_coefficient * m / modulus
        sim.createInteractionGroup(HertzianViscoElasticPrms(A=relaxation, **told))
        return
    stiff, mu = p.normal_stiffness, p.friction
    if p.tangential == "none":
        group = RotElasticPrms(name="contact", normalK=stiff, scaling=False)
    else:
        group = RotFrictionPrms(
            name="contact",
            normalK=stiff,
            dynamicMu=mu,
            staticMu=mu,
            shearK=p.tangential_stiffness,
            scaling=False,
        )
    sim.createInteractionGroup(group)


def model(p):
    """Return a model with spheres and walls."""
    far, radii = p.room, [getattr(p, f"radius_{i}") for i in range(1, p.bodies + 1)]
    sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
    search = {"gridSpacing": max(0.02 * far, 3.0 * max(radii)), "verletDist": 0.2 * min(radii)}
    sim.initNeighbourSearch(particleType="RotSphere", **search)
    sim.setSpatialDomain(BoundingBox(Vec3(-far, -far, -far), Vec3(far, far, far)))
    sim.setTimeStepSize(p.step_size)
    sim.setNumTimeSteps(p.steps + 1)
    for i, radius in enumerate(radii, 1):
        place, mass = vector(p, "x y z", i), getattr(p, f"mass_{i}")
        sphere = RotSphere(id=i, posn=place, radius=radius, mass=mass)
        sphere.setTag(FROZEN if getattr(p, f"motion_{i}") == "frozen" else FREE)
        sphere.setLinearVelocity(vector(p, "vx vy vz", i))
        sphere.setAngularVelocity(vector(p, "wx wy wz", i))
        sim.createParticle(sphere)
    sim.setParticleNonDynamic(FROZEN)  # a tag, not the number of a particle
    if p.bodies > 1:
        contact(sim, p)
    walls = (("floor", p.floor, 1.0), ("ceiling", p.ceiling, -1.0))
    for name, height, up in walls[: p.planes]:
        sim.createWall(name=name, posn=Vec3(0.0, 0.0, height), normal=Vec3(0.0, 0.0, up))
        # ESyS-Particle multiplies it by this and the radius of the sphere that is next to the wall
        stiff = p.normal_stiffness / 3.141592654 / radii[-1 if up < 0.0 else 0]
        group = NRotElasticWallPrms(name=f"{name}_contact", wallName=name, normalK=stiff)
        sim.createInteractionGroup(group)
    gravity = Vec3(p.gravity_x, p.gravity_y, p.gravity_z)
    sim.createInteractionGroup(GravityPrms(name="weight", acceleration=gravity))
    return sim


def row(step, states):
    """Return a row of the series; ``states`` are vectors of each sphere."""
    values = [[v[axis] for v in state for axis in range(3)] for state in states]
    return step, *(value[i] for i in range(9) for value in values)


def spheres(sim, places):
    """Return place, velocity and angular velocity of each sphere."""
    found = sorted(sim.getParticleList(list(places)), key=lambda one: one.getId())
    return [[one.getPosn(), one.getLinearVelocity(), one.getAngularVelocity()] for one in found]


def middle(one, other):
    """Return the mean of two vectors."""
    return [0.5 * (one[axis] + other[axis]) for axis in range(3)]


def main(p):
    """Run the contact."""
    sim, places = model(p), range(1, p.bodies + 1)
    began, results = time.perf_counter(), Results(p.results)
    series = Series(p.series, ["step", *(f"{c}[{i}]" for c in COLUMNS.split() for i in places)])
    names = ("x y z", "vx vy vz", "wx wy wz")
    series.add(*row(0, [[vector(p, n, i) for n in names] for i in places]))
    due = None
    for step in range(1, p.steps + 2):
        sim.runTimeStep()
        if due is not None:
            # a velocity stands half a step behind the place: that of the next step, half ahead
            states = [
                [x, middle(v, later[1]), middle(w, later[2])]
                for (x, v, w), later in zip(due, spheres(sim, places))
            ]
            series.add(*row(step - 1, states))
        due = spheres(sim, places) if step % p.series_every == 0 else None
    sim.exit()
    series.write()
    results.add("steps", p.steps)
    results.add("seconds", time.perf_counter() - began)
    results.add("verdict", "finished")


if __name__ == "__main__":
    try:
        # a second model in the same process would wait for ever
        (parameters,) = runs()
        main(parameters)
    except Exception:
        # left to itself ESyS-Particle would wait for its workers for ever
        traceback.print_exc()
        sys.exit(1)
