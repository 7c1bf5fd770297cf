"""The generated LAMMPS scripts: rendered from templates, and what a case sets in them."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.engines import input_values
from harness.parameters.contact import CONTACTS, PLASTIC, Contact
from harness.parameters.tower import Tower

STORIES = {
    "source": "e = 1e-20 with the attractive tail, as Harper, Dufek and Breard ran it.",
    "clipped": "critical damping, tail clipped; it rebounds with e = exp(-2) = 0.135.",
    "plastic": "overdamped and clipped: no tail, no rebound; the one to extrapolate.",
}

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None)
"""The contact of the drop's script as it stands."""


@dataclass(frozen=True)
class Script:
    """A LAMMPS script, ready to be written and run.

    ``variables`` are the names that ``-var`` may set.
    """

    name: str
    text: str
    variables: frozenset[str]

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the text, in hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def names(self) -> frozenset[str]:
        """Return every variable that the text declares, of whatever style."""
        return frozenset(re.findall(r"\bvariable (\w+)\s", self.text))


def names_to_forget(script: Script) -> list[str]:
    """Return the variables that may be left from an earlier run, of this script or another.

    LAMMPS's ``clear`` keeps variables: they would shadow defaults, or refuse
    another style.
    """
    return sorted(script.names.union(*(other.names for other in all_scripts())))


@cache
def incline_script(contact_name: str = PLASTIC.name) -> Script:
    """Return the incline's script with the defaults of a named contact.

    Every parameter can be overridden by a variable, so a contact without a
    name of its own runs the plastic one's script with other values.
    """
    contact = CONTACTS.get(contact_name, PLASTIC)
    case = Incline(contact=contact, steps_per_contact=100.0 if contact is PLASTIC else 50.0)
    name = f"incline-{contact.name}.in"
    defaults = {"route": "steady", **incline_variables(case)}
    text = _render(
        "incline.in.j2", name=name, contact=contact, story=STORIES[contact.name], **defaults
    )
    return Script(name, text, _declared(text))


@cache
def tower_script() -> Script:
    """Return the tower's script, with the source's tower of three particles as default."""
    case = Tower(height=2, law="overlap")
    defaults = {**tower_variables(case, 3.0, 1000.0), "restitution": "1", "series_every": "4"}
    text = _render("tower.in.j2", name="tower.in", **defaults)
    return Script("tower.in", text, _declared(text))


@cache
def drop_script() -> Script:
    """Return the script of a grain on one fixed sphere, a head-on collision by default."""
    case = Drop(contact=HEAD_ON, gap=1e-3, speed=1.0)
    text = _render("drop.in.j2", name="drop.in", **drop_variables(case))
    return Script("drop.in", text, _declared(text))


def all_scripts() -> list[Script]:
    """Return every script that is committed under ``inputs``."""
    return [*(incline_script(name) for name in CONTACTS), tower_script(), drop_script()]


def input_files() -> dict[str, str]:
    """Return the scripts by their names below ``inputs``."""
    return {script.name: script.text for script in all_scripts()}


def drop_variables(case: Drop) -> dict[str, str]:
    """Return what ``-var`` sets for a drop, at full precision."""
    return texts({**input_values.drop_values(case), "tail": case.contact.tail})


def incline_variables(case: Incline) -> dict[str, str]:
    """Return what ``-var`` sets for a case, at full precision."""
    row: input_values.Values = {"spheres": case.spheres, "phase": case.phase}
    return texts({**input_values.incline_values(case), **row, "tail": case.contact.tail})


def tower_variables(case: Tower, duration: float, steps_per_contact: float) -> dict[str, str]:
    """Return what ``-var`` sets for a tower of equal particles, over a duration in t0.

    Raise RequestError for unequal particles, which the script does not have.
    """
    values = input_values.tower_values(case, duration, steps_per_contact, "LAMMPS")
    return texts({**values, "law": case.law})


def texts(values: input_values.Values) -> dict[str, str]:
    """Return values as LAMMPS reads them."""
    return {k: _number(v) if isinstance(v, float) else str(v) for k, v in values.items()}


def _number(value: float) -> str:
    """Return the shortest text that reads back as the same number."""
    text = repr(float(value))
    return text.removesuffix(".0")


def _render(template: str, **values: object) -> str:
    from jinja2 import Environment, StrictUndefined

    source = resources.files("harness.engines.lammps").joinpath("templates", template)
    environment = Environment(
        undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True, autoescape=False
    )
    body = environment.from_string(source.read_text(encoding="utf-8"))
    return body.render(version=__version__, **values)


def _declared(text: str) -> frozenset[str]:
    """Return the names of the index variables that a script declares."""
    words = (line.split() for line in text.splitlines())
    return frozenset(w[1] for w in words if len(w) > 3 and w[0] == "variable" and w[2] == "index")


def check_variables(script: Script, variables: Mapping[str, str]) -> None:
    """Raise KeyError when a variable is not one of the script's: LAMMPS would ignore it."""
    unknown = set(variables) - script.variables
    if unknown:
        raise KeyError(f"{script.name} has no variable {', '.join(sorted(unknown))}")
