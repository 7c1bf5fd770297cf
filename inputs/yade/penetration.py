"""A steel sphere falls on a bed of small spheres, in Yade: how deep does it go?

Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template).

Run it as it stands, with other parameters, or for a list of them in a JSON file:

    yade -n -x penetration.py
    yade -n -x penetration.py seed=7 speed=2
    yade -n -x penetration.py runs.json

Law2_ScGeom_MindlinPhys_Mindlin: Hertz, Mindlin without a tangential dashpot, no rolling
resistance. Yade takes E* and G* of a pair from its two materials; restitution and friction are
stated for each pair. Each wall is one triangle.

Rules in which it differs from LAMMPS's "tangential mindlin": the tangential spring is a force that
grows by increments and keeps its value when the overlap shrinks (LAMMPS's mindlin/force); the
normal force never attracts, with a dashpot that gives the restitution all the same (Thornton and
others 2013, B6). Which way they move depth or density is not predicted.

1 settling     grains start on a lattice, displaced by a formula of place and seed, and fall on the
               floor; the sphere is held above them
2 penetration  the sphere is released with its speed; time counts from here

It writes the series and ends with the line "RESULT verdict = finished". SI units. Written for
Yade 2023.02a.
"""

import json
import math
import sys
import time
from pathlib import Path
from types import SimpleNamespace

from yade import (
    Bo1_Facet_Aabb,
    Bo1_Sphere_Aabb,
    ForceResetter,
    FrictMat,
    Ig2_Facet_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom_MindlinPhys_Mindlin,
    MatchMaker,
    NewtonIntegrator,
    O,
    PyRunner,
    RotationEngine,
    Vector3,
    utils,
)

PARAMETERS = {
    "bed": "lattice",  # lattice, or file: the grains of a data file of atom_style sphere
    "places": "none",  # the data file
    "along": 12,  # grains of the lattice along x, y, z
    "across": 10,
    "layers": 9,
    "spacing": 1.2,  # of the lattice, in diameters of a grain; the box is as wide
    "scatter": 0.19,  # of the places, in diameters
    "seed": 1,
    "radius": 0.001,  # m, of a grain
    "density": 2500.0,  # kg/m3
    "youngs_modulus": 10000000.0,  # Pa
    "poisson_ratio": 0.2,  # of grains and steel
    "restitution": 0.5,  # between grains
    "friction": 0.3,
    "damping": "coeff_restitution",
    "steel_radius": 0.004,  # m, of the sphere
    "steel_density": 7200.0,  # kg/m3
    "steel_youngs_modulus": 2100000000.0,  # Pa, of sphere and walls
    "steel_restitution": 0.4,  # of grains and sphere on steel
    "steel_friction": 0.2,
    "length": 0.0288,  # m, of the box along x; of a lattice its own
    "width": 0.023999999999999997,  # m, along y
    "start_height": 0.026,  # m, of the sphere's centre above the floor
    "offset": 0.0,  # m, of the sphere from the middle of the box along x
    "speed": 0.3,  # m/s, downward
    "gravity": 9.81,  # m/s2
    "settle_steps": 24004,
    "steps": 20026,  # after the release
    "step_size": 5e-06,  # s
    "series": "penetration.csv",  # file for the samples
    "particles": 0,  # 1: all particles in its place, as a dump for OVITO
    "series_every": 34,  # steps between its rows
    "results": "",  # file for the lines RESULT, beside the screen
}


