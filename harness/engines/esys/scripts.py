"""The generated ESyS-Particle scripts: rendered from templates, and what a case sets in them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.tower.timing import Plan
from harness.engines.contract import Route
from harness.engines.input_values import (
    Value,
    Values,
    check_overlap_law,
    drop_values,
    incline_values,
    tower_values,
)
from harness.parameters.contact import PLASTIC, Contact
from harness.parameters.tower import Tower

WHO = "ESyS-Particle"

SERIES = "series.csv"
"""The file that a run's motion is in."""


@dataclass(frozen=True)
class Script:
    """A script, ready to be written and run, and the parameters it has by default."""

    name: str
    text: str
    defaults: Mapping[str, Value]

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the text, in hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def arguments(self, values: Mapping[str, Value]) -> list[str]:
        """Return the words ``name=value`` of the command line, at full precision.

        Raise KeyError for a parameter that the script does not have.
        """
        unknown = set(values) - set(self.defaults)
        if unknown:
            raise KeyError(f"{self.name} has no parameter {', '.join(sorted(unknown))}")
        return [f"{name}={value!s}" for name, value in values.items()]


@cache
def drop_script() -> Script:
    """Return the script of a grain on one fixed sphere, a head-on collision by default."""
    contact = Contact(name="half", restitution=0.5, damping_ratio=None, tail="clipped")
    case = Drop(contact=contact, gap=1e-3, speed=1.0)
    defaults = {**drop_values(case), "mode": "hertz", "series": "drop.csv"}
    return _script("drop.py", "restitution=0.1 series=other.csv", defaults)


@cache
def incline_script() -> Script:
    """Return the incline's script, with the plastic contact as default."""
    case = Incline(contact=PLASTIC, steps_per_contact=100.0)
    defaults = {
        **incline_parameters([case], "passage", 50),
        "phases": "0",
        "speed": 0.48,
        "start": 10.0,
        "series": "grain.csv",
    }
    return _script("incline.py", "angle=10.5 stiffness=1e7 phases=0,0.5", defaults)


@cache
def tower_script() -> Script:
    """Return the tower's script, with the source's tower of three particles as default."""
    case = Tower(height=2, law="overlap")
    timing = Plan(3.0, 0.0, 0, 4, 1000.0)
    defaults = {**tower_parameters(case, timing), "series": "tower.csv"}
    return _script("tower.py", "height=19 stiffness=1e7 speed=4", defaults)


def all_scripts() -> list[Script]:
    """Return every script that is committed under ``inputs``."""
    return [incline_script(), tower_script(), drop_script()]


def input_files() -> dict[str, str]:
    """Return the scripts by their names below ``inputs``."""
    return {f"esys/{script.name}": script.text for script in all_scripts()}


def incline_parameters(cases: Sequence[Incline], route: Route, every: int) -> Values:
    """Return what cases that differ by their phases only set in the incline's script."""
    return {
        "route": route,
        **incline_values(cases[0]),
        "phases": ",".join(repr(case.phase) for case in cases),
        "series_every": every,
    }


def tower_parameters(case: Tower, timing: Plan) -> Values:
    """Return what a tower of equal particles sets in its script.

    Raise RequestError for what ESyS-Particle does not have: unequal particles (its
    stiffness belongs to the contact, not to a particle), the deformable law.
    """
    check_overlap_law(case, WHO)
    values = tower_values(case, timing.duration, timing.steps_per_contact, WHO)
    return {**values, "series_every": timing.every}


def _script(name: str, example: str, defaults: Mapping[str, Value]) -> Script:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("harness.engines.esys", "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    template = environment.get_template(f"{name}.j2")
    lines = "\n".join(f'    "{key}": {_literal(value)},' for key, value in defaults.items())
    text = template.render(version=__version__, name=name, example=example, defaults=lines)
    return Script(name, text, defaults)


def _literal(value: Value) -> str:
    """Return a value as Python writes it, strings in double quotes."""
    if isinstance(value, str):
        return f'"{value}"'
    return repr(value)
