"""MFiX's inputs: the keyword file from its template, and the particles."""

from __future__ import annotations

import math
from importlib import resources

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.incline.routes import start_in_well
from harness.cases.tower.timing import plan
from harness.engines.mfix.recorded import CONTACT, START_SPEED
from harness.engines.mfix.system import (
    Sphere,
    System,
    drop_system,
    incline_system,
    tower_system,
)
from harness.parameters.tower import Tower

KEYWORDS, PARTICLES = "mfix.dat", "particle_input.dat"
"""The names that MFiX looks for."""

GRAIN, FORCE = "GRAIN", "FORCE"
"""Names of the files of particles and of contact forces, before ``_0000.vtp``."""

TITLES = {
    "INCLINE": "The frictionless incline: a grain slides over a row of fixed, touching spheres.",
    "DROP": "A grain that meets one fixed sphere.",
    "TOWER": "The tower: a grain runs into a row of equal spheres at rest.",
}


def keyword_file(system: System) -> str:
    """Return the text of ``mfix.dat``."""
    width, height = system.box
    regions = [{"name": GRAIN, "data": "P"}]
    story = ""
    if system.forces:
        regions.append({"name": FORCE, "data": "F"})
        story = "\n# FORCE_0000.vtp ...: the contact forces of the step before."
    return _render(
        version=__version__,
        title=TITLES[system.name],
        name=system.name,
        force_story=story,
        held=bool(system.held),
        # half a step less: MFiX rounds the number of steps up, in single precision
        stop=_number((system.steps - 0.5) * system.step),
        gravity_x=_number(system.gravity[0]),
        gravity_y=_number(system.gravity[1]),
        width=_number(width),
        height=_number(height),
        columns=_cells(width, system.diameter),
        rows=_cells(height, system.diameter),
        diameter=_number(system.diameter),
        density=_number(system.density),
        particles=len(system.mobile) + len(system.held),
        stiffness=_number(system.stiffness),
        restitution=_number(system.restitution),
        factor=_number(system.factor),
        interval=_number(system.every * system.step),
        regions=regions,
    )


def particle_file(system: System) -> str:
    """Return the text of ``particle_input.dat``, version 1 in two dimensions.

    A line each, mobile ones first: x, y, radius, density, vx, vy.
    """
    radius, density = 0.5 * system.diameter, system.density

    def line(sphere: Sphere) -> str:
        values = (sphere.x, sphere.y, radius, density, sphere.vx, sphere.vy)
        return " ".join(_number(value) for value in values)

    return "".join(f"{line(sphere)}\n" for sphere in system.spheres)


def input_files() -> dict[str, str]:
    """Return an input of each system by its name below ``inputs``, a folder each."""
    incline = Incline(angle=10.22, contact=CONTACT, steps_per_contact=100.0)
    tower = Tower(height=2, law="overlap", stiffness=1e5)
    timing = plan(tower, 3.0, 1000.0, 1000)
    systems = {
        "incline": incline_system(incline, start_in_well(incline, START_SPEED), 10, 15.0, 50),
        "drop": drop_system(Drop(contact=CONTACT, gap=1e-3, speed=1.0, duration=15.0, every=50)),
        "tower": tower_system(tower, timing.step, timing.steps, timing.every),
    }
    files: dict[str, str] = {}
    for name, system in systems.items():
        files[f"mfix/{name}/{KEYWORDS}"] = keyword_file(system)
        files[f"mfix/{name}/{PARTICLES}"] = particle_file(system)
    return files


def _cells(length: float, diameter: float) -> int:
    """Return the number of cells, two diameters wide as in the recorded runs."""
    return max(3, math.floor(0.5 * length / diameter))


def _number(value: float) -> str:
    """Return the shortest Fortran double that reads back as the same number."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{point}d{int(exponent)}" if exponent else point


def _render(**values: object) -> str:
    from jinja2 import Environment, StrictUndefined

    source = resources.files(__package__).joinpath("templates", "mfix.dat.j2")
    environment = Environment(
        undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True, autoescape=False
    )
    return environment.from_string(source.read_text(encoding="utf-8")).render(**values)