ALLOWED = {
    "spacing": (
        lambda value: not (value <= 1 or value > 3 or value != value),
        ": must be greater than 1 and less than or equal to 3",
    ),
    "scatter": (
        lambda value: not (value < 0 or value > 1 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 1",
    ),
    "seed": (
        lambda value: not (value < 1 or value > 10000 or value != value),
        ": must be a whole number, greater than or equal to 1 and less than or equal to 10000",
    ),
    "poisson_ratio": (
        lambda value: not (value < 0 or value >= 0.5 or value != value),
        ": must be greater than or equal to 0 and less than 0.5",
    ),
    "steel_youngs_modulus": (
        lambda value: not (value <= 0 or value != value),
        " Pa: must be greater than 0",
    ),
    "steel_restitution": (
        lambda value: not (value <= 0.05 or value > 1 or value != value),
        ": must be greater than 0.05 and less than or equal to 1",
    ),
    "steel_friction": (
        lambda value: not (value < 0 or value > 2 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 2",
    ),
    "gravity": (
        lambda value: not (value <= 0 or value != value),
        " m/s2: must be greater than 0",
    ),
    "step_size": (
        lambda value: not (value <= 0 or value != value),
        " s: must be greater than 0",
    ),
    "layers": (
        lambda value: not (value < 1 or value > 1000 or value != value),
        ": must be a whole number, greater than or equal to 1 and less than or equal to 1000",
    ),
    "radius": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "density": (
        lambda value: not (value <= 0 or value != value),
        " kg/m3: must be greater than 0",
    ),
    "youngs_modulus": (
        lambda value: not (value <= 0 or value != value),
        " Pa: must be greater than 0",
    ),
    "restitution": (
        lambda value: not (value <= 0.05 or value > 1 or value != value),
        ": must be greater than 0.05 and less than or equal to 1",
    ),
    "friction": (
        lambda value: not (value < 0 or value > 2 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 2",
    ),
    "length": (
        lambda value: not (value < 0 or value > 10 or value != value),
        " m: must be greater than or equal to 0 and less than or equal to 10",
    ),
    "width": (
        lambda value: not (value < 0 or value > 10 or value != value),
        " m: must be greater than or equal to 0 and less than or equal to 10",
    ),
    "along": (
        lambda value: not (value < 2 or value > 1000 or value != value),
        ": must be a whole number, greater than or equal to 2 and less than or equal to 1000",
    ),
    "across": (
        lambda value: not (value < 2 or value > 1000 or value != value),
        ": must be a whole number, greater than or equal to 2 and less than or equal to 1000",
    ),
    "steel_radius": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "steel_density": (
        lambda value: not (value <= 0 or value != value),
        " kg/m3: must be greater than 0",
    ),
    "start_height": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "speed": (
        lambda value: not (value <= 0 or value > 100 or value != value),
        " m/s: must be greater than 0 and less than or equal to 100",
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


class Particles:
    """All particles in the place of a series: a dump in LAMMPS's format, for OVITO."""

    def __init__(self, path):
        self.path, self.lines = path, []

    def add(self, step, states):
        """Add a frame; particles are numbered in their order."""
        axes = zip(*(place for _, _, place, _, _ in states))
        self.lines += ["ITEM: TIMESTEP", step, "ITEM: NUMBER OF ATOMS", len(states)]
        self.lines += ["ITEM: BOX BOUNDS mm mm mm", *(f"{min(x)} {max(x)}" for x in axes)]
        self.lines.append("ITEM: ATOMS id x y z radius")
        for number, (_, radius, place, _, _) in enumerate(states, 1):
            self.lines.append(" ".join(f"{value:.8g}" for value in (number, *place, radius)))

    def write(self):
        """Write the file."""
        Path(self.path).write_text("".join(f"{line}\n" for line in self.lines), encoding="utf-8")


def recorded(run):
    """Take the steps of the second stage of a run and write its series, or all particles."""
    p, look = run.p, run.look
    if p.particles:
        run.series = Particles(p.series)

        def look(step):
            run.series.add(p.settle_steps + step, run.spheres.states())

        look(0)
    run.spheres.advance(p.steps, p.series_every, look)
    run.series.write()


def grains_of(p):
    """Return the centres of the grains at the start [m].

    Those of a data file of LAMMPS's atom_style sphere, or of a lattice displaced by a formula of
    site and seed: the fraction of a large multiple of a sine looks random.
    """
    if p.bed == "file":
        return data_file(p.places)
    rows = range(p.layers), range(p.across), range(p.along)
    return scattered(p, p.radius, [(i, j, k) for k in rows[0] for j in rows[1] for i in rows[2]])


def scattered(p, radius, sites):
    """Return places near the sites of a lattice, three whole numbers each [m]."""
    diameter = 2 * radius
    return [
        [
            diameter * (p.spacing * (n + 0.5) + p.scatter * (fraction(site, p.seed, s) - 0.5))
            for n, s in zip(site, (0.5, 1.7, 2.9))
        ]
        for site in sites
    ]


def fraction(site, seed, shift):
    """Return a number from 0 to 1 that looks random."""
    angle = 12.9898 * site[0] + 78.233 * site[1] + 37.719 * site[2] + 4.1414 * seed
    sine = abs(math.sin(angle + shift)) * 43758.5453
    return sine - math.floor(sine)


def data_file(path, kind=1):
    """Return centres of a type in the section Atoms: number, type, diameter, density, x, y, z."""
    _, _, section = Path(path).read_text(encoding="utf-8").partition("\nAtoms")
    rows = [line.split() for line in section.splitlines()[1:]]
    grains = [row for row in rows if len(row) >= 7 and int(row[1]) == kind]
    return [[float(word) for word in row[4:7]] for row in grains]


def plane(place, normal, size):
    """Return a triangle in a plane through a place: equilateral, of an inscribed radius ``size``.

    One triangle has no seam, at which a code may count a wall twice.
    """
    least = min(range(3), key=lambda axis: abs(normal[axis]))
    first = unit(cross(normal, [float(axis == least) for axis in range(3)]))
    second = cross(normal, first)
    corners = []
    for turn in (0, 2, 4):
        c, s = (2 * size * f(turn * math.pi / 3) for f in (math.cos, math.sin))
        corners.append([place[i] + c * first[i] + s * second[i] for i in range(3)])
    return corners


def ring(count, low, high):
    """Return the triangles of a ring of trapezia between two circles, each (radius, height).

    Of polygons of the circles' areas; a corner at angle 0.
    """
    angles = [2 * math.pi * (i % count) / count for i in range(count + 1)]
    edges = [
        [(stretch(count) * r * math.cos(a), stretch(count) * r * math.sin(a), z) for a in angles]
        for r, z in (low, high)
    ]
    faces = []
    for i in range(count):
        (a, b), (c, d) = (edge[i : i + 2] for edge in edges)
        faces += [[a, b, d], [a, d, c]]
    return faces


def stretch(count):
    """Return the radius of the corners of a polygon of a circle's area, over the circle's."""
    return math.sqrt(2 * math.pi / count / math.sin(2 * math.pi / count))


def cross(a, b):
    """Return the vector product."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def unit(a):
    """Return a vector of length 1."""
    return [x / math.hypot(*a) for x in a]


def kinetic_energy(states):
    """Return the kinetic energy of spheres [J], those that are held at rest included."""
    return sum(
        0.5 * mass * sum(v * v for v in velocity)
        + 0.2 * mass * radius**2 * sum(w * w for w in spin)
        for mass, radius, _, velocity, spin in states
    )


def mean_contacts(states, count):
    """Return the contacts with other spheres of each of the first ``count``, their mean."""
    places = [(state[2], state[1]) for state in states]
    size = 2 * max(radius for _, radius in places)
    cells = {}
    for number, (place, _) in enumerate(places):
        cells.setdefault(tuple(math.floor(x / size) for x in place), []).append(number)
    near = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
    contacts = 0
    for number, (place, radius) in enumerate(places[:count]):
        cell = [math.floor(x / size) for x in place]
        for way in near:
            for other in cells.get(tuple(c + w for c, w in zip(cell, way)), ()):
                distance = math.dist(place, places[other][0])
                contacts += other != number and distance < radius + places[other][1]
    return contacts / count


GRAIN, SPHERE, WALL = range(3)


def materials_of(p):
    """Return Young's modulus [Pa], Poisson's ratio and density [kg/m3] of each material."""
    steel = (p.steel_youngs_modulus, p.poisson_ratio, p.steel_density)
    return [(p.youngs_modulus, p.poisson_ratio, p.density), steel, steel]


def pairs_of(p):
    """Return restitution and friction of each pair of materials."""
    grains, steel = (p.restitution, p.friction), (p.steel_restitution, p.steel_friction)
    pairs = {(one, other): steel for other in range(3) for one in range(other + 1)}
    return {**pairs, (GRAIN, GRAIN): grains}


def box_of(p):
    """Return length and width of the box, and its walls: a place and the normal inward."""
    size = [p.length, p.width]
    if p.bed != "file":
        size = [2 * p.radius * p.spacing * count for count in (p.along, p.across)]
    low, high = (0, 0, 0), (*size, 0)
    walls = [(low, (0, 0, 1)), (low, (1, 0, 0)), (low, (0, 1, 0))]
    return size, [*walls, (high, (-1, 0, 0)), (high, (0, -1, 0))]


class Impact:
    """One run: grains that settle, and a steel sphere that falls on them."""

    def __init__(self, p):
        self.p = p
        self.size, walls = box_of(p)
        self.spheres = Spheres(p, materials_of(p), pairs_of(p))
        places = grains_of(p)
        for place in places:
            self.spheres.add(GRAIN, place, p.radius)
        self.grains = len(places)
        start = (0.5 * self.size[0] + p.offset, 0.5 * self.size[1], p.start_height)
        self.ball = self.spheres.add(SPHERE, start, p.steel_radius, held=True)
        top = 2 * (p.start_height + p.steel_radius) + max(z for _, _, z in places)
        for place, normal in walls:
            self.spheres.wall(WALL, place, normal, 2 * (top + sum(self.size)))
        self.series = Series(p.series, COLUMNS.split(","))

    def run(self):
        """Let grains settle and the sphere fall; print what each leaves."""
        p, began, results = self.p, time.perf_counter(), Results(self.p.results)
        self.spheres.start()
        self.spheres.advance(p.settle_steps)
        states = self.spheres.states()
        heights = [place[2] for _, _, place, _, _ in states[: self.grains]]
        results.add("bed_kinetic_J", kinetic_energy(states))
        results.add("release_potential_J", self.potential(states))
        results.add("coordination", mean_contacts(states, self.grains))
        results.add("mean_height_m", sum(heights) / self.grains)
        results.add("grains", self.grains)
        self.spheres.release(self.ball, (0.0, 0.0, -p.speed))
        recorded(self)
        results.add("outside", int(any(map(self.beyond, self.spheres.states()))))
        results.add("seconds", time.perf_counter() - began)
        results.add("steps", p.settle_steps + p.steps)
        results.add("verdict", "finished")

    def look(self, step):
        """Write a row so many steps after the release."""
        states = self.spheres.states()
        _, _, place, velocity, _ = states[self.ball]
        energies = kinetic_energy(states), self.potential(states)
        self.series.add(step * self.p.step_size, place[2], velocity[2], *energies)

    def potential(self, states):
        """Return the potential energy of all [J]."""
        return sum(mass * self.p.gravity * place[2] for mass, _, place, _, _ in states)

    def beyond(self, state):
        """Return whether a centre is beyond a wall, or no number."""
        x, y, z = state[2]
        return not (0 <= x <= self.size[0] and 0 <= y <= self.size[1] and z >= 0)


COLUMNS = "time_s,z_m,vz_m_per_s,kinetic_J,potential_J"


class Spheres:
    """Spheres between walls of triangles in Yade; numbers are those of ``add``, places in m.

    Where two triangles meet, Yade counts the edge of each as one more contact.

    A step computes the forces at x, v standing half a step behind, then moves v and x.
    """

    def __init__(self, p, materials, pairs):
        self.p, self.bodies, self.look, self.every, self.first = p, [], None, 0, 0
        O.reset()
        O.dt = p.step_size
        self.gravity = Vector3(0, 0, -p.gravity)
        self.materials = [
            FrictMat(young=young, poisson=poisson, density=density)
            for young, poisson, density in materials
        ]
        for material in self.materials:
            O.materials.append(material)
        # Yade's own dashpot for a restitution; es = 1 is none along the surface
        dashpots = [(*pair, restitution) for pair, (restitution, _) in pairs.items()]
        angles = [(*pair, math.atan(friction)) for pair, (_, friction) in pairs.items()]
        self.maker = Ip2_FrictMat_FrictMat_MindlinPhys(
            en=MatchMaker(matches=dashpots), es=1.0, frictAngle=MatchMaker(matches=angles)
        )

    def add(self, material, place, radius, held=False):
        """Add a sphere and return its number."""
        body = utils.sphere(place, radius, material=self.materials[material], fixed=held)
        O.bodies.append(body)
        self.bodies.append(body)
        return len(self.bodies) - 1

    def wall(self, material, place, normal, size):
        """Add a wall: a triangle in the plane through a place, of an inscribed radius."""
        return self.triangles(material, [plane(place, normal, size)])

    def triangles(self, material, faces):
        """Add triangles, of three corners each, and return the wall that they are."""
        made = [utils.facet(f, material=self.materials[material], fixed=True) for f in faces]
        return O.bodies.append(made)

    def remove_wall(self, wall):
        """Take a wall away."""
        for number in wall:
            O.bodies.erase(number)

    def turn(self, wall, speed):
        """Let a wall turn about the y axis [rad/s]."""
        motor = RotationEngine(
            ids=wall, rotationAxis=(0, 1, 0), angularVelocity=speed, rotateAroundZero=True
        )
        O.engines = [*O.engines[:-1], motor, O.engines[-1]]

    def lift(self, wall):
        """Return the force of a wall on the spheres, upward [N], of the last step."""
        return -sum(O.forces.f(number)[2] for number in wall)

    def remove_below(self, height):
        """Take spheres away whose centres are below a height."""
        for body in [body for body in self.bodies if body.state.pos[2] < height]:
            O.bodies.erase(body.id)
            self.bodies.remove(body)

    def start(self):
        """Give Yade the engines of a step; velocities at the contact are those of its point.

        Spheres begin at rest; half a step before, Yade has less by what gravity adds till then.
        Without hertzian=True a triangle would count as a sphere of twice the radius.
        """
        for body in self.bodies:
            if body.dynamic:
                body.state.vel = -0.5 * self.p.step_size * self.gravity
        smallest = min(body.shape.radius for body in self.bodies)
        collider = InsertionSortCollider(
            [Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()], verletDist=0.1 * smallest
        )
        contacts = InteractionLoop(
            [
                Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False),
                Ig2_Facet_Sphere_ScGeom(hertzian=True),
            ],
            [self.maker],
            [Law2_ScGeom_MindlinPhys_Mindlin()],
        )
        newton = NewtonIntegrator(damping=0, gravity=self.gravity)
        sample = PyRunner(iterPeriod=1, command="WATCHED[0].sample()", initRun=True)
        WATCHED[:] = [self]
        O.engines = [ForceResetter(), collider, contacts, sample, newton]

    def advance(self, steps, every=0, look=None):
        """Take steps; ``look`` is called with their number at every so many of them."""
        self.first, self.every, self.look = O.iter, every, look
        if steps:  # 0 would be without end
            O.run(steps, wait=True)
        if look and steps % every == 0:
            O.step()  # the forces at the last places: Yade moves on by a step
        self.every = 0

    def sample(self):
        """Look where a sample is due, and say how far it is."""
        done = O.iter - self.first
        if done % TELL == 0:
            print(f"step {done}", flush=True)
        if self.every and done and done % self.every == 0:
            self.look(done)

    def release(self, number, velocity):
        """Let a sphere that was held go, with a velocity, which Yade has half a step before."""
        body = self.bodies[number]
        body.dynamic = True
        body.state.vel = Vector3(*velocity) - 0.5 * self.p.step_size * self.gravity

    def states(self):
        """Return mass, radius, place, velocity and spin of each sphere, at the time of the place.

        Velocities are moved on by half a step of the last forces.
        """
        half, states = 0.5 * self.p.step_size, []
        for body in self.bodies:
            state, radius = body.state, body.shape.radius
            velocity, spin = state.vel, state.angVel
            if body.dynamic:
                # no +=: Yade gives the vectors of its state themselves
                velocity = velocity + half * (O.forces.f(body.id) / state.mass + self.gravity)
                spin = spin + half / state.inertia[0] * O.forces.t(body.id)
            states.append((state.mass, radius, tuple(state.pos), tuple(velocity), tuple(spin)))
        return states


TELL = 1000
"""Steps between lines on the screen."""

WATCHED = []
"""The spheres that Yade's engines call upon, by this name."""


# Yade makes a folder below /tmp at its start and does not remove it
Path(O.tmpFilename()).parent.rmdir()
for parameters in runs():
    Impact(parameters).run()
