"""Engines beside LAMMPS: each qualifies, then is held against theory, reference DEM and exact."""

from harness.workflows.verification.other_engines.asked import Asked, asked_engines
from harness.workflows.verification.other_engines.run import Found, Open, engine_checks

__all__ = ["Asked", "Found", "Open", "asked_engines", "engine_checks"]
