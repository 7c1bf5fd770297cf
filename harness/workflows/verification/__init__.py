"""The main job: theory, LAMMPS on the incline, comparison."""

from harness.workflows.verification.run import verify

__all__ = ["verify"]
