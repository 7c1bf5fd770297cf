"""The contract of an engine: identify, the rules of a scene, run; independent of cases.

A *job* is a template with values, a scene, or both; an *output* is the named numbers and tables of
its result, with log and provenance. A case makes jobs and reads outputs; only
``engines/<code>/templates/<template>`` depends on both a case and a code.

To add an engine, subclass :class:`Engine`: ``traits`` describes it, ``identify`` returns its
provenance, ``rules`` the conventions by which it runs a scene, ``motions`` the motions of scenes.
Override ``run`` for outputs of another kind. An engine of another package is registered under
the entry point ``dem_harness.engines``, one of this package in ``registry.py``. README.md has an
example.

Units are converted at this edge and nowhere else. Formulas are not shared with theory or solvers.
"""

from __future__ import annotations

import errno
import functools
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from harness.engines.output import Output, Provenance, motion_tables
from harness.engines.process import cores, in_batches
from harness.errors import (
    FULL,
    EngineError,
    EngineNaNError,
    EngineOutputError,
    HarnessError,
    RequestError,
    Unsupported,
)

if TYPE_CHECKING:
    from harness.model.base import Allowed
    from harness.model.conventions import Rules
    from harness.model.scene import Motion, Scene

SCENE_NAME = "contact-scene"
SCENES_AT_ONCE = 500  # in the first batch of jobs without scripts

Value = str | int | float
Values = Mapping[str, Value]
Run = Callable[[Sequence["Job"]], list[Output | EngineError]]

__all__ = ["Engine", "Job", "Output", "Template", "Value", "Values"]


@dataclass(frozen=True)
class Traits:
    """What an engine is.

    ``install_hint`` is a line on how to get it, ``versions`` are those it was tried with.
    ``integrator`` is the scheme of its steps, by the reference's name. ``digits`` are those of its
    output: a check's tolerance is not below them. ``microseconds_per_step`` is the cost of a step
    of ten particles, rounded up; 0 where runs have no step. ``lineage`` is the engine it grew out
    of: such a one is a regression partner, not independent evidence. ``title`` is the engine's name
    as its authors write it; empty where that is its name in capitals.
    """

    install_hint: str
    versions: tuple[str, ...]
    integrator: str = "velocity-verlet"
    digits: int = 15
    microseconds_per_step: float = 1.0
    lineage: str = ""
    title: str = ""

    def missing(self, why: str) -> str:
        """Return why an engine is missing, with the install hint unless the reason has it."""
        return why if self.install_hint in why else f"{why}; to get it: {self.install_hint}"


@dataclass(frozen=True)
class Template:
    """A system to simulate: the name of a template, with defaults for its values.

    ``variants`` maps the name of a variant to its defaults; the first is the main one, and a case
    with one script names it "". ``notes`` is a sentence on each variant for the head of its script.
    ``package`` is where templates of a case outside this project lie, in
    ``templates/<engine>/``. ``allowed`` is what values may be, for scripts that are run by hand:
    jobs are checked before; ``about`` is what they are. ``neutral`` are values that change nothing:
    one that differs from it must be read by an engine.
    """

    name: str
    variants: Mapping[str, Values]
    notes: Mapping[str, str] = field(default_factory=dict)
    package: str = ""
    allowed: Mapping[str, Allowed] = field(default_factory=dict)
    neutral: Mapping[str, Value] = field(default_factory=dict)
    about: Mapping[str, str] = field(default_factory=dict)

    def __hash__(self) -> int:
        return hash((self.package, self.name))

    @property
    def main(self) -> str:
        """Return the name of the main variant."""
        return next(iter(self.variants))


@dataclass(frozen=True)
class Job:
    """One run: a template, the values set in it, and whether its table of samples is wanted.

    ``values`` are SI, angles in degrees; ``series_every`` among them is the number of steps
    between samples. ``variant`` chooses the defaults of the script that is rendered: values win
    over them. ``seconds`` [s] is what a long run is expected to take in the slowest code: it has
    more time than others.
    ``scene`` is the same system as spheres and walls, for engines without a script of the template,
    and all there is of a job of the template :data:`SCENE`. ``steps`` is how many a run is expected
    to take whose scene has stages: its own are the most.
    """

    template: Template
    values: Values
    variant: str = ""
    sampled: bool = False
    seconds: float = 0.0
    scene: Scene | None = None
    steps: float = 0.0


SCENE = Template(SCENE_NAME, {"": {}})

PARTICLES = 10  # of the system on which ``microseconds_per_step`` was measured
SLOWEST_STEP = 10.0  # [us] of the code for which ``Job.seconds`` are stated


