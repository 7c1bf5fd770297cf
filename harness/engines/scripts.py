"""Scripts: templates rendered with the defaults of a variant, and what a job sets in them.

A template lies in ``templates/<name>.<extension>.j2`` of an engine's folder, or, where the case
belongs to another package, in ``<package>/templates/<engine>/``. Jinja sees every default as
:meth:`ScriptSource.literal` writes it, and all as ``defaults``, with ``values`` (the same as
numbers), ``about`` (what they are), ``name`` (the file), ``version``, ``variant``, ``note``, and
``allowed``: what the variables that the script declares may be.
"""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import re
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module, resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from harness import __version__
from harness.engines.base import SCENE_NAME, Engine, Job, Template, Value, Values
from harness.engines.border import engine_label
from harness.errors import EngineError, HarnessError, RequestError
from harness.model.allowed import Allowed

if TYPE_CHECKING:
    from jinja2 import Environment


Folder = Traversable | Path


def text_in(folders: Sequence[Folder], file: str) -> str | None:
    """Return the text of a template of this name, or None where no folder has it."""
    for folder in folders:
        path = folder / file
        if path.is_file():
            return path.read_text(encoding="utf-8")
    return None


def renderer(
    folders: Sequence[Folder], file: str, options: Mapping[str, bool]
) -> Callable[[Mapping[str, Any]], str]:
    """Return a function from the values of a template to its text, ended by a line feed."""
    with _named(file):
        template = _environment(tuple(folders), tuple(sorted(options.items()))).get_template(file)

    def rendered(values: Mapping[str, Any]) -> str:
        with _named(file):
            text = template.render(version=__version__, **values)
        return text if text.endswith("\n") else text + "\n"

    return rendered


@contextlib.contextmanager
def _named(file: str) -> Iterator[None]:
    """Raise EngineError, with file and line, for a template that cannot be rendered."""
    try:
        yield
    except HarnessError:
        raise
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        places = [(frame.filename, frame.lineno) for frame in frames if ".j2" in frame.filename]
        if (line := getattr(error, "lineno", None)) is not None:
            places.append((getattr(error, "name", None) or file, line))
        where, line = places[-1] if places else (file, None)
        place = f"{where}, line {line}" if line else where
        message = " ".join(str(error).split())[:160]
        raise EngineError(
            f"template {place} cannot be rendered: {type(error).__name__}: {message}"
        ) from error


def _source(folders: Sequence[Folder], name: str) -> tuple[str, str, None] | None:
    """Return a template with its name, for errors."""
    text = text_in(folders, name)
    return None if text is None else (text, name, None)


@cache  # what templates include is compiled once
def _environment(folders: tuple[Folder, ...], options: tuple[tuple[str, bool], ...]) -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    chosen: dict[str, Any] = {
        "trim_blocks": True,
        "lstrip_blocks": False,
        "keep_trailing_newline": True,
    }
    chosen |= options
    return Environment(
        loader=FunctionLoader(lambda name: _source(folders, name)),
        undefined=StrictUndefined,
        autoescape=False,
        **chosen,
    )


@dataclass(frozen=True)
class Script:
    """A script, ready to be written and run.

    ``name`` is that of its file; ``variables`` are the names of the values that may be set.
    """

    name: str
    text: str
    variables: frozenset[str]

    @cached_property
    def sha256(self) -> str:
        """Return the SHA-256 of the text, in hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()


@cache  # asked for each value of each job
def _ignored(script: Script, name: str) -> bool:
    """Return whether the text has a value's name no more often than it declares it."""
    stem = name.rpartition("_")[0] + "_"
    declared = [v for v in script.variables if v == name or v.startswith(stem)]
    # it may be put together of its stem and a letter
    return script.text.count(stem if "_" in name else name) <= len(declared)


@dataclass(frozen=True)
class Task:
    """A job with its script and the values that are set in it, by the script's names."""

    job: Job
    script: Script
    values: Mapping[str, Any]


