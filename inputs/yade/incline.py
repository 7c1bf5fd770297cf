"""The frictionless incline: a grain slides over a row of fixed, touching spheres.

Made by dem-harness 0.1.0 (`dem-harness inputs` writes it again; edit the template).
The contact is the plastic one unless told otherwise: overdamped, tail clipped. Yade's contacts
always clip the tail.

Run it as it stands, with other parameters, or for a list of them in a JSON file:

    yade -n -x incline.py
    yade -n -x incline.py angle=10.5 stiffness=1e7 steps_per_contact=200
    yade -n -x incline.py runs.json

It ends with lines "RESULT name = value". The verdict is one of
    moves_on       the grain passes the crests (all of them: motion persists)
    trapped        it turned back in a well, with less energy than the crest asks for
    undecided      the time limit came first: this is not "trapped"
    not_a_number   place or velocity of the grain overflowed

Theory (no rebound, rigid): motion persists from 10.2078 deg on.
SI units; angles in degrees. Written for Yade 2023.02a.
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
    # passage: start behind a crest with just the energy of that crest, pass one well, and
    #          report the energy left over the next crest: its sign is the verdict, its root in
    #          the angle the critical angle
    # steady:  start in a well, fast enough to leave it, and pass well after well
    "route": "steady",
    "angle": 10.2,  # tilt of the row, deg (0 to 30)
    "stiffness": 1000000.0,  # normal stiffness k, N/m
    "steps_per_contact": 100.0,  # steps per contact time pi sqrt(m/k)
    "gravity": 9.81,  # m/s2
    "diameter": 1.0,  # of all spheres, m
    "density": 1.909859317102744,  # of the grain, kg/m3; this one: 1 kg at 1 m
    "spheres": 9,  # in the row, which is periodic
    # eta = 2 zeta sqrt(k m_eff), with zeta from the restitution (e = 0: critical damping) or
    # given, as "damping" says
    "damping": "ratio",  # restitution or ratio
    "restitution": 0.0,
    "damping_ratio": 5.0,
    "effective_mass": "full",  # against a fixed sphere: full (m) or half (m/2)
    "wells": 10,  # steady: wells to pass before "moves_on"
    "speed": 0.48,  # steady: first speed, in sqrt(gravity * diameter)
    "start": 10.0,  # passage: where to start, deg behind the crest
    "phase": 0.0,  # passage: shift of the start, in steps (0 to 1)
    "time_limit": 400.0,  # in sqrt(diameter / gravity)
    "series": "",  # file for the grain's motion
    "series_every": 100,  # steps between its rows
    "results": "",  # file for the lines RESULT, beside the screen
}

WATCH = 50
"""Steps between two looks at the grain."""


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
    "spheres": (
        lambda value: not (value < 4 or value > 100000 or value != value),
        ": must be a whole number, greater than or equal to 4 and less than or equal to 100000",
    ),
    "wells": (
        lambda value: not (value < 1 or value > 10000 or value != value),
        ": must be a whole number, greater than or equal to 1 and less than or equal to 10000",
    ),
    "phase": (
        lambda value: not (value < 0 or value > 1 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 1",
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


def refuse_unsound(p, mass, eta):
    """End for a contact that is too soft, or a step that is unstable in a well.

    There the motion normal to the row feels 3/2 of the spring and of the dashpot.
    """
    zeta = eta / 2 / math.sqrt(p.stiffness * mass)
    fewest = math.pi / 2 / (math.sqrt(zeta * zeta + 2 / 3) - zeta)
    softest = 100 * mass * p.gravity / p.diameter
    for name, value, least in (
        ("steps_per_contact", p.steps_per_contact, fewest),
        ("stiffness", p.stiffness, softest),
    ):
        if value < least * (1 - 1e-12):
            sys.exit(f"ERROR: {name} = {value}: must be greater than {least:.6g} at these values")


class Incline:
    """The system of one run, and the energy by which the grain is judged."""

    def __init__(self, p):
        self.p, self.d, self.g, self.k = p, p.diameter, p.gravity, p.stiffness
        self.m = p.density * math.pi / 6 * p.diameter**3
        self.theta = math.radians(p.angle)
        self.step = math.pi * math.sqrt(self.m / self.k) / p.steps_per_contact
        self.longest = math.ceil(p.time_limit * math.sqrt(self.d / self.g) / self.step)
        self.eta = dashpot(p, self.m)
        refuse_unsound(p, self.m, self.eta)
        # a crest is the highest point of the grain's path over a sphere. There the grain at
        # rest is pressed in by m g / k, so it stands at this distance from the sphere's centre
        weight = self.m * self.g
        self.crest = self.d * (1 - weight / (self.k * self.d))
        self.crest_energy = weight * self.crest + 0.5 * weight**2 / self.k

    def start(self):
        """Return place and velocity at the start of the route."""
        p, d, g, k = self.p, self.d, self.g, self.k
        if p.route == "steady":
            v = p.speed * math.sqrt(g * d)
            return (0.5 * d, math.sqrt(0.75) * d), (v * math.sqrt(0.75), 0.5 * v)
        # the angle phi behind the crest, overlap in balance with the weight less the
        # centrifugal force, m g (3 cos(phi) - 2) / k, and the rate of phi from the energy
        weight, behind = self.m * g, math.radians(p.start)
        rate = math.sqrt(2 * g * (1 - math.cos(behind)) / d)
        phi = behind + p.phase * rate * self.step
        overlap = weight * (3 * math.cos(phi) - 2) / k
        slope = 3 * weight * math.sin(phi) / k
        r = d - overlap
        kinetic = self.crest_energy - weight * r * math.cos(phi) - 0.5 * k * overlap**2
        omega = math.sqrt(2 * kinetic / self.m / (r * r + slope * slope))
        sine, cosine = math.sin(phi - self.theta), math.cos(phi - self.theta)
        velocity = omega * (r * cosine + slope * sine), omega * (slope * cosine - r * sine)
        return (r * sine, r * cosine), velocity

    def end(self, well):
        """Return the x whose passage ends a well.

        passage: once the contact has settled after the shock, the energy stays what it is, and
        the slow way to the crest need not be walked. The slowest rate of the contact is that of
        x'' + 2 zeta omega x' + omega^2 x; eight of its times, at the speed after the shock
        (about 0.35 sqrt(g d)), are left between the well and the place to stop, 10 deg before
        the crest at most.
        """
        if self.p.route == "steady":
            return well * self.d - self.crest * math.sin(self.theta)
        zeta = self.eta / 2 / math.sqrt(self.k * self.m)
        settle = zeta + math.sqrt(zeta * zeta - 1) if zeta >= 1 else 1 / (zeta + 1e-9)
        times = 8 * settle * math.sqrt(self.m / self.k)
        swept = times * 0.35 * math.sqrt(self.g / self.d)
        before = min(max(math.pi / 6 - self.theta - swept, 0), math.radians(10))
        return self.d - self.crest * math.sin(self.theta + before)

    def overlap(self, x, y):
        """Return the overlaps with the spheres behind and ahead; negative is a gap."""
        behind = self.d * math.floor(x / self.d)
        return [self.d - math.hypot(x - centre, y) for centre in (behind, behind + self.d)]

    def margin(self, well, x, y, vx, vy):
        """Return the mechanical energy above that of a grain at rest on a well's crest."""
        height = y * math.cos(self.theta) - x * math.sin(self.theta)
        springs = sum(0.5 * self.k * max(overlap, 0) ** 2 for overlap in self.overlap(x, y))
        energy = 0.5 * self.m * (vx * vx + vy * vy) + self.m * self.g * height + springs
        drop = self.m * self.g * well * self.d * math.sin(self.theta)
        return energy - self.crest_energy + drop


