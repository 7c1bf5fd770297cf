"""A small case, and engines that are the reference with planted faults, in place of real ones."""

import os
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

from pydantic import Field

from harness.cases.base import Case, Check, Quantity, Value
from harness.engines.base import scene_job
from harness.engines.output import SERIES
from harness.engines.reference import Reference
from harness.engines.scenes import motion_in
from harness.errors import EngineCrashError, EngineMissingError, Unsupported
from harness.model.base import Parameters
from harness.model.law import Law
from harness.model.scene import Scene, Wall, sphere
from harness.report.content import Discs, Section
from harness.results.rows import Kind, Tolerance

K, SPEED = 1e5, 1.0
PROJECT = Path(__file__).parents[2]
SAME = Tolerance(1e-12, reason="round-off")


class Bounce(Parameters):
    """A ball on a wall."""

    stiffness: float = Field(K, gt=0.0, le=1e12, description="[N/m] normal stiffness")
    restitution: float = Field(0.5, gt=0.0, le=1.0, description="[-] nominal")
    steps: int = Field(200, ge=10, le=10**6, description="[-] in the run")
    law: Law = Field(Law(normal_stiffness=K), description="[-] of friction")


class BounceCase(Case[Bounce]):
    """A ball hits a wall head on; the restitution of a clipped or free dashpot."""

    name, group, summary = "bounce", "balls", "A ball hits a wall head on."
    parameters = Bounce
    presets = {"usual": Bounce(), "stiff": Bounce(stiffness=1e7)}
    sources = {"stiff": "nobody 2020"}
    solvers = ("exact",)
    exact_by = "a clock"
    qualifies = True
    quantities = (
        Quantity("restitution", "1", "speed after over speed before"),
        Quantity("time_s", "s", "at the end"),
        Quantity("softest", "N/m", "stiffness of a search", varies=("stiffness",)),
    )

    def job(self, parameters):
        return scene_job(scene_of(parameters))

    def measure(self, parameters, output):
        motion = motion_in(output, scene_of(parameters))
        return {"restitution": motion.velocity[-1, 0, 2] / SPEED, "time_s": motion.time[-1]}

    def exact(self, parameters):
        return {"time_s": scene_of(parameters).duration}

    def solve(self, parameters, solver):
        return {"restitution": parameters.restitution, "time_s": scene_of(parameters).duration}

    def profile(self, parameters, output):
        return {"time_s": output.tables[SERIES]["time_s"].tolist()}

    def discs(self, parameters, output):
        motion = motion_in(output, scene_of(parameters))
        place = motion.position
        return Discs("ball", motion.time, place[:, :, 0], place[:, :, 2], place[0, :, 0] * 0 + 0.01)

    def search(self, names, parameters, bench, **options):
        soft, stiff = (self.restitution(parameters.replace(stiffness=k), bench) for k in (1e4, 1e5))
        return {"softest": Value(1e4, stiff - soft)}

    def checks(self, engine):
        for steps, level in ((200, "quick"), (400, "default"), (800, "full")):
            p = Bounce(steps=steps)
            expected = partial(self.reference_restitution, p)
            yield self.restitution_check(p, expected, level=level)

    def own_checks(self):
        yield Check(setup="200 steps", quantity="time_s", unit="s", kind=Kind.ANALYTIC,
                    measure=lambda bench: scene_of(Bounce()).duration,
                    expected=scene_of(Bounce()).duration, tolerance=SAME)  # fmt: skip

    def comparisons(self, engines):
        for engine in engines[1:]:
            yield engine, self.restitution_check(
                Bounce(), lambda bench: self.restitution(Bounce(), bench.others[engines[0].name]),
                check=engines[0].name,
            )  # fmt: skip

    def restitution_check(self, parameters, expected, **fields):
        return Check(
            setup=f"{parameters.steps} steps", quantity="restitution", unit="1", expected=expected,
            measure=partial(self.restitution, parameters), tolerance=SAME,
            jobs=[self.job(parameters)], **fields,
        )  # fmt: skip

    def restitution(self, parameters, bench):
        return self.measure(parameters, bench.output(self.job(parameters)))["restitution"]

    def reference_restitution(self, parameters, bench):
        return self.reference(parameters, bench)["restitution"]

    def sections(self, benches):
        return [Section("Bounce", ", ".join(sorted(benches)))]