class ScriptSource(Engine):
    """The part of an engine that renders scripts; nothing of it needs the code to be here.

    ``renders_variants``: whether each variant of a template is a script of its own
    (``<template>-<variant>.<extension>``), or all run that of the main one with other values.
    ``unused_values`` are those that no script has a use for. A sampled job sets each of the
    ``switches`` that its script declares. ``allowed`` is what variables of the engine's own may
    be. ``jinja`` are options of Jinja's environment.
    """

    extension: ClassVar[str] = "py"
    renders_variants: ClassVar[bool] = False
    unused_values: ClassVar[frozenset[str]] = frozenset()
    switches: ClassVar[Values] = {}
    allowed: ClassVar[Mapping[str, Allowed]] = {}
    jinja: ClassVar[Mapping[str, bool]] = {}

    @classmethod
    def literal(cls, value: Value) -> str:
        """Return a value as the code's scripts write it, at full precision."""
        return str(value)

    @classmethod
    def declared(cls, text: str) -> frozenset[str]:
        """Return the variables that may be set in a script: here the keys of ``PARAMETERS``."""
        block = re.search(r"^PARAMETERS = \{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL)
        return frozenset(re.findall(r'^ +"(\w+)":', block[1], re.MULTILINE) if block else ())

    @classmethod
    def context(cls, template: Template, variant: str) -> Mapping[str, Any]:  # noqa: ARG003
        """Return further names that the engine's templates use."""
        return {}

    def settings(self, job: Job) -> Values:  # noqa: ARG002
        """Return values that the engine sets besides the job's."""
        return {}

    @classmethod
    def has_template(cls, template: Template) -> bool:
        """Return whether there is a script of this name, or one was rendered."""
        if template.name == SCENE_NAME:
            return False
        key = (cls, template.package, template.name)
        with _LOCK:
            if any(rendered[:3] == key for rendered in _RENDERED):
                return True
        return cls._source(template) is not None

    @classmethod
    def script(cls, template: Template, variant: str = "") -> Script:
        """Return the script of a variant, rendered once.

        Raise RequestError for a template that the engine does not have, or an unknown variant.
        """
        chosen = variant or template.main
        if chosen not in template.variants:
            variants = ", ".join(template.variants)
            raise RequestError(
                f"{template.name!r} has no variant {variant!r}: must be one of {variants}"
            )
        if not cls.renders_variants:
            chosen = template.main
        key = (cls, template.package, template.name, chosen)
        with _LOCK:
            kept = _RENDERED.get(key)
            if kept is None or kept[0] != template:
                kept = _RENDERED[key] = (template, cls._render(template, chosen))
            return kept[1]

    @classmethod
    def rendered(cls) -> list[Script]:
        """Return the scripts of this engine that were rendered so far."""
        with _LOCK:
            return [script for (kind, *_), (_, script) in _RENDERED.items() if kind is cls]

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:
        """Return the scripts of all variants that the engine renders, by their names."""
        texts = {}
        for template in templates:
            if cls.has_template(template):
                for variant in template.variants:
                    script = cls.script(template, variant)
                    texts[script.name] = script.text
        return texts

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job: no template, its rules, an unknown value."""
        reason = super().refuses(job)
        if reason or not self.has_template(job.template):
            return reason
        script, values = self.script(job.template, job.variant), self._values(job)
        neutral = job.template.neutral
        for name, value in values.items():
            if name in script.variables:
                continue
            says_nothing = name in self.unused_values and name not in neutral
            if not says_nothing and value != neutral.get(name):
                return f"its script {script.name} has no variable {name!r} ({name} = {value!r})"
        return self._unused(job, script)

    @staticmethod
    def _unused(job: Job, script: Script) -> str:
        """Return which value a script declares and never uses, where that changes the motion."""
        neutral = job.template.neutral
        for name, value in job.values.items():
            if name in neutral and value != neutral[name] and _ignored(script, name):
                return f"its script {script.name} declares {name!r} and never uses it ({value!r})"
        return ""

    def task(self, job: Job) -> Task:
        """Return a job with its script and all that is set in it; check the job before."""
        script = self.script(job.template, job.variant)
        values = {**self._values(job), **(self.switches if job.sampled else {})}
        return Task(job, script, {n: v for n, v in values.items() if n in script.variables})

    def script_digest(self, job: Job) -> str:
        """Return the SHA-256 of the script that a job runs; empty for a scene."""
        if not self.has_template(job.template):
            return ""
        return self.script(job.template, job.variant).sha256

    def _values(self, job: Job) -> Values:
        """Return the values of a job, with the defaults of a variant that has no script."""
        in_script = self.renders_variants or not job.variant
        defaults = {} if in_script else job.template.variants[job.variant]
        return {**defaults, **job.values, **self.settings(job)}

    @classmethod
    def _render(cls, template: Template, variant: str) -> Script:
        from harness.model.scene import LOOK  # pydantic, which workers of LAMMPS do without

        source = cls._source(template)
        stem, settings = template.name, template.variants[variant]
        if source is None:
            raise RequestError(f"engine {cls.name!r} has no template {template.name!r}")
        if variant and cls.renders_variants:
            stem = f"{template.name}-{variant}"
        name = f"{stem}.{cls.extension}"
        defaults = {key: cls.literal(value) for key, value in settings.items()}
        values = {
            **defaults,
            "defaults": defaults,
            "values": settings,
            "about": template.about,
            "name": name,
            "variant": variant,
            "note": template.notes.get(variant, ""),
            "allowed": {},
            "look": LOOK,
            **cls.context(template, variant),
        }
        folders = [*cls._folders(template), *(folder for _, folder in cls._template_folders())]
        try:
            render = renderer(folders, source, cls.jinja)
            variables = cls.declared(render(values))
        except EngineError as error:
            package = f" of package {template.package!r}" if template.package else ""
            raise EngineError(
                f"{engine_label(cls)}: case {template.name!r}{package}: {error}"
            ) from error
        allowed = {**template.allowed, **cls.allowed}
        values["allowed"] = {n: limits for n, limits in allowed.items() if n in variables}
        return Script(name, render(values), variables)

    @classmethod
    def _source(cls, template: Template) -> str | None:
        """Return the file of a template, or None where no folder has it."""
        file = f"{template.name}.{cls.extension}.j2"
        return None if text_in(cls._folders(template), file) is None else file

    @classmethod
    def _folders(cls, template: Template) -> list[Folder]:
        """Return where templates are looked for: the case's package, then the engine's folders."""
        folders: list[Folder] = []
        if template.package:
            try:
                folders.append(resources.files(import_module(template.package)))
            except (ImportError, TypeError) as error:
                raise RequestError(
                    f"template {template.name!r}: package {template.package!r} cannot be "
                    f"imported ({error})"
                ) from None
            folders[0] = folders[0] / "templates" / cls.name
        return [*folders, *cls.own_folders()]

    @classmethod
    def own_folders(cls) -> list[Path]:
        """Return the folders of templates beside the engine's class and those it grew out of."""
        return [f for base, f in cls._template_folders() if not inspect.isabstract(base)]

    @classmethod
    def _template_folders(cls) -> list[tuple[type, Path]]:
        """Return each class of scripts behind this one with its folder; templates include all."""
        scripted = [base for base in cls.__mro__ if issubclass(base, ScriptSource)]
        return [(base, Path(inspect.getfile(base)).parent / "templates") for base in scripted]


_RENDERED: dict[tuple[type, str, str, str], tuple[Template, Script]] = {}
_LOCK = threading.RLock()
