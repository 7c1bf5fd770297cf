"""A bench: an engine under test, with a memo of all that was run in it.

Checks, tables and figures take their runs from the bench, so that none is made twice.
"""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from harness.engines.base import SCENE, Engine, Job, Output
from harness.engines.output import Provenance, motion_tables
from harness.engines.scenes import motion_in, unknown_parts
from harness.errors import EngineError

if TYPE_CHECKING:
    from harness.model.conventions import Rules
    from harness.model.scene import Motion, Scene
    from harness.results.rows import Row

Result = TypeVar("Result")
Outcomes = Mapping[Hashable, Output | EngineError]  # by the key of a job
Progress = Callable[[str, int, int], None]  # stage, parts done, parts in all; from any thread
OWN = "harness"  # the bench of this package's solvers, and the engine of their rows


class Memo:
    """Values by key: the first thread that needs one computes it, the others wait for it."""

    def __init__(self) -> None:
        self._futures: dict[Hashable, Future[Any]] = {}
        self._lock = threading.Lock()

    def __contains__(self, key: Hashable) -> bool:
        return key in self._futures

    def __getitem__(self, key: Hashable) -> Any:
        """Return the value of a key that was claimed. Raise what its computation raised."""
        return self._futures[key].result()

    def items(self) -> Iterator[tuple[Hashable, Any]]:
        """Yield the keys with their values, of those that have one."""
        for key, future in list(self._futures.items()):
            if future.done() and future.exception() is None:
                yield key, future.result()

    def claim(self, key: Hashable) -> Future[Any] | None:
        """Return a future for the caller to fill, None where another one computes the key."""
        with self._lock:
            if key in self._futures:
                return None
            future: Future[Any] = Future()
            self._futures[key] = future
            return future

    def __call__(self, key: Hashable, make: Callable[[], Result]) -> Result:
        """Return the value of a key, computed by the first caller."""
        if future := self.claim(key):
            try:
                future.set_result(make())
            except BaseException as error:
                future.set_exception(error)
        result: Result = self[key]
        return result


