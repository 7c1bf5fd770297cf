"""Grains of two sizes in a rotating drum: how do they mix, how steep is their surface?

Made by dem-harness 1.0.0 (`dem-harness inputs` writes it again; edit the template,
not this file).

Run it as it stands, or with other parameters, with a Python that has Kratos
(pip install KratosMultiphysics KratosDEMApplication):

    python drum.py
    python drum.py seed=7 speed=2
    python drum.py FILE              a list of them in JSON

DEM_D_Hertz_viscous_Coulomb: Hertz and Mindlin, no rolling resistance. Kratos takes E* and G* of a
pair from its two materials; restitution and friction are stated for each pair. The drum is of rigid
faces: a ring of triangles of the circle's area, and an end of one triangle on each side.

Rules in which it differs from LAMMPS's "tangential mindlin NULL 0": the tangential spring is a
force that grows by increments and shrinks with the overlap (LAMMPS's mindlin_rescale/force); it has
a tangential dashpot of 2 gamma sqrt(m* k_t), with the gamma of the normal one, which cannot be left
out: contacts that stick dissipate more. The normal force never attracts, with a dashpot that gives
the restitution all the same (Thornton and others 2013, B6). Which way they move mixing or the angle
is not predicted.

The drum lies along y, its ends turn with it. Large grains lie below small ones.

1 filling      grains start on two lattices, displaced by a formula of place and seed, and settle
2 turning      the drum turns about +y, from z to x: grains rise at x < 0
Lines "RESULT name = value" end each run; the series has 17 digits. SI units.
Written for Kratos 10.2.3, 10.4.3, 10.4.4, one thread unless OMP_NUM_THREADS says more.
"""

import json
import math
import os
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import KratosMultiphysics as Kratos
import KratosMultiphysics.DEMApplication as DEM
from KratosMultiphysics.DEMApplication.sphere_strategy import ExplicitStrategy

