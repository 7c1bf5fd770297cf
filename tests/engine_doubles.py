"""The reference under other names, and with faults, in place of other engines."""

from dataclasses import replace

from harness.engines.reference import Reference
from harness.errors import EngineCrashError, EngineError, Unsupported


class Twin(Reference):
    """The reference with faults: of the scenes that it is given, or of the motions that it returns.

    It keeps the jobs that it ran.
    """

    name = "twin"
    traits = replace(
        Reference.traits, install_hint="apt install it", lineage="LAMMPS", title="Twin"
    )

    def __init__(self, change_scene=lambda scene: scene, change_motion=lambda _, motion: motion):
        super().__init__()
        self.change_scene, self.change_motion, self.jobs = change_scene, change_motion, []

    def motions(self, jobs):
        self.jobs += jobs
        changed = [replace(job, scene=self.change_scene(job.scene)) for job in jobs]
        pairs = zip(jobs, super().motions(changed), strict=True)
        return [m if isinstance(m, EngineError) else self.change_motion(j.scene, m)
                for j, m in pairs]  # fmt: skip


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
