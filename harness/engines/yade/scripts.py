"""The generated Yade scripts: rendered from templates, and what a case sets in them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cache
from importlib import resources

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.tower.timing import Plan, plan
from harness.engines import input_values
from harness.engines.input_values import Values, check_overlap_law, drop_values
from harness.parameters.contact import PLASTIC, Contact
from harness.parameters.tower import Tower

WHO = "Yade"

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None, tail="clipped")
"""The contact of the drop's script as it stands."""


@dataclass(frozen=True)
class Script:
    """A Yade script, ready to be written and run; ``name`` is that of its file."""

    name: str
    text: str

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the text, in hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()


@cache
def incline_script() -> Script:
    """Return the incline's script, with the plastic contact as default."""
    case = Incline(contact=PLASTIC, steps_per_contact=100.0)
    return _script("incline.py", {**incline_values(case), "restitution": 0.0})


@cache
def drop_script() -> Script:
    """Return the script of a grain on one fixed sphere, a head-on collision by default."""
    case = Drop(contact=HEAD_ON, gap=1e-3, speed=1.0)
    return _script("drop.py", drop_values(case))


@cache
def tower_script() -> Script:
    """Return the tower's script, with the source's tower of three particles as default."""
    case = Tower(height=2, law="overlap")
    return _script("tower.py", tower_values(case, plan(case, 3.0, 1000.0, None)))


def input_files() -> dict[str, str]:
    """Return the scripts by their names below ``inputs``."""
    scripts = (incline_script(), drop_script(), tower_script())
    return {f"yade/{script.name}": script.text for script in scripts}


def incline_values(case: Incline) -> Values:
    """Return what a case sets in the incline's script; floats keep every digit in JSON."""
    return {**input_values.incline_values(case), "spheres": case.spheres, "phase": case.phase}


def tower_values(case: Tower, timing: Plan) -> Values:
    """Return what a tower of equal particles under the overlap law sets in its script.

    Raise RequestError for unequal particles or the deformable law, which the script does not have.
    """
    check_overlap_law(case, WHO)
    values = input_values.tower_values(case, timing.duration, timing.steps_per_contact, WHO)
    return {**values, "series_every": timing.every}


def _script(name: str, values: Values) -> Script:
    """Return a script rendered from the template of its name; values stand as Python writes them.

    Numbers as ``repr`` writes them read back as they were.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = resources.files("harness.engines.yade").joinpath("templates")
    environment = Environment(
        loader=FunctionLoader(lambda file: folder.joinpath(file).read_text(encoding="utf-8")),
        undefined=StrictUndefined,
        keep_trailing_newline=False,
        autoescape=False,
        finalize=lambda value: repr(value) if isinstance(value, float) else value,
    )
    text = environment.get_template(f"{name}.j2").render(version=__version__, **values)
    return Script(name, text + "\n")
