"""MFiX's inputs: the keyword file from its template, and the particles."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np

from harness.engines.contact_model import stating
from harness.engines.contract import Template
from harness.engines.mfix.contact_input import ContactInput
from harness.engines.mfix.contacts import CONTACTS
from harness.engines.mfix.declared import CONTACT
from harness.engines.mfix.system import System, system_of
from harness.engines.rendering import renderer
from harness.engines.scene import LOOK
from harness.parameters.contact import contact_values

KEYWORDS, PARTICLES = "mfix.dat", "particle_input.dat"
"""The names that MFiX looks for."""

GRAIN, FORCE = "GRAIN", "FORCE"
"""Names of the files of particles and of contact forces, before ``_0000.vtp``."""

SEARCH_CELL = 2.4
"""[d] least width of the cells of the neighbour search, which looks half a cell about a particle:
neighbours are lost where half a cell is less than a diameter."""


def states_contact(template: Template) -> bool:
    """Return whether there is an input for contacts by the name of a template."""
    return _templates().joinpath(f"{template.name}.dat.j2").is_file()


def contact_files(contact: ContactInput, title: str = "") -> dict[str, str]:
    """Return the inputs of a contact with friction, by their names."""
    told = {"title": title or "A contact with friction.", **contact.context()}
    return {
        KEYWORDS: _render("contacts.dat.j2", particles=len(contact.balls), **_written(told)),
        PARTICLES: _lines(contact.particles()),
    }


def system_files(system: System, title: str = "") -> dict[str, str]:
    """Return the inputs of a system, by their names."""
    return {KEYWORDS: keyword_file(system, title), PARTICLES: particle_file(system)}


def keyword_file(system: System, title: str = "") -> str:
    """Return the text of ``mfix.dat``; its title is the system's name unless given."""
    width, height = system.box
    regions = [{"name": GRAIN, "data": "P"}]
    if system.forces:
        regions.append({"name": FORCE, "data": "F"})
    return _render(
        "mfix.dat.j2",
        title=title or system.name,
        name=system.name,
        forces=system.forces,
        held=bool(system.held),
        # half a step less: MFiX rounds the number of steps up, in single precision
        stop=_number((system.first + system.steps - 0.5) * system.step),
        start=_number(system.first * system.step) if system.first else "",
        gravity_x=_number(system.gravity[0]),
        gravity_y=_number(system.gravity[1]),
        width=_number(width),
        height=_number(height),
        columns=_cells(width, system.diameter),
        rows=_cells(height, system.diameter),
        search_columns=_search_cells(width, system.diameter),
        search_rows=_search_cells(height, system.diameter),
        diameter=_number(system.diameter),
        density=_number(system.density),
        particles=len(system.mobile) + len(system.held),
        stiffness=_number(system.stiffness),
        restitution=_number(system.restitution),
        factor=_number(system.factor),
        scheme=system.scheme,
        interval=_number(system.every * system.step),
        regions=regions,
    )


def particle_file(system: System) -> str:
    """Return the text of ``particle_input.dat``, version 1 in two dimensions.

    A line each, mobile ones first: x, y, radius, density, vx, vy.
    """
    radius, density = 0.5 * system.diameter, system.density
    return _lines((s.x, s.y, radius, density, s.vx, s.vy) for s in system.spheres)


def _lines(rows: Iterable[Iterable[float]]) -> str:
    return "".join(" ".join(map(_number, row)) + "\n" for row in rows)


def input_files(templates: Iterable[Template]) -> dict[str, str]:
    """Return an input of each template that has an example, by its name below ``inputs``.

    An example ``templates/<template>.toml`` says in which values it differs from the template's
    main variant with the contact of the recorded runs, and has a title.
    """
    files: dict[str, str] = {}
    for template in templates:
        if states_contact(template):
            files |= _contact_examples(template)
        example = _templates().joinpath(f"{template.name}.toml")
        if template.scene is not None and example.is_file():
            known = tomllib.loads(example.read_text(encoding="utf-8"))
            system = _example(template, known)
            written = system_files(system, known["title"])
            files |= {f"mfix/{template.name}/{name}": text for name, text in written.items()}
    return files


def _contact_examples(template: Template) -> dict[str, str]:
    """Return the inputs of the variants of a contact that MFiX states as they stand."""
    files: dict[str, str] = {}
    for variant, values in template.variants.items():
        if stating(CONTACTS, values)[1]:
            continue
        title = f"A contact with friction: {template.notes[variant]}"
        written = contact_files(ContactInput(values), title)
        files |= {f"mfix/{template.name}-{variant}/{name}": t for name, t in written.items()}
    return files


def _example(template: Template, known: Mapping[str, Any]) -> System:
    """Return the system of a template's example."""
    assert template.scene is not None
    defaults = template.variants[template.main]
    contact = {name: v for name, v in contact_values(CONTACT).items() if name in defaults}
    scene = template.scene({**defaults, **contact, **known["values"]}, "linear")
    if "velocity" in known:
        velocity = np.array(scene.velocity)
        velocity[0] = known["velocity"]
        scene = replace(scene, velocity=velocity)
    return system_of(template.name, scene, scene.steps, scene.every or LOOK)


def _cells(length: float, diameter: float) -> int:
    """Return the number of cells, two diameters wide as in the recorded runs."""
    return max(3, math.floor(0.5 * length / diameter))


def _search_cells(length: float, diameter: float) -> int:
    """Return the number of cells of the neighbour search."""
    return max(1, math.floor(length / (SEARCH_CELL * diameter)))


def _number(value: float) -> str:
    """Return the shortest Fortran double that reads back as the same number."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{point}d{int(exponent)}" if exponent else point


def _written(told: Any) -> Any:
    """Return numbers of a template's values, at any depth, as Fortran reads them."""
    if isinstance(told, float):
        return _number(told)
    if isinstance(told, dict):
        return {name: _written(value) for name, value in told.items()}
    return [_written(one) for one in told] if isinstance(told, list) else told


def _render(template: str, **values: object) -> str:
    return renderer([_templates()], template, {})(values)


def _templates() -> Traversable:
    return resources.files(__package__).joinpath("templates")