class Bench:
    """An engine under test, None for this package's solvers.

    ``others`` are the benches of all engines of a verification, by name; ``rows`` those of the
    checks that were run, ``notes`` what cases keep of them for a report, both by case.
    """

    def __init__(self, engine: Engine | None, *, others: Mapping[str, Bench] | None = None) -> None:
        self._engine = engine
        self.others: Mapping[str, Bench] = {} if others is None else others
        self.rows: defaultdict[str, list[Row]] = defaultdict(list)
        self.notes: dict[str, Any] = {}
        self._runs = Memo()  # of the engine, shared by benches with other references
        self._memo = Memo()
        self._substitutes: Mapping[Scene, Motion] = {}

    @property
    def engine(self) -> Engine:
        """Return the engine. Raise EngineError for the bench of this package's solvers."""
        if self._engine is None:
            raise EngineError("the solvers of this package run no jobs of engines")
        return self._engine

    @property
    def name(self) -> str:
        """Return the engine's name."""
        return OWN if self._engine is None else self._engine.name

    def once(self, make: Callable[..., Result], *args: Any, **options: Any) -> Result:
        """Return ``make(*args, **options)``, computed by the first caller of these arguments."""
        key = (make, args, tuple(sorted(options.items())))
        return self._memo(key, lambda: make(*args, **options))

    # ---- runs of the engine

    def prepare(self, jobs: Sequence[Job]) -> None:
        """Run jobs that were not run yet, in one batch. The error of a run is its outcome."""
        self._run(self._claimed(jobs))

    def claim_scenes(self, jobs: Iterable[Job]) -> Callable[[], None]:
        """Return a call that runs the jobs that are scenes alone, whose outcomes others wait for.

        They share batches, as a process takes as long to start as many of them to run.
        """
        scenes = (job for job in jobs if job.template is SCENE and not self.refusal(job))
        return partial(self._run, self._claimed(scenes))

    def _claimed(self, jobs: Iterable[Job]) -> list[tuple[Job, Future[Any]]]:
        """Return the jobs that nobody has run yet, each with the future of its outcome."""
        return [(job, future) for job in jobs if (future := self._runs.claim(job_key(job)))]

    def _run(self, claimed: Sequence[tuple[Job, Future[Any]]]) -> None:
        if not claimed:
            return
        futures = [future for _, future in claimed]
        try:
            for place, outcome in self.engine.outcomes([job for job, _ in claimed]):
                futures[place].set_result(outcome)
        except BaseException as error:
            for future in futures:
                if not future.done():
                    future.set_exception(error)
            raise

    def outcomes(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the output of each job, or the error of its run, in order."""
        self.prepare(jobs)
        return [self._runs[job_key(job)] for job in jobs]

    def all_outcomes(self) -> Outcomes:
        """Return the outcome of each job that was run, by its key."""
        return {k: v for k, v in self._runs.items() if isinstance(v, Output | EngineError)}

    def take_over(self, outcomes: Outcomes) -> None:
        """Take outcomes of jobs that were run elsewhere as those of the engine."""
        for key, outcome in outcomes.items():
            if future := self._runs.claim(key):
                future.set_result(outcome)

    def has_run(self, jobs: Iterable[Job]) -> bool:
        """Return whether all jobs were run, so that a report runs none of its own."""
        return all(job_key(job) in self._runs for job in jobs)

    def refusal(self, job: Job) -> str:
        """Return why the engine cannot run a job, empty where it can."""
        return self._runs(("refusal", job_key(job)), lambda: self.engine.refuses(job))

    def inputs_digest(self, jobs: Sequence[Job]) -> str:
        """Return a digest of what jobs give the engine; empty without jobs."""
        from harness.results.compare import digest  # with pandas: slow to import

        key = ("inputs", *map(job_key, jobs))
        return self._runs(key, lambda: digest(_content(self.engine, jobs))) if jobs else ""

    def output(self, job: Job) -> Output:
        """Return the output of a job. Raise EngineError for a run that failed."""
        (outcome,) = self.outcomes([job])
        if isinstance(outcome, EngineError):
            raise outcome
        return outcome

    def motion(self, job: Job) -> Motion:
        """Return the motion of a scene's job in the engine. Raise EngineError as the run did."""
        key = ("motion", job_key(job))
        return self._runs(key, lambda: motion_in(self.output(job), self.engine.scene_of(job)))

    def unwritten(self, jobs: Sequence[Job]) -> str:
        """Return that the engine writes no forces or torques in one of its runs, or nothing."""
        parts: dict[str, None] = {}
        for job in jobs:
            with suppress(EngineError):  # of a job whose output has no samples
                if job.scene is not None:
                    parts |= dict.fromkeys(unknown_parts(job.scene, self.motion(job)))
        return f"{self.engine.title} writes no {' and no '.join(parts)}" if parts else ""

    # ---- the reference

    def rules(self, scene: Scene) -> Rules:
        """Return the engine's conventions in a scene, the defaults for this package's solvers.

        Raise Unsupported for a scene that the engine cannot run.
        """
        from harness.model.conventions import Rules

        if self._engine is None:
            return Rules()
        return self._runs(("rules", scene), lambda: self.engine.rules(scene))

    def reference(self, scene: Scene) -> Motion:
        """Return the motion of a scene at equal steps, by the engine's conventions."""
        from harness.solvers import reference

        if scene in self._substitutes:
            return self._substitutes[scene]
        return self.once(reference.run, scene, self.rules(scene))

    def reference_output(self, scene: Scene) -> Output:
        """Return :meth:`reference` as an output."""
        return output_of(self.reference(scene), scene)

    def substituting(self, motions: Mapping[Scene, Motion]) -> Bench:
        """Return a bench with the same runs, whose references of some scenes are other motions.

        So a check is compared with the reference with the switch of a known defect. What was
        computed ``once`` may rest on the reference, and is computed anew.
        """
        bench = Bench(self._engine, others=self.others)
        bench._runs = self._runs
        bench._substitutes = motions
        return bench


def output_of(motion: Motion, scene: Scene) -> Output:
    """Return a motion of the reference as the output of an engine."""
    tables = motion_tables(motion, scene)
    return Output((), Provenance("reference", ""), tables, title="the reference")


def job_key(job: Job) -> Hashable:
    """Return the identity of a job: package, template, variant, values, samples and scene."""
    template, values = job.template, tuple(sorted(job.values.items()))
    return ("job", template.package, template.name, job.variant, values, job.sampled, job.scene)


def _content(engine: Engine, jobs: Sequence[Job]) -> list[Any]:
    """Return all that jobs give the engine."""
    return [
        [
            job.template.name,
            job.variant,
            dict(sorted(job.values.items())),
            None if job.scene is None else job.scene.model_dump(mode="json"),
            engine.script_digest(job),
        ]
        for job in jobs
    ]
