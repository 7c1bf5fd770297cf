"""The main job: theory, LAMMPS on the incline, comparison."""

from harness.verbs.verification.run import verify

__all__ = ["verify"]
