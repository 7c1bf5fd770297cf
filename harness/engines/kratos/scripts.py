"""The generated scripts for Kratos: rendered from templates, and what a case sets in them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Literal

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.engines import input_values
from harness.engines.input_values import Values, check_overlap_law, drop_values
from harness.parameters.contact import PLASTIC, Contact
from harness.parameters.tower import Tower

Scheme = Literal["Velocity_Verlet", "Symplectic_Euler"]
"""Kratos's names of its integrators."""

RELEASES = ("10.2.3", "10.4.3", "10.4.4")
"""With which the scripts were tried."""

FOLDER = "kratos"
"""Below ``inputs``."""

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None, tail="clipped")
"""The contact of the drop's script as it stands."""

WHO = "Kratos"


@dataclass(frozen=True)
class Script:
    """A Python script for Kratos, ready to be written and run."""

    name: str
    text: str

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the text, in hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()


@cache
def drop_script() -> Script:
    """Return the script of a grain on one fixed sphere, a head-on collision by default."""
    return _script(
        "drop.py",
        drop_values(Drop(contact=HEAD_ON, gap=1e-3, speed=1.0)),
        title="A grain meets one fixed sphere: what tells the rules of a contact.",
        example="restitution=0.8 effective_mass=half",
        story="The sphere's centre is the origin, the grain starts above it.",
    )


@cache
def incline_script() -> Script:
    """Return the script of the incline, with the plastic contact as default."""
    return _script(
        "incline.py",
        {**incline_values(Incline(contact=PLASTIC, steps_per_contact=100.0)), "route": "steady"},
        title="The frictionless incline: a grain slides over a row of fixed, touching spheres.",
        example="angle=10.5 stiffness=1e7 steps_per_contact=200",
        story=(
            "The verdict is moves_on (the grain passes the crests), trapped (it turned back in a\n"
            "well, with less energy than the crest asks for) or undecided (the time limit came\n"
            "first: this is not trapped). Theory: motion persists from 10.2078 deg on."
        ),
    )


@cache
def tower_script() -> Script:
    """Return the tower's script, with the source's tower of three particles as default."""
    return _script(
        "tower.py",
        {**tower_values(Tower(height=2, law="overlap"), 3.0, 1000.0), "series_every": 4},
        title="The tower: a grain runs into a row of equal spheres at rest.",
        example="height=19 stiffness=1e7 speed=4",
        story=(
            "The grain is particle 1, the base the last; motion and gravity are along x. The\n"
            "force on a particle is that of its contacts alone, without damping."
        ),
    )


def input_files() -> dict[str, str]:
    """Return the scripts by their names below ``inputs``."""
    scripts = (incline_script(), tower_script(), drop_script())
    return {f"{FOLDER}/{script.name}": script.text for script in scripts}


def incline_values(case: Incline) -> Values:
    """Return the parameters of an incline; its row is endless, however many spheres it has."""
    return {**input_values.incline_values(case), "phase": case.phase}


def tower_values(case: Tower, duration: float, steps_per_contact: float) -> Values:
    """Return the parameters of a tower of equal particles, over a duration in t0.

    Raise RequestError for what the script cannot state: unequal particles, the
    deformable law.
    """
    check_overlap_law(case, WHO)
    return input_values.tower_values(case, duration, steps_per_contact, WHO)


def words_of(values: Values) -> str:
    """Return the parameters as a script takes them, numbers at full digits."""
    return " ".join(f"{name}={value}" for name, value in values.items())


def _script(name: str, values: Values, **prose: str) -> Script:
    from jinja2 import BaseLoader, Environment, StrictUndefined, TemplateNotFound

    class Templates(BaseLoader):
        def get_source(self, environment: Environment, template: str) -> tuple[str, None, None]:  # noqa: ARG002
            path = resources.files("harness.engines.kratos").joinpath("templates", template)
            if not path.is_file():
                raise TemplateNotFound(template)
            return path.read_text(encoding="utf-8").rstrip("\n"), None, None

    environment = Environment(
        loader=Templates(), undefined=StrictUndefined, trim_blocks=False, autoescape=False
    )
    body = environment.get_template(f"{name}.j2")
    text = body.render(
        {
            "name": name,
            "version": __version__,
            "releases": ", ".join(RELEASES),
            "scheme": "Velocity_Verlet",
            "series": name.removesuffix(".py") + ".csv",
            **prose,
            **values,
        }
    )
    return Script(name, text + "\n")
