"""Engines that run a program, and script files through it: templates rendered, run, and read.

To make an engine of scripts, subclass :class:`ScriptedEngine` next to a folder ``templates`` with a
file ``<template>.<extension>.j2`` for each template of a case that the code can run, and give
``name``, ``traits``, ``programs``, ``extension`` of script files, ``options`` of the program, and
``ask_version``: who the program is, from :meth:`ProgramEngine.ask`.

A script declares the values it takes and prints ``RESULT name = value``, ``RESULT verdict = ...``
last. By default it has a dictionary ``PARAMETERS``, and takes the runs of a batch from a JSON list,
each with the files of its ``series``, a CSV, and of its ``results``, which it writes when the run
is over. Override the other methods and class attributes of :class:`ScriptedEngine` for another
form.

Where a case belongs to another package its templates lie in ``<package>/templates/<engine>/``.
Jinja sees every default as :meth:`ScriptedEngine.literal` writes it, and all as ``defaults``, with
``values`` (the same as numbers), ``about`` (their descriptions), ``name`` (the file), ``version``,
``variant``, ``note``, ``look``, ``engine_class`` and ``allowed``: the allowed values of the
variables that the script declares.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import re
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from harness import __version__
from harness.engines.base import Engine, Job, Template, Value, Values
from harness.engines.output import (
    SERIES,
    Output,
    Provenance,
    finished,
    read_csv,
    read_dump,
    results_in,
)
from harness.engines.process import (
    SAID,
    Batches,
    Ended,
    Limits,
    Processes,
    Result,
    cores,
    first_text,
    fresh_folder,
    text_of,
)
from harness.engines.registry import ENVIRONMENT, facts, find_program
from harness.errors import (
    EngineError,
    EngineMissingError,
    EngineNaNError,
    HarnessError,
    RequestError,
)

if TYPE_CHECKING:
    from jinja2 import Environment

    from harness.model.base import Allowed
    from harness.model.scene import Motion

ASK_SECONDS = 60.0
RUNS = "runs.json"
LOG, SERIES_FILE = "log.txt", "series.csv"  # of a run, in its folder
SHARED = Path(__file__).with_name("templates")  # what templates of several engines include


class ProgramEngine(Engine):
    """An engine that is its ``program``, by default the first of ``programs`` on PATH.

    ``workers`` processes run in parallel, by default as many as there are cores. Runs are cached
    under the contents of ``installed_files``, the ``deciding_variables`` of the environment, and
    ``deciding_options``: those of the engine that no job has and that decide a result. Raise
    RequestError for no worker and a named program that is not there, EngineMissingError where none
    is named and there is none.
    """

    can_be_copied = True
    programs: ClassVar[tuple[str, ...]] = ()
    deciding_variables: ClassVar[tuple[str, ...]] = ENVIRONMENT

    def __init__(
        self, program: str | None = None, workers: int | None = None, limits: Limits | None = None
    ) -> None:
        if workers is not None and workers < 1:
            raise RequestError(f"workers = {workers!r}: must be at least 1")
        self.program = self.find(program)
        self.limits, self.workers = limits or Limits(), workers or cores()
        self.processes = Processes()
        self.deciding_options: Mapping[str, str] = {}

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the absolute path of the program that is named, or of a known one."""
        if program is not None:
            return find_program(f"program {cls.name}=", program)
        for name in cls.programs:
            with suppress(RequestError):
                return find_program("program", name)
        raise EngineMissingError(cls.traits.missing(f"no {' or '.join(cls.programs)} on PATH"))

    @abstractmethod
    def ask_version(self) -> Provenance:
        """Return who the program is; raise EngineMissingError where it is another, or broken."""

    def identify(self) -> Provenance:
        """Return version and executable, read once."""
        return self._identity

    @cached_property
    def _identity(self) -> Provenance:
        identity = self.ask_version()
        # the version text of a program goes to terminals and pages
        version = "".join(c if c.isprintable() else "?" for c in identity.engine_version)
        return replace(identity, engine_version=version, integrator=self.traits.integrator)

    def installed_files(self) -> list[Path]:
        """Return the files that decide a result, the program first; none where one is unknown."""
        return []

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return the contents of the program and all that it runs, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> Mapping[str, Any] | None:
        files, variables = self.installed_files(), self.deciding_variables
        if not files:
            return None
        return facts(self.name, "executable", files, variables, self.deciding_options)

    def environment(self, folder: Path) -> Mapping[str, str] | None:  # noqa: ARG002
        """Return the environment of a process that works in a folder; None: the harness's own."""
        return None

    def ask(
        self, words: Sequence[str], files: Mapping[str, str] | None = None
    ) -> tuple[str, Ended]:
        """Run a command once in a folder with these files; return its first output and its end."""
        with fresh_folder() as folder:
            for name, text in (files or {}).items():
                (folder / name).write_text(text, encoding="utf-8")
            ended = self.start(words, folder, ASK_SECONDS)
            return first_text(folder / SAID, 100_000), ended

    def start(self, words: Sequence[str], folder: Path, seconds: float) -> Ended:
        """Run a command in a folder."""
        environment, memory = self.environment(folder), self.limits.memory
        return self.processes.run(
            words, folder, seconds=seconds, memory=memory, environment=environment
        )

    def error_of(self, ended: Ended, log: str) -> EngineError | None:  # noqa: ARG002
        """Return the error by the end of a process, or None where it ended well.

        ``log`` is that of the task it was at, empty where all had finished.
        """
        return ended.error(self.title)

    def share_cores(self, processes: int) -> None:
        """Run fewer jobs at a time, as so many processes have this engine."""
        self.workers = max(1, self.workers // processes)

    def close(self) -> None:
        """End what runs; whoever waits for it removes its files."""
        self.processes.close()


# ---- scripts


@dataclass(frozen=True)
class Script:
    """A script, ready to be written and run.

    ``name`` is that of its file; ``variables`` are the names of the values that may be set.
    """

    name: str
    text: str
    variables: frozenset[str] = frozenset()

    @cached_property
    def sha256(self) -> str:
        """Return the SHA-256 of the text, in hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()


@dataclass(frozen=True)
class Task:
    """A job with its script and the values that are set in it, by the script's names."""

    job: Job
    script: Script
    values: Mapping[str, Any]


class ScriptedEngine(ProgramEngine):
    """A code that runs scripts through its program, in as many processes as it has workers.

    ``renders_variants``: whether each variant of a template is a script of its own
    (``<template>-<variant>.<extension>``), or all run that of the main one with other values.
    A sampled job sets each of the ``switches`` that its script declares. ``command_name`` is the
    start of a command line that a user would type.

    One that takes scenes as well has ``rules``, ``scene_script`` and ``read_scene``.
    """

    extension: ClassVar[str] = "py"
    command_name: ClassVar[str] = "python"
    options: ClassVar[Sequence[str]] = ()
    renders_variants: ClassVar[bool] = False
    switches: ClassVar[Values] = {}

    # ---- the form of scripts and their files

    @classmethod
    def allowed(cls) -> Mapping[str, Allowed]:
        """Return what variables of the engine's own may be."""
        return {}

    @classmethod
    def literal(cls, value: Value) -> str:
        """Return a value as the code's scripts write it, at full precision."""
        return str(value)

    @classmethod
    def declared(cls, text: str) -> frozenset[str]:
        """Return the variables that may be set in a script, the keys of its ``PARAMETERS``."""
        block = re.search(r"^PARAMETERS = \{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL)
        return frozenset(re.findall(r'^ +"(\w+)":', block[1], re.MULTILINE) if block else ())

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the indices of the tasks of each process: those of one script, dealt out."""
        scripts: dict[Script, list[int]] = {}
        for place, task in enumerate(tasks):
            scripts.setdefault(task.script, []).append(place)
        hands = self.workers
        return [same[k::hands] for same in scripts.values() for k in range(min(hands, len(same)))]

    def write(self, folder: Path, tasks: Sequence[Task]) -> list[str]:
        """Write the files of a batch, of one script, and return the command that runs them."""
        runs = []
        (folder / tasks[0].script.name).write_text(tasks[0].script.text, encoding="utf-8")
        for place, task in enumerate(tasks):
            (folder / str(place)).mkdir()
            series = f"{place}/{SERIES_FILE}" if task.job.sampled else ""
            runs.append({**task.values, "series": series, "results": f"{place}/{LOG}"})
        (folder / RUNS).write_text(json.dumps(runs), encoding="utf-8")
        return [self.program, *self.options, tasks[0].script.name, RUNS]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        words = [f"{name}={str(v).replace(' ', '')}" for name, v in task.values.items()]
        return " ".join([self.command_name, task.script.name, *words])

    def template_text(self, task: Task) -> str:
        """Return the script of a template below the command that runs it."""
        return f"# {self.command_line(task)}\n{task.script.text}"

    def log_of(self, folder: Path, index: int) -> str:
        """Return the log of the task of this index, nothing before it has begun."""
        return text_of(folder / str(index) / LOG)

    # ---- scripts of templates

    @classmethod
    def has_template(cls, template: Template) -> bool:
        """Return whether there is a script of this name."""
        return _has_file(cls, template.package, template.name)

    @classmethod
    def script(cls, template: Template, variant: str = "") -> Script:
        """Return the script of a variant, rendered once; raise RequestError for an unknown one."""
        chosen = variant or template.main
        if chosen not in template.variants:
            variants = ", ".join(template.variants)
            raise RequestError(
                f"{template.name!r} has no variant {variant!r}: must be one of {variants}"
            )
        return _script(cls, template, chosen if cls.renders_variants else template.main)

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:
        """Return the scripts of all variants that the engine renders, by their names."""
        scripts = (cls.script(t, v) for t in templates if cls.has_template(t) for v in t.variants)
        return {script.name: script.text for script in scripts}

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job: no template, its rules, an unknown value."""
        reason = super().refuses(job)
        if reason or not self.has_template(job.template):
            return reason
        script, neutral = self.script(job.template, job.variant), job.template.neutral
        for name, value in self._values(job).items():
            if name not in script.variables and value != neutral.get(name):
                return f"its script {script.name} has no variable {name!r} ({name} = {value!r})"
        return ""

    def task(self, job: Job) -> Task:
        """Return a job with its script and all that is set in it; check the job before."""
        script = self.script(job.template, job.variant)
        values = {**self._values(job), **(self.switches if job.sampled else {})}
        return Task(job, script, {n: v for n, v in values.items() if n in script.variables})

    def _values(self, job: Job) -> Values:
        """Return the values of a job, with the defaults of a variant that has no script."""
        in_script = self.renders_variants or not job.variant
        return {**({} if in_script else job.template.variants[job.variant]), **job.values}

    def script_digest(self, job: Job) -> str:
        """Return the SHA-256 of the script that a job runs; empty for a scene."""
        has_script = self.has_template(job.template)
        return self.script(job.template, job.variant).sha256 if has_script else ""

    def script_text(self, job: Job) -> str:
        """Return the plain script of a job: of its template, else of its scene."""
        if job.scene is None or self.has_template(job.template):
            return self.template_text(self.task(job))
        return self.scene_script(job)

    @classmethod
    def _folders(cls, package: str) -> tuple[Path, ...]:
        """Return where templates lie: in the case's package, then with the engine's classes."""
        kinds = [kind for kind in cls.__mro__ if issubclass(kind, ScriptedEngine)]
        files = [inspect.getfile(kind) for kind in kinds if not inspect.isabstract(kind)]
        folders = tuple(Path(file).with_name("templates") for file in files)
        if not package:
            return folders
        try:
            root = Path(str(resources.files(package)))
        except (ImportError, TypeError) as error:
            raise RequestError(
                f"templates of package {package!r}: it cannot be imported ({error})"
            ) from None
        return (root / "templates" / cls.name, *folders)

    # ---- scenes, for a code that takes them

    def scene_script(self, job: Job) -> str:
        """Return the plain script of a job's scene."""
        raise NotImplementedError

    def scene_task(self, job: Job) -> Task:
        """Return a job with the script of its scene, in which nothing is set."""
        return Task(job, Script(f"scene.{self.extension}", self.scene_script(job)), {})

    def read_scene(self, folder: Path, index: int, task: Task, seconds: float) -> Motion | None:
        """Return the motion of a task, None where it has not finished."""
        raise NotImplementedError

    # ---- runs

    def batches(
        self, read: Callable[[Path, int, Task, float], Result | None]
    ) -> Batches[Task, Result]:
        """Return how the program runs tasks, whose results ``read`` returns."""
        return Batches(title=self.title, write=self.write, read=read, error=self.error_of,
                       log=self.log_of, environment=self.environment,
                       seconds=lambda task: task.job.seconds)  # fmt: skip

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of the scene of each job, or the error of its run, in order."""
        tasks, batches = [self.scene_task(job) for job in jobs], self.batches(self.read_scene)
        return batches.run(tasks, self.workers, self.limits, self.processes, self.shares(tasks))

    def run_scripts(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the outputs of scripts; their logs begin with the command and the script."""
        self.identify()
        tasks = [self.task(job) for job in jobs]
        outcomes: list[Output | EngineError] = []
        for task, outcome in zip(tasks, self.execute(tasks), strict=True):
            head = f"# {self.command_line(task)}\n# sha256 of the script: {task.script.sha256}"
            log = f"{head}\n{outcome.log or f'{self.title} left no log.'}\n"
            if isinstance(outcome, EngineError):
                outcomes.append(outcome.with_log(log))
            else:
                self._logs.setdefault(task.script.name, log)
                outcomes.append(replace(outcome, log=log))
        return outcomes

    @cached_property
    def _logs(self) -> dict[str, str]:
        return {}

    def logs(self) -> dict[str, str]:
        """Return, for each script, the log of the first run of it that finished."""
        return dict(self._logs)

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks, shared out over processes, and return their outputs in order."""
        shares, batches = self.shares(tasks), self.batches(self.read_job)
        return batches.run(tasks, self.workers, self.limits, self.processes, shares)

    def read_job(self, folder: Path, index: int, task: Task, seconds: float) -> Output | None:
        """Return the output of a task that took so long, None where it has not finished."""
        log, series = self.log_of(folder, index), text_of(folder / str(index) / SERIES_FILE)
        return self.output(task, log, series, seconds) if finished(log) else None

    def output(self, task: Task, log: str, series: str, seconds: float) -> Output:
        """Return the output of a task from its log and its series, a dump or a CSV.

        A result ``seconds`` wins over the share of the process's wall time.
        """
        script = task.script
        provenance = replace(self.identify(), script=script.name, script_sha256=script.sha256)
        read = read_dump if series.startswith("ITEM:") else read_csv
        tables = {SERIES: read(series, self.title)} if series else {}
        output = Output(results_in(log), provenance, tables, log, seconds, self.title)
        if output.has("verdict") and output.text("verdict") == "not_a_number":
            raise EngineNaNError(f"{self.title} met a place or velocity that is not a number")
        if output.has("seconds"):
            output = replace(output, seconds=output.number("seconds"))
        return output


# ---- rendering


@cache
def _has_file(kind: type[ScriptedEngine], package: str, name: str) -> bool:
    file = f"{name}.{kind.extension}.j2"
    return any((folder / file).is_file() for folder in kind._folders(package))


@cache
def _script(kind: type[ScriptedEngine], template: Template, variant: str) -> Script:
    """Return the script of a variant, rendered twice: its text names the variables in it."""
    from harness.model.scene import LOOK  # pydantic, which workers of LAMMPS do without

    if not kind.has_template(template):
        raise RequestError(f"engine {kind.name!r} has no template {template.name!r}")
    stem = f"{template.name}-{variant}" if variant and kind.renders_variants else template.name
    name, file = f"{stem}.{kind.extension}", f"{template.name}.{kind.extension}.j2"
    settings = template.variants[variant]
    defaults = {key: kind.literal(value) for key, value in settings.items()}
    values = {**defaults, "defaults": defaults, "values": settings, "about": template.about,
              "name": name, "variant": variant, "note": template.notes.get(variant, ""),
              "look": LOOK, "engine_class": kind}  # fmt: skip
    folders, allowed = kind._folders(template.package), {**template.allowed, **kind.allowed()}
    try:
        variables = kind.declared(rendered(folders, file, {**values, "allowed": {}}))
        declared = {n: limits for n, limits in allowed.items() if n in variables}
        return Script(name, rendered(folders, file, {**values, "allowed": declared}), variables)
    except HarnessError:
        raise
    except Exception as error:
        package = f" of package {template.package!r}" if template.package else ""
        text = " ".join(f"{type(error).__name__}: {error}".split())[:160]
        raise EngineError(
            f"{kind.label()}: case {template.name!r}{package}: template {file} cannot be "
            f"rendered: {text}"
        ) from error


def rendered(folders: Sequence[Path], file: str, values: Mapping[str, Any]) -> str:
    """Return the text of a template with values, ended by a line feed.

    What it includes may lie in any of the folders.
    """
    text = _environment(tuple(folders)).get_template(file).render(version=__version__, **values)
    return text if text.endswith("\n") else text + "\n"


@cache  # what templates include is compiled once
def _environment(folders: tuple[Path, ...]) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader([*folders, SHARED]), undefined=StrictUndefined, autoescape=False,
        trim_blocks=True, keep_trailing_newline=True, auto_reload=False,
    )  # fmt: skip
