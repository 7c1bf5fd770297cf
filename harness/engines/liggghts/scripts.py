"""The generated LIGGGHTS scripts, with the variables of the LAMMPS ones.

LIGGGHTS's language is that of LAMMPS of about 2011: no words in conditions, no formats,
no ``fix halt``. The same ``-var`` NAME VALUE set the same things.
"""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.engines.input_values import check_overlap_law, tower_values
from harness.engines.lammps.scripts import (
    HEAD_ON,
    STORIES,
    Script,
    drop_variables,
    incline_variables,
    texts,
)
from harness.parameters.contact import CONTACTS, PLASTIC
from harness.parameters.tower import Tower

WHO = "LIGGGHTS"

FOLDER = "liggghts"
"""Where the scripts are committed, below ``inputs``."""


@cache
def incline_script(contact_name: str = PLASTIC.name) -> Script:
    """Return the incline's script with the defaults of a named contact, else the plastic one."""
    contact = CONTACTS.get(contact_name, PLASTIC)
    case = Incline(contact=contact, steps_per_contact=100.0 if contact is PLASTIC else 50.0)
    return _script(
        "incline.in.j2",
        f"incline-{contact.name}.in",
        contact=contact,
        story=STORIES[contact.name],
        route="steady",
        **incline_variables(case),
    )


@cache
def tower_script() -> Script:
    """Return the tower's script, with the source's tower of three particles as default."""
    case = Tower(height=2, law="overlap")
    values = {**tower_variables(case, 3.0, 1000.0), "restitution": "1", "series_every": "4"}
    return _script("tower.in.j2", "tower.in", **values)


@cache
def drop_script() -> Script:
    """Return the script of a grain on one fixed sphere, a head-on collision by default."""
    case = Drop(contact=HEAD_ON, gap=1e-3, speed=1.0)
    return _script("drop.in.j2", "drop.in", **drop_variables(case))


def all_scripts() -> list[Script]:
    """Return every script that is committed."""
    return [*(incline_script(name) for name in CONTACTS), tower_script(), drop_script()]


def input_files() -> dict[str, str]:
    """Return the scripts by their names below ``inputs``."""
    return {f"{FOLDER}/{script.name}": script.text for script in all_scripts()}


def tower_variables(case: Tower, duration: float, steps_per_contact: float) -> dict[str, str]:
    """Return what ``-var`` sets for a tower of equal particles, over a duration in t0.

    Raise RequestError for the deformable law and for unequal particles.
    """
    check_overlap_law(case, WHO)
    return texts(tower_values(case, duration, steps_per_contact, WHO))


def _script(template: str, name: str, **values: object) -> Script:
    from jinja2 import Environment, StrictUndefined

    source = resources.files("harness.engines.liggghts").joinpath("templates", template)
    environment = Environment(
        undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True, autoescape=False
    )
    body = environment.from_string(source.read_text(encoding="utf-8"))
    text = body.render(version=__version__, name=name, **values)
    return Script(name, text, frozenset(re.findall(r"^variable (\w+) +index ", text, re.MULTILINE)))