class Motion:
    """One run: the grain in Yade, looked at every so many steps until it is decided."""

    def __init__(self, p):
        self.p, self.case = p, Incline(p)
        self.results, self.verdict, self.well = Results(p.results), "", 1
        self.series = Series(p.series, ["time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s"])
        self.build()

    def build(self):
        """Set up row, grain and engines."""
        case, p = self.case, self.p
        start_over(case.step)
        O.periodic = True  # places run on over the boundary
        O.cell.setBox(p.spheres * case.d, 1000 * case.d, 1000 * case.d)
        material = stated(case.k, case.eta)
        for i in range(p.spheres):
            sphere((i * case.d, 0, 0), case.d, case.m, material, fixed=True)
        place, velocity = case.start()
        self.grain = sphere((*place, 0), case.d, case.m, material).state
        self.grain.vel = (*velocity, 0)
        watch = PyRunner(iterPeriod=WATCH, command="motion.look()")
        record = PyRunner(iterPeriod=p.series_every, command="motion.record()", initRun=True)
        weight = (case.g * math.sin(case.theta), -case.g * math.cos(case.theta), 0)
        O.engines = engines(case.d, weight, before=[record, watch] if p.series else [watch])

    def run(self):
        """Run until the grain is decided, or time is over."""
        case, add = self.case, self.results.add
        add("route", self.p.route)
        add("angle_deg", self.p.angle)
        add("mass_kg", case.m)
        add("damping_coefficient_N_s_per_m", case.eta)
        add("step_s", case.step)
        started = time.perf_counter()
        O.run(case.longest, wait=True)
        if not self.verdict:
            if O.iter % self.p.series_every == 0:
                self.record()
            self.look()
        self.series.write()
        add("seconds", time.perf_counter() - started)
        somewhere = self.verdict != "not_a_number"
        well = min(self.well, self.wells)
        add("crests_passed", self.well - 1)
        add("margin_J", case.margin(well, *self.state) if somewhere else math.nan)
        add("touching", int(somewhere and max(case.overlap(*self.state[:2])) > 0))
        add("time_s", self.steps * case.step)
        add("steps", self.steps)
        add("verdict", self.verdict)

    @property
    def wells(self):
        """Return how many wells there are to pass."""
        return 1 if self.p.route == "passage" else self.p.wells

    def now(self):
        """Return place and velocity of the grain, in Yade's own numbers."""
        place, velocity = self.grain.pos, self.grain.vel
        return place[0], place[1], velocity[0], velocity[1]

    def record(self):
        """Write a row of the path."""
        self.series.add(O.iter * self.case.step, *self.now())

    def look(self):
        """Judge the grain: passed a crest, trapped for good, or still on its way.

        Dissipation only lowers the energy, so a grain that turns back with a negative margin
        never gets over.
        """
        self.state, self.steps = self.now(), O.iter
        x, _, vx, _ = self.state
        if not all(map(math.isfinite, self.state)):
            return self.decide("not_a_number")
        margin = self.case.margin(self.well, *self.state)
        if x > self.case.end(self.well):
            if self.p.route == "passage" and margin < 0:
                return self.decide("trapped")
            touching = int(max(self.case.overlap(*self.state[:2])) > 0)
            self.results.add("crest", self.well, self.steps * self.case.step, margin, touching)
            self.well += 1
            if self.well > self.wells:
                return self.decide("moves_on")
        elif vx < 0 and margin < 0:
            return self.decide("trapped")
        if self.steps >= self.case.longest:
            return self.decide("undecided")
        return None

    def decide(self, verdict):
        """Keep the verdict and end the run."""
        self.verdict = verdict
        O.pause()


leave_nothing()
for parameters in runs():
    motion = Motion(parameters)
    motion.run()