def job_seconds(job: Job, traits: Traits) -> float:
    """Return the expected time of a job [s], to a factor of a few; 0 for a script without one."""
    if job.seconds:
        return job.seconds * min(1.0, traits.microseconds_per_step / SLOWEST_STEP)
    if job.scene is None:
        return 0.0
    size = max(1.0, len(job.scene.bodies) / PARTICLES)
    return (job.steps or job.scene.steps) * size * traits.microseconds_per_step * 1e-6


def scene_job(scene: Scene, **values: Value) -> Job:
    """Return the job of a scene; ``values`` are ``units`` (si, lj) and the name of a variation."""
    return Job(SCENE, values, sampled=True, scene=scene)


class Engine(ABC):
    """A DEM code that runs jobs. Use it as a context manager.

    A job whose template the engine has as a script runs the script with the job's values; another
    one runs the job's scene; one without either is refused.
    """

    name: ClassVar[str]
    traits: Traits
    has_lj_units: ClassVar[bool] = False
    can_be_copied: ClassVar[bool] = False
    """Whether copies of this process may use an engine that is open: :meth:`forget_processes`."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if _package(cls) != HARNESS:
            for name in GUARDED.keys() & {*vars(cls), "run"}:
                setattr(cls, name, _guarded(name, getattr(cls, name)))

    @property
    def title(self) -> str:
        """Return the engine's name as reports write it."""
        return self.traits.title or self.name.upper()

    @classmethod
    def label(cls) -> str:
        """Return the engine's name for a message, with its package where that is another one."""
        package = f" of package {_package(cls)!r}" if _package(cls) != HARNESS else ""
        return f"engine {getattr(cls, 'name', cls.__name__)!r}{package}"

    # ---- identity

    @abstractmethod
    def identify(self) -> Provenance:
        """Return version, packages and executable; raise EngineMissingError with the remedy."""

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return all that decides a result besides the job, JSON-ready, or None.

        Contents of programs and libraries, not only their version: outputs are
        cached under it. None, the default, has nothing cached.
        """
        return None

    # ---- supported jobs

    @classmethod
    def has_template(cls, template: Template) -> bool:  # noqa: ARG003
        """Return whether the engine has a script of a template: it runs scenes alone."""
        return False

    def rules(self, scene: Scene) -> Rules:  # noqa: ARG002
        """Return the conventions by which the engine runs a scene of spheres and walls.

        Raise Unsupported for a scene that it cannot run.
        """
        raise Unsupported("it runs no scenes of spheres and walls")

    def variations(self, scene: Scene) -> Sequence[tuple[str, Scene]]:  # noqa: ARG002
        """Return options of the engine by name, each with the scene whose motion it must leave.

        A job of the scene with the value ``variation`` = name runs it.
        """
        return ()

    def scene_of(self, job: Job) -> Scene:
        """Return the scene that a job runs, with its variation."""
        assert job.scene is not None
        name = job.values.get("variation")
        return dict(self.variations(job.scene))[str(name)] if name else job.scene

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job, or nothing where it can."""
        if self.has_template(job.template):
            return ""
        if job.scene is None:
            return f"it has no template {job.template.name!r}, and the job has no scene"
        if job.values.get("units") == "lj" and not self.has_lj_units:
            return "it has no units lj"
        try:
            self.rules(job.scene)
        except Unsupported as reason:
            return str(reason)
        return ""

    def check(self, jobs: Iterable[Job]) -> None:
        """Raise RequestError for the first job that the engine refuses."""
        for job in jobs:
            if reason := self.refuses(job):
                raise RequestError(
                    f"engine {self.name!r} cannot run {job.template.name!r}: {reason}"
                )

    # ---- runs

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the jobs, in parallel where that helps, and return their outputs in order.

        A failed run must not affect the others. Raise RequestError, before anything runs, for a job
        that :meth:`refuses` names.
        """
        self.check(jobs)
        outcomes: dict[int, Output | EngineError] = {}
        for places, run, _ in self._groups(jobs):
            outcomes |= zip(places, run([jobs[place] for place in places]), strict=True)
        return [outcomes[place] for place in range(len(jobs))]

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Output | EngineError]]:
        """Yield the place and the outcome of each job as soon as it is known, in any order.

        Scenes and scripts run in separate batches, which grow with their speed: of scenes a process
        runs many in the time that it takes to start.
        """
        self.check(jobs)
        for places, _, size in self._groups(jobs):
            for index, outcome in in_batches([jobs[k] for k in places], self.run, size):
                yield places[index], outcome

    def _groups(self, jobs: Sequence[Job]) -> list[tuple[list[int], Run, int]]:
        """Return the places of scenes, and of scripts, with their runner and a first batch."""
        scripted = [self.has_template(job.template) for job in jobs]
        kinds = ((False, self.run_scenes, SCENES_AT_ONCE), (True, self.run_scripts, 2 * cores()))
        return [
            ([place for place, has_script in enumerate(scripted) if has_script is kind], run, size)
            for kind, run, size in kinds
            if kind in scripted
        ]

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of the scene of each job, or the error of its run, in order."""
        raise NotImplementedError

    def run_scenes(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the motions of jobs with scenes as outputs, in order."""
        started, provenance = time.monotonic(), self.identify()
        motions = self.motions(jobs)
        seconds = (time.monotonic() - started) / len(jobs)
        outcomes: list[Output | EngineError] = []
        for job, motion in zip(jobs, motions, strict=True):
            if isinstance(motion, EngineError):
                outcomes.append(motion)
            elif not all(np.isfinite(part).all() for part in (motion.position, motion.velocity)):
                # also in a component that no case reads
                outcomes.append(EngineNaNError(f"{self.title} left a motion that is not finite"))
            else:
                tables = motion_tables(motion, self.scene_of(job), sampled=job.sampled)
                outcomes.append(Output((), provenance, tables, seconds=seconds, title=self.title))
        return outcomes

    def run_scripts(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the outputs of jobs whose templates the engine has as scripts, in order."""
        raise NotImplementedError

    # ---- texts

    def script_digest(self, job: Job) -> str:  # noqa: ARG002
        """Return a digest of the script that a job runs; empty where the engine takes scenes."""
        return ""

    def script_text(self, job: Job) -> str:  # noqa: ARG002
        """Return the plain script of a job, to be run by hand; empty where it runs without one."""
        return ""

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:  # noqa: ARG003
        """Return the generated input files of templates, by their names."""
        return {}

    def logs(self) -> dict[str, str]:
        """Return the log of one finished run for each script, by the script's name."""
        return {}

    def close(self) -> None:  # noqa: B027 - an engine without processes has nothing to close
        """End the engine's processes."""

    def forget_processes(self) -> None:  # noqa: B027 - nor to forget
        """Leave processes and connections to the process of which this one is a copy."""

    def share_cores(self, processes: int) -> None:  # noqa: B027 - nor workers to divide
        """Run fewer jobs at a time, as so many processes have this engine."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


# ---- engines of other packages, whose methods may return or raise anything

HARNESS = "harness"
GUARDED: Mapping[str, type] = {"identify": Provenance, "fingerprint": object, "refuses": str,
                               "rules": object, "motions": list, "run": list, "logs": dict,
                               "script_text": str, "script_digest": str,
                               "close": object}  # fmt: skip


class ContractError(EngineOutputError):
    """A call of an engine of another package that raised what no engine should raise."""


def _package(kind: type[Engine]) -> str:
    return kind.__module__.partition(".")[0]


@contextmanager
def contract(kind: type[Engine], name: str) -> Iterator[None]:
    """Raise a ContractError for any exception of a call that no engine should raise.

    Exceptions of this package's engines pass: those are errors of the harness.
    """
    try:
        yield
    except (HarnessError, MemoryError):
        raise
    except Exception as error:
        is_full = isinstance(error, OSError) and error.errno in (*FULL, errno.EMFILE)
        if is_full or _package(kind) == HARNESS:
            raise
        text = " ".join(f"{type(error).__name__}: {error}".split()).strip(": ")[:160]
        failure = ContractError(f"{kind.label()}: {name} raised {text}")
        raise failure.with_log("".join(traceback.format_exception(error))) from None


def _guarded(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method under the contract; ``run`` returns a ContractError for each of its jobs."""
    wanted = GUARDED[name]

    @functools.wraps(call)
    def guarded(self: Engine, *arguments: Any) -> Any:
        try:
            with contract(type(self), name):
                value = call(self, *arguments)
                if not isinstance(value, wanted):
                    raise TypeError(f"{type(value).__name__} in place of {wanted.__name__}")
                if isinstance(value, list):
                    _check_outcomes(value, len(arguments[0]))
                return value
        except ContractError as failure:
            if name != "run":
                raise
            return [failure] * len(arguments[0])

    return guarded


def _check_outcomes(outcomes: Sequence[Any], jobs: int) -> None:
    from harness.model.scene import Motion

    if len(outcomes) != jobs:
        raise ValueError(f"{len(outcomes)} outcomes of {jobs} jobs")
    for outcome in outcomes:
        if not isinstance(outcome, Output | Motion | EngineError):
            raise TypeError(f"{type(outcome).__name__} in place of an outcome")