def scene_of(parameters):
    ball = sphere(0.01, 2500.0, position=(0.0, 0.0, 0.01), velocity=(0.0, 0.0, -SPEED))
    law = Law(normal_stiffness=parameters.stiffness, damping="coeff_restitution",
              restitution=parameters.restitution)  # fmt: skip
    contact_time = 3.5 * (ball.mass / parameters.stiffness) ** 0.5
    return Scene(bodies=(ball,), walls=(Wall(),), law=law, step=contact_time / parameters.steps,
                 steps=parameters.steps)  # fmt: skip


class Good(Reference):
    """As the reference; counts its jobs."""

    name = "good"
    traits = replace(Reference.traits, versions=("1",), install_hint="make good")
    ran = 0

    def identify(self):
        return replace(super().identify(), engine=self.name, engine_version="1")

    def run(self, jobs):
        type(self).ran += len(jobs)
        return super().run(jobs)

    def fingerprint(self):
        return {"engine": self.name}

    def script_text(self, job):
        return f"run {job.scene.steps}\n"


class Off(Good):
    """Off by a relative 1e-6 in the stiffness."""

    name = "off"
    traits = replace(Good.traits, versions=("2",))

    def scene_of(self, job):
        return job.scene.replace(law=job.scene.law.replace(normal_stiffness=K * (1 + 1e-6)))


class Usual(Good):
    """The engine that runs unless another is named."""

    name = "lammps"


class Dying(Good):
    name = "dying"

    def run(self, jobs):
        return [EngineCrashError("signal SIGSEGV").with_log("last words") for _ in jobs]


class Missing(Good):
    name = "missing"

    def __init__(self):
        raise EngineMissingError("missing: no program")


class Refusing(Good):
    name = "refusing"

    def rules(self, scene):
        raise Unsupported("it has no springs")


class Young(Refusing):
    """Refuses all, in a version that nobody has tried."""

    name = "young"
    traits = replace(Good.traits, versions=())


class Rough(Good):
    name = "rough"
    traits = replace(Good.traits, digits=7)


CASE = BounceCase()


class Wrong(BounceCase):
    """A case whose calls raise, or return a wrong type."""

    name, qualifies = "wrong", False
    mode = "none"

    def checks(self, engine):
        return {"none": lambda: None, "raise": lambda: 1 / 0, "type": lambda: [1]}[self.mode]()


WRONG = Wrong()
HERE = "tests.workflows.doubles"
GROUPS = {"balls": {"bounce": f"{HERE}:CASE"}, "others": {"wrong": f"{HERE}:WRONG"}}
ENGINES = {
    kind.name: f"{HERE}:{kind.__name__}"
    for kind in (Usual, Good, Off, Dying, Missing, Refusing, Young, Rough)
}


class Search(Parameters):
    """Options of a search."""

    method: str = Field("slow", description="[-] of the search")


class Slow(Good):
    """Takes its time."""

    name, seconds = "slow", 0.1

    def run(self, jobs):
        time.sleep(self.seconds * len(jobs))
        return super().run(jobs)


class Second(BounceCase):
    """A case of another package."""

    name, qualifies = "bounce2", False


class Third(BounceCase):
    name, qualifies = "bounce3", False


BOUNCE2, BOUNCE3 = Second(), Third()


class Sleeping(Slow):
    """Leaves a file as a sign before it sleeps."""

    name, seconds = "sleeping", 60

    def run(self, jobs):
        Path("asleep").touch()
        return super().run(jobs)


def start(folder, *words, **streams):
    """Start a command in a process of its own, which has the doubles."""
    code = (
        "import sys; from tests.workflows import doubles\nfrom harness.cases import registry\n"
        "registry.GROUPS = doubles.GROUPS\n"
        f"sys.argv = ['dem-harness', *{words!r}]\nfrom harness.cli import main\nmain()"
    )
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    return subprocess.Popen(
        [sys.executable, "-c", code], cwd=folder, env=environment, text=True, **streams
    )