PARAMETERS = {
    "bed": "lattice",  # lattice, or file: the grains of a data file of atom_style sphere
    "places": "none",  # the data file, large grains of type 1
    "large_layers": 1,  # of large grains above the axis; below it they fill the drum
    "small_layers": 4,  # of that of small ones, on top of it
    "spacing": 1.2,  # of both, in diameters
    "scatter": 0.19,  # of the places, in diameters
    "seed": 1,
    "large_radius": 0.002,  # m
    "large_density": 2000.0,  # kg/m3
    "large_youngs_modulus": 125000.0,  # Pa
    "large_restitution": 0.4,  # between large grains
    "large_friction": 0.4,
    "small_radius": 0.001,  # m
    "small_density": 2500.0,  # kg/m3
    "small_youngs_modulus": 250000.0,  # Pa
    "small_restitution": 0.5,  # between small grains
    "small_friction": 0.3,
    "mixed_restitution": 0.45,  # between a large and a small grain
    "mixed_friction": 0.2,
    "steel_youngs_modulus": 52500000.0,  # Pa, of the drum
    "steel_restitution": 0.4,  # of grains on it
    "steel_friction": 0.2,
    "poisson_ratio": 0.2,  # of all
    "damping": "coeff_restitution",
    "drum_radius": 0.024,  # m
    "drum_length": 0.02,  # m, along y
    "speed": 4.08,  # rad/s
    "gravity": 9.81,  # m/s2
    "settle_steps": 5720,
    "steps": 22000,  # after the drum has begun to turn
    "step_size": 3.5e-05,  # s
    "scheme": "Velocity_Verlet",  # or Symplectic_Euler
    "facets": 60,  # of the drum's polygon
    "series": "drum.csv",  # file for the places
    "particles": 0,  # 1: all particles in its place, as a dump for OVITO
    "series_every": 220,  # steps between its rows
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
    "large_layers": (
        lambda value: not (value < -1000 or value > 1000 or value != value),
        ": must be a whole number, greater than or equal to -1000 and less than or equal to 1000",
    ),
    "small_layers": (
        lambda value: not (value < 1 or value > 1000 or value != value),
        ": must be a whole number, greater than or equal to 1 and less than or equal to 1000",
    ),
    "large_radius": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "large_density": (
        lambda value: not (value <= 0 or value != value),
        " kg/m3: must be greater than 0",
    ),
    "large_youngs_modulus": (
        lambda value: not (value <= 0 or value != value),
        " Pa: must be greater than 0",
    ),
    "large_restitution": (
        lambda value: not (value <= 0.05 or value > 1 or value != value),
        ": must be greater than 0.05 and less than or equal to 1",
    ),
    "large_friction": (
        lambda value: not (value < 0 or value > 2 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 2",
    ),
    "small_radius": (
        lambda value: not (value <= 0 or value != value),
        " m: must be greater than 0",
    ),
    "small_density": (
        lambda value: not (value <= 0 or value != value),
        " kg/m3: must be greater than 0",
    ),
    "small_youngs_modulus": (
        lambda value: not (value <= 0 or value != value),
        " Pa: must be greater than 0",
    ),
    "small_restitution": (
        lambda value: not (value <= 0.05 or value > 1 or value != value),
        ": must be greater than 0.05 and less than or equal to 1",
    ),
    "small_friction": (
        lambda value: not (value < 0 or value > 2 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 2",
    ),
    "mixed_restitution": (
        lambda value: not (value <= 0.05 or value > 1 or value != value),
        ": must be greater than 0.05 and less than or equal to 1",
    ),
    "mixed_friction": (
        lambda value: not (value < 0 or value > 2 or value != value),
        ": must be greater than or equal to 0 and less than or equal to 2",
    ),
    "drum_radius": (
        lambda value: not (value <= 0 or value > 10 or value != value),
        " m: must be greater than 0 and less than or equal to 10",
    ),
    "drum_length": (
        lambda value: not (value <= 0 or value > 10 or value != value),
        " m: must be greater than 0 and less than or equal to 10",
    ),
    "speed": (
        lambda value: not (value <= 0 or value > 1000 or value != value),
        " rad/s: must be greater than 0 and less than or equal to 1000",
    ),
    "scheme": (
        lambda value: value in ["Velocity_Verlet", "Symplectic_Euler"],
        ": must be one of Velocity_Verlet, Symplectic_Euler",
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


LARGE, SMALL, WALL = range(3)


class Drum:
    """One run: grains that settle in a drum about the y axis, large ones below; it turns."""

    def __init__(self, p):
        self.p = p
        steel = p.steel_restitution, p.steel_friction
        pairs = {
            (LARGE, LARGE): (p.large_restitution, p.large_friction),
            (LARGE, SMALL): (p.mixed_restitution, p.mixed_friction),
            (SMALL, SMALL): (p.small_restitution, p.small_friction),
            **{(kind, WALL): steel for kind in (LARGE, SMALL, WALL)},
        }
        materials = [
            (p.large_youngs_modulus, p.poisson_ratio, p.large_density),
            (p.small_youngs_modulus, p.poisson_ratio, p.small_density),
            (p.steel_youngs_modulus, p.poisson_ratio, p.large_density),
        ]
        self.spheres = Spheres(p, materials, pairs)
        split = 2 * p.large_layers * p.large_radius * p.spacing
        base = split + p.small_radius * (1 + p.scatter)
        top = base + 2 * p.small_layers * p.small_radius * p.spacing
        below = split - p.large_radius * (1 + p.scatter)
        if p.bed == "file":
            self.large, self.small = (data_file(p.places, kind) for kind in (1, 2))
        else:
            self.large = self.lattice(p.large_radius, -math.inf, below)
            self.small = self.lattice(p.small_radius, base, top)
        for place in self.large:
            self.spheres.add(LARGE, place, p.large_radius)
        for place in self.small:
            self.spheres.add(SMALL, place, p.small_radius)
        self.walls(0.5 * p.drum_length)
        places = range(1, len(self.large) + len(self.small) + 1)
        names = [f"{name}[{i}]" for name in ("x_m", "y_m", "z_m") for i in places]
        self.series = Series(p.series, ["step", *names])

    def walls(self, half):
        """Add the drum: a ring along y, and an end on each side, of one triangle."""
        p = self.p
        faces = ring(p.facets, (p.drum_radius, -half), (p.drum_radius, half))
        turned = [[(z, along, x) for x, z, along in face] for face in faces]
        ends = [plane((0, way * half, 0), (0, -way, 0), 2 * p.drum_radius) for way in (-1, 1)]
        self.wall = self.spheres.triangles(WALL, [*turned, *ends])

    def lattice(self, radius, low, high):
        """Return places near the sites that leave a grain room, between two heights."""
        p = self.p
        pitch = 2 * radius * p.spacing
        reach = p.drum_radius - radius * (1 + math.sqrt(2) * p.scatter)
        along = 0.5 * p.drum_length - radius * (1 + p.scatter)
        most = max(1, math.ceil(max(reach, along) / pitch) + 1)
        row = [n for n in range(-most, most) if abs(pitch * (n + 0.5)) <= reach]
        beside = [n for n in range(-most, most) if abs(pitch * (n + 0.5)) <= along]
        heights = [n for n in row if low <= pitch * (n + 0.5) <= high]
        sites = [
            (i, j, k)
            for k in heights
            for j in beside
            for i in row
            if pitch * math.hypot(i + 0.5, k + 0.5) <= reach
        ]
        return scattered(p, radius, sites)

    def run(self):
        """Let grains settle and the drum turn; print what each leaves."""
        p, began, results = self.p, time.perf_counter(), Results(self.p.results)
        self.spheres.start()
        self.spheres.advance(p.settle_steps)
        results.add("bed_kinetic_J", kinetic_energy(self.spheres.states()))
        results.add("large", len(self.large))
        results.add("small", len(self.small))
        self.look(0)
        self.spheres.turn(self.wall, p.speed)
        recorded(self)
        results.add("outside", sum(map(self.beyond, self.spheres.states())))
        results.add("seconds", time.perf_counter() - began)
        results.add("steps", p.settle_steps + p.steps)
        results.add("verdict", "finished")

    def look(self, step):
        """Write the places of all, so many steps after the drum has begun to turn."""
        places = [place for _, _, place, _, _ in self.spheres.states()]
        self.series.add(self.p.settle_steps + step, *(x for axis in zip(*places) for x in axis))

    def beyond(self, state):
        """Return whether a centre is beyond the walls, or no number."""
        x, y, z = state[2]
        inside = math.hypot(x, z) <= stretch(self.p.facets) * self.p.drum_radius
        return not (inside and abs(y) <= 0.5 * self.p.drum_length)


class Spheres:
    """Spheres between walls of triangles in Kratos; numbers are those of ``add``, places in m."""

    REACH = 0.8
    """Radii of the smallest sphere within which contacts are searched for beforehand."""

    def __init__(self, p, materials, pairs):
        self.p, self.radii, self.held, self.faces = p, [], set(), 0
        self.turns, self.wall_speed = None, 0.0
        self.model = Kratos.Model()
        self.parts = parts_of(self.model, (*NODAL, *TURNING))
        for name in FACES:
            self.parts[2].AddNodalSolutionStepVariable(variable(name))
        self.nodes, self.masses = [], []
        self.densities = [density for _, _, density in materials]
        self.materials = [self.material(n, *material) for n, material in enumerate(materials, 1)]
        for (one, other), (restitution, friction) in pairs.items():
            for first, second in {(one, other), (other, one)}:
                contact = self.contact(second + 1, restitution, friction)
                self.materials[first].AddSubProperties(contact)

    def material(self, number, young, poisson, density):
        """Return a new material."""
        made = self.parts[0].CreateNewProperties(number)
        made[variable("YOUNG_MODULUS")], made[variable("POISSON_RATIO")] = young, poisson
        made[variable("PARTICLE_DENSITY")] = density
        made[variable("COMPUTE_WEAR")] = False
        integrate(made, self.p.scheme)
        return made

    def contact(self, number, restitution, friction):
        """Return the contact with the material of a number, with Kratos's own dashpot."""
        made = Kratos.Properties(number)
        made[variable("STATIC_FRICTION")] = made[variable("DYNAMIC_FRICTION")] = friction
        for name in ("FRICTION_DECAY", "ROLLING_FRICTION"):
            made[variable(name)] = 0.0
        made[variable("COEFFICIENT_OF_RESTITUTION")] = restitution
        made[variable("DAMPING_GAMMA")] = ExplicitStrategy.GammaForHertzThornton(None, restitution)
        DEM.DEM_D_Hertz_viscous_Coulomb().SetConstitutiveLawInProperties(made, False)
        return made

    def add(self, material, place, radius, held=False):
        """Add a sphere and return its number."""
        number = len(self.nodes) + 1
        node = self.parts[0].CreateNewNode(number, *place)
        self.parts[0].CreateNewElement(
            "SphericParticle3D", number, [number], self.materials[material]
        )
        node.SetSolutionStepValue(variable("RADIUS"), 0, radius)
        self.nodes.append(node)
        self.radii.append(radius)
        self.masses.append(4 / 3 * math.pi * radius**3 * self.densities[material])
        if held:
            self.held.add(number - 1)
        return number - 1

    def wall(self, material, place, normal, size):
        """Add a wall: a triangle in the plane through a place, of an inscribed radius."""
        return self.triangles(material, [plane(place, normal, size)])

    def triangles(self, material, faces):
        """Add triangles, rigid faces of three nodes of their own; return these: the wall."""
        part, wall = self.parts[2], []
        for corners in faces:
            self.faces += 1
            numbers = [3 * self.faces + i for i in range(3)]
            wall += [part.CreateNewNode(n, *corner) for n, corner in zip(numbers, corners)]
            part.CreateNewCondition("RigidFace3D3N", self.faces, numbers, self.materials[material])
        return wall

    def remove_wall(self, wall):
        """Take a wall away: far from all."""
        for node in wall:
            node.X0, node.X = node.X0 + AWAY, node.X + AWAY
        self.until_search = 0

    def turn(self, wall, speed):
        """Let a wall turn about the y axis [rad/s], from now on."""
        part = self.parts[2].CreateSubModelPart("turning")
        part.AddNodes([node.Id for node in wall])
        numbers = {
            "VELOCITY_START_TIME": 0.0, "VELOCITY_STOP_TIME": 0.0, "VELOCITY_PERIOD": 0.0,
            "ANGULAR_VELOCITY_START_TIME": 0.0, "ANGULAR_VELOCITY_STOP_TIME": 1e9,
            "ANGULAR_VELOCITY_PERIOD": 0.0, "FIXED_MESH_OPTION": False, "RIGID_BODY_MOTION": True,
        }  # fmt: skip
        for name, value in numbers.items():
            part[variable(name)] = value
        for name in ("LINEAR_VELOCITY", "DISPLACEMENT", "ROTATION_CENTER"):
            part[variable(name)] = Kratos.Array3([0.0, 0.0, 0.0])
        part[variable("ANGULAR_VELOCITY")] = Kratos.Array3([0.0, speed, 0.0])
        self.turns, self.turned = DEM.DEMFEMUtilities(), 0
        self.wall_speed = abs(speed) * max(math.hypot(node.X, node.Z) for node in wall)
        self.until_search = 0

    def move_walls(self):
        """Move walls that turn by a step."""
        if self.turns:
            self.turned += 1
            h = self.p.step_size
            self.turns.MoveAllMeshes(self.parts[2], self.turned * h, h)

    def lift(self, wall):
        """Return the force of a wall on the spheres, upward [N], of the last step."""
        return -sum(node.GetSolutionStepValue(variable("CONTACT_FORCES_Z")) for node in wall)

    def remove_below(self, height):
        """Take spheres away whose centres are below a height."""
        below = [node for node in self.nodes if height > node.Z]
        if below:
            destroyer = DEM.ParticleCreatorDestructor()
            for node in below:
                node.Set(Kratos.TO_ERASE, True)
                self.parts[0].GetElement(node.Id).Set(Kratos.TO_ERASE, True)
            destroyer.DestroyMarkedParticles(self.parts[0])
            self.strategy.RebuildListOfDiscontinuumSphericParticles()
            # it erases those that are marked, some of them with the next search
            if self.parts[0].NumberOfElements() < len(self.nodes) - len(below):
                sys.exit("ERROR: Kratos erased other spheres than those below")
            gone = {node.Id for node in below}
            kept = [i for i, node in enumerate(self.nodes) if node.Id not in gone]
            for name in ("nodes", "radii", "masses"):
                setattr(self, name, [getattr(self, name)[i] for i in kept])
            self.until_search = 0

    def start(self):
        """Let Kratos take a first look at what was added."""
        p, info = self.p, self.parts[0].ProcessInfo
        for axis in "XYZ":
            for name in (f"VELOCITY_{axis}", f"ANGULAR_VELOCITY_{axis}"):
                Kratos.VariableUtils().AddDof(variable(name), self.parts[0])
        for number in self.held:
            self.fix(self.nodes[number], held=True)
        self.reach = self.REACH * min(self.radii)
        info[variable("GRAVITY")] = Kratos.Array3([0.0, 0.0, -p.gravity])
        info[variable("DELTA_TIME")] = p.step_size
        info[variable("NODAL_MASS_COEFF")] = 1.0
        info[variable("ROTATION_OPTION")] = 1
        info[variable("SEARCH_CONTROL")] = 1
        # its first search alone goes by the first of them, every later one by the second
        info[variable("SEARCH_RADIUS_INCREMENT")] = self.reach
        info[variable("SEARCH_RADIUS_INCREMENT_FOR_WALLS")] = self.reach
        self.strategy = strategy_of(self.parts, p.scheme, p.step_size, self.reach, walls=True)
        self.strategy.Initialize()
        self.until_search = 0

    def fix(self, node, held):
        """Hold a sphere, or let it go."""
        for axis in "XYZ":
            for name in (f"VELOCITY_{axis}", f"ANGULAR_VELOCITY_{axis}"):
                (node.Fix if held else node.Free)(variable(name))

    def advance(self, steps, every=0, look=None):
        """Take steps; ``look`` is called with their number after every so many of them."""
        info, solve = self.parts[0].ProcessInfo, self.strategy.SolveSolutionStep
        for step in range(1, steps + 1):
            self.move_walls()
            if self.until_search == 0:
                self.until_search = self.steps_to_search()
                info[TIME_STEPS] = 1
                solve()
                info[TIME_STEPS] = 0
            else:
                solve()
            self.until_search -= 1
            if every and step % every == 0:
                look(step)
            if step % TELL == 0:
                print(f"step {step}", flush=True)

    def steps_to_search(self):
        """Return after how many steps the next search but this one comes.

        What a search finds is right until a pair that it left out has closed in by the reach. The
        fastest shall move by 0.3 of it: what it hits is at most twice as fast, and 0.3 + 0.6 < 1.
        """
        speeds = [math.hypot(*node.GetSolutionStepValue(Kratos.VELOCITY)) for node in self.nodes]
        fastest = max([math.sqrt(2 * self.p.gravity * self.reach), self.wall_speed, *speeds])
        if not all(map(math.isfinite, speeds)):
            sys.exit("a velocity is not a number")
        return min(50, max(1, int(0.3 * self.reach / fastest / self.p.step_size)))

    def release(self, number, velocity):
        """Let a sphere that was held go, with a velocity."""
        self.fix(self.nodes[number], held=False)
        self.strategy.ResetPrescribedMotionFlagsRespectingImposedDofs()
        for axis, v in zip("XYZ", velocity):
            self.nodes[number].SetSolutionStepValue(variable(f"VELOCITY_{axis}"), 0, v)
        self.until_search = 0

    def states(self):
        """Return mass, radius, place, velocity and spin of each sphere."""
        states = []
        for mass, radius, node in zip(self.masses, self.radii, self.nodes):
            velocity = node.GetSolutionStepValue(Kratos.VELOCITY)
            spin = node.GetSolutionStepValue(Kratos.ANGULAR_VELOCITY)
            states.append((mass, radius, (node.X, node.Y, node.Z), tuple(velocity), tuple(spin)))
        return states


TELL = 1000
"""Steps between lines on the screen."""

AWAY = 1e3
"""[m]: farther than anything."""


def run(p):
    """Run one drum."""
    Drum(p).run()


# of spheres that turn
TURNING = (
    "PARTICLE_MOMENT_OF_INERTIA", "ROLLING_RESISTANCE_MOMENT", "ROLLING_FRICTION",
    "LOCAL_AUX_ANGULAR_VELOCITY", "AUX_ORIENTATION",
)  # fmt: skip
# all that Kratos's rigid faces read or write
FACES = (
    "ELASTIC_FORCES", "DEM_PRESSURE", "TANGENTIAL_ELASTIC_FORCES", "SHEAR_STRESS",
    "DEM_NODAL_AREA", "CONTACT_FORCES", "TOTAL_FORCES", "VELOCITY", "DELTA_DISPLACEMENT",
    "DISPLACEMENT", "NON_DIMENSIONAL_VOLUME_WEAR", "IMPACT_WEAR", "ANGULAR_VELOCITY",
)  # fmt: skip


def variable(name):
    """Return a variable of Kratos, of its core or of the DEM application."""
    return getattr(Kratos, name, None) or getattr(DEM, name)


TIME_STEPS, VELOCITY_X, VELOCITY_Y = map(variable, ("TIME_STEPS", "VELOCITY_X", "VELOCITY_Y"))
# all that Kratos's spheres read or write, here or not: what is missing is not checked
NODAL = (
    "VELOCITY", "DISPLACEMENT", "DELTA_DISPLACEMENT", "TOTAL_FORCES", "CONTACT_FORCES",
    "ELASTIC_FORCES", "RIGID_ELEMENT_FORCE", "LOCAL_CONTACT_FORCE", "DAMP_FORCES",
    "FORCE_REACTION", "MOMENT_REACTION", "EXTERNAL_APPLIED_FORCE", "EXTERNAL_APPLIED_MOMENT",
    "PARTICLE_MOMENT", "ANGULAR_VELOCITY", "LOCAL_ANGULAR_VELOCITY", "DELTA_ROTATION",
    "PARTICLE_ROTATION_ANGLE", "ORIENTATION", "ANGULAR_MOMENTUM", "RADIUS", "NODAL_MASS",
    "REPRESENTATIVE_VOLUME", "NEIGHBOUR_SIZE", "DAMAGE_RATIO", "PARTICLE_MATERIAL",
    "NORMAL_IMPACT_VELOCITY", "TANGENTIAL_IMPACT_VELOCITY", "FACE_NORMAL_IMPACT_VELOCITY",
    "FACE_TANGENTIAL_IMPACT_VELOCITY", "LINEAR_IMPULSE",
)  # fmt: skip
STRATEGY = """{
    "strategy": "sphere_strategy", "do_search_dem_neighbours": true,
    "do_search_fem_neighbours": %s, "RemoveBallsInitiallyTouchingWalls": false,
    "model_import_settings": {}, "material_import_settings": {}
}"""


def parts_of(model, nodal):
    """Return the parts of a new model; its spheres have the variables of these names."""
    names = ("SpheresPart", "ContactPart", "RigidFacePart", "DEMInletPart", "ClusterPart")
    parts = [model.CreateModelPart(name) for name in names]
    for name in nodal:
        parts[0].AddNodalSolutionStepVariable(variable(name))
    return parts


def integrate(material, scheme):
    """Let spheres of a material move by a scheme, without a damping of their motion."""
    made = getattr(DEM, scheme.replace("_", "") + "Scheme")()
    made.SetTranslationalIntegrationSchemeInProperties(material, False)
    made.SetRotationalIntegrationSchemeInProperties(material, False)
    DEM.DEMGlobalDampingNonViscousCstForceDir().SetGlobalDampingModelInProperties(material, False)


def strategy_of(parts, scheme, step, reach, walls):
    """Return Kratos's strategy for the parts of a model, which finds contacts within a reach."""
    settings = DEM.ExplicitSolverSettings()
    settings.r_model_part, settings.contact_model_part = parts[:2]
    settings.fem_model_part, settings.inlet_model_part = parts[2:4]
    settings.cluster_model_part = parts[4]
    verlet = scheme == "Velocity_Verlet"
    kind = DEM.IterativeSolverStrategy if verlet else DEM.ExplicitSolverStrategy
    # the third number: every step with TIME_STEPS above 0 searches, none with 0
    strategy = kind(
        settings, step, 1, 1.0, 1, DEM.ParticleCreatorDestructor(), DEM.DEM_FEM_Search(),
        DEM.OMP_DEMSearch(), Kratos.Parameters(STRATEGY % ("true" if walls else "false")),
    )  # fmt: skip
    strategy.RebuildListOfDiscontinuumSphericParticles()
    strategy.SetNormalRadiiOnAllParticlesBeforeInitilization(parts[0])
    strategy.SetSearchRadiiOnAllParticles(parts[0], reach, 1.0)
    return strategy


def main():
    """Run what the command line names."""
    if "OMP_NUM_THREADS" not in os.environ:  # of a few spheres more threads only wait
        Kratos.ParallelUtilities.SetNumThreads(1)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    for p in runs():
        run(p)


if __name__ == "__main__":
    main()
