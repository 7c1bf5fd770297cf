"""External forces: contact laws that LAMMPS lacks and calls back for, by the value of ``law``.

The script has ``fix <law> all external pf/callback 1 1``; the law is set up at the line of the
script that begins with :data:`MOTION`, after the particles are there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import import_module
from typing import Any

FORCES = {"deformable": "harness.engines.lammps.deformable:DeformableLaw"}
"""Where each law's class is, whose ``of`` makes it from the values of a job."""

MOTION = re.compile(r"^# ---- motion.*$", re.MULTILINE)


def run_with_force(lammps: Any, script: str, values: Mapping[str, str]) -> None:
    """Run a script whose variable ``law`` names a force of :data:`FORCES`.

    Raise RuntimeError for what goes wrong in the force.
    """
    parts = MOTION.split(script)
    if len(parts) != 2:
        raise RuntimeError("ERROR: the script has no one line '# ---- motion' for its force")
    name = values["law"]
    module, _, kind = FORCES[name].partition(":")
    law = getattr(import_module(module), kind).of(values)
    lammps.commands_string(parts[0])
    lammps.set_fix_external_callback(name, law, None)
    try:
        lammps.commands_string(parts[1].removeprefix("\n"))
    finally:
        if law.failure:
            raise RuntimeError(f"ERROR: {law.failure}")
