"""The reference under other names, and with faults, in place of other engines."""

from dataclasses import replace

import numpy as np

from harness.engines.reference import Reference
from harness.errors import EngineCrashError, EngineError, Unsupported
from harness.solvers import reference


def same(value):
    """Return a scene or an output as it is."""
    return value


class Twin(Reference):
    """The reference with faults, in place of an engine; it keeps the jobs that it ran.

    Functions change the scenes that it is given, the motions or the outputs that it returns.
    It declares ``declared`` rules, and runs under ``followed`` ones.
    """

    name = "twin"
    traits = replace(
        Reference.traits, install_hint="apt install it", lineage="LAMMPS", title="Twin"
    )

    def __init__(self, change_scene=same, change_motion=lambda _, motion: motion, *,
                 change_output=same, declared=None, followed=None):  # fmt: skip
        super().__init__(workers=1)
        self.change_scene, self.change_motion = change_scene, change_motion
        self.change_output, self.declared, self.followed = change_output, declared, followed
        self.jobs = []

    def rules(self, scene):
        return self.declared or super().rules(scene)

    def run(self, jobs):
        return [one if isinstance(one, EngineError) else self.change_output(one)
                for one in super().run(jobs)]  # fmt: skip

    def motions(self, jobs):
        self.jobs += jobs
        scenes = [self.scene_of(job) for job in jobs]
        found = [self._motion(self.change_scene(scene)) for scene in scenes]
        return [one if isinstance(one, EngineError) else self.change_motion(scene, one)
                for scene, one in zip(scenes, found, strict=True)]  # fmt: skip

    def _motion(self, scene):
        if self.followed is None:
            return super()._motion(scene)
        try:
            return reference.run(scene, self.followed)
        except EngineError as error:
            return error


ARRAYS = ("position", "velocity", "angular_velocity", "force", "torque")


def single(_, motion):
    """Return a motion in single precision: seven digits."""
    arrays = {name: getattr(motion, name) for name in (*ARRAYS, "stages")}
    return replace(motion, **{name: array if array is None else np.float64(np.float32(array))
                              for name, array in arrays.items()})  # fmt: skip


def lost(_, motion):
    """Return a motion without its last sample."""
    return replace(motion, **{name: getattr(motion, name)[:-1] for name in ("time", *ARRAYS)})


class FewDigits(Twin):
    """A code in single precision, which says so."""

    name = "few-digits"
    traits = replace(Twin.traits, digits=7)

    def __init__(self, *changes, **more):
        super().__init__(*(changes or (same, single)), **more)


class Clipping(Twin):
    """It never attracts."""

    name = "clipping"

    def rules(self, scene):
        if any(law.damping != "none" and not law.clipped for law in scene.all_laws):
            raise Unsupported("never attracts (clipped = True)")
        return super().rules(scene)


class Crashing(Twin):
    """It dies in each run."""

    name = "crashing"

    def motions(self, jobs):
        return [EngineCrashError("signal SIGSEGV").with_log("input\nlast words\n") for _ in jobs]
