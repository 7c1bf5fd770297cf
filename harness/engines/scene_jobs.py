"""Scenes of spheres and walls as jobs of engines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from harness.engines.contract import SCENE_NAME, Job, Template, Value

if TYPE_CHECKING:
    from harness.model.scene import Scene

SCENE = Template(SCENE_NAME, {"": {}})


def scene_job(scene: Scene, **values: Value) -> Job:
    """Return the job of a scene; ``values`` are ``units`` (si, lj) and the name of a variation."""
    return Job(SCENE, values, sampled=True, scene=scene)
