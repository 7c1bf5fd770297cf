"""External forces: contact laws that LAMMPS lacks and calls back for, by the value of ``law``.

The script has ``fix <law> all external pf/callback 1 1``; the law is set up at the line of the
script that begins with :data:`MOTION`, after the particles are there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

FORCES = {"deformable": "harness.engines.lammps.deformable:DeformableLaw"}
"""Where each law's class is, whose ``of`` makes it from the values of a job."""

OVER_COLUMNS = "harness.engines.lammps.deformable:DeformableColumns"
"""The same where values speak of columns of ``n`` particles."""

MOTION = re.compile(r"^# ---- motion.*$", re.MULTILINE)


def run_with_force(lammps: Any, script: Path, values: Mapping[str, str]) -> None:
    """Run a script whose variable ``law`` names a force of :data:`FORCES`.

    As two files, beside the script: jumps find their labels within a file only. Raise RuntimeError
    for what goes wrong in the force.
    """
    parts = MOTION.split(script.read_text(encoding="utf-8"))
    if len(parts) != 2:
        raise RuntimeError("ERROR: the script has no one line '# ---- motion' for its force")
    setting, motion = (script.with_suffix(f".{name}") for name in ("setting", "motion"))
    setting.write_text(parts[0], encoding="utf-8")
    motion.write_text(parts[1], encoding="utf-8")
    name = values["law"]
    module, _, kind = (OVER_COLUMNS if "n" in values else FORCES[name]).partition(":")
    lammps.file(str(setting))
    law = getattr(import_module(module), kind).of(values, lammps)
    lammps.set_fix_external_callback(name, law, lammps)
    try:
        lammps.file(str(motion))
    finally:
        if law.failure:
            raise RuntimeError(f"ERROR: {law.failure}")
