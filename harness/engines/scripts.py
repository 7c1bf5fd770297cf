"""Scripts: templates rendered with the defaults of a variant, and what a job sets in them.

A template lies in ``templates/<name>.<extension>.j2`` of an engine's folder, or, where the case
belongs to another package, in ``<package>/templates/<engine>/``. Jinja sees every default as
:meth:`ScriptSource.literal` writes it, and all as ``defaults``, with ``values`` (the same as
numbers), ``about`` (their descriptions), ``name`` (the file), ``version``, ``variant``, ``note``,
``look`` and ``allowed``: the allowed values of the variables that the script declares.
"""

from __future__ import annotations

import hashlib
import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
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


def renderer(
    folders: Sequence[Folder], file: str, options: Mapping[str, bool]
) -> Callable[[Mapping[str, Any]], str]:
    """Return a function from the values of a template to its text, ended by a line feed."""

    def rendered(values: Mapping[str, Any]) -> str:
        try:
            environment = _environment(tuple(folders), tuple(sorted(options.items())))
            text = environment.get_template(file).render(version=__version__, **values)
        except HarnessError:
            raise
        except Exception as error:
            message = " ".join(str(error).split())[:160]
            raise EngineError(
                f"template {file} cannot be rendered: {type(error).__name__}: {message}"
            ) from error
        return text if text.endswith("\n") else text + "\n"

    return rendered


@cache  # what templates include is compiled once
def _environment(folders: tuple[Folder, ...], options: tuple[tuple[str, bool], ...]) -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    def source(name: str) -> tuple[str, str, None] | None:
        paths = (folder / name for folder in folders)
        path = next((path for path in paths if path.is_file()), None)
        return None if path is None else (path.read_text(encoding="utf-8"), name, None)

    chosen: dict[str, Any] = {"trim_blocks": True, "keep_trailing_newline": True, **dict(options)}
    return Environment(
        loader=FunctionLoader(source), undefined=StrictUndefined, autoescape=False, **chosen
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
        """Return whether there is a script of this name."""
        return template.name != SCENE_NAME and _has_file(cls, template.package, template.name)

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
        if key not in _RENDERED or _RENDERED[key][0] != template:
            _RENDERED[key] = (template, cls._render(template, chosen))
        return _RENDERED[key][1]

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:
        """Return the scripts of all variants that the engine renders, by their names."""
        scripts = [
            cls.script(template, variant)
            for template in templates
            if cls.has_template(template)
            for variant in template.variants
        ]
        return {script.name: script.text for script in scripts}

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job: no template, its rules, an unknown value."""
        reason = super().refuses(job)
        if reason or not self.has_template(job.template):
            return reason
        script, neutral = self.script(job.template, job.variant), job.template.neutral
        for name, value in self._values(job).items():
            unused = name in self.unused_values and name not in neutral
            if name not in script.variables and not unused and value != neutral.get(name):
                return f"its script {script.name} has no variable {name!r} ({name} = {value!r})"
        return ""

    def task(self, job: Job) -> Task:
        """Return a job with its script and all that is set in it; check the job before."""
        script = self.script(job.template, job.variant)
        values = {**self._values(job), **(self.switches if job.sampled else {})}
        return Task(job, script, {n: v for n, v in values.items() if n in script.variables})

    def script_digest(self, job: Job) -> str:
        """Return the SHA-256 of the script that a job runs; empty for a scene."""
        has_script = self.has_template(job.template)
        return self.script(job.template, job.variant).sha256 if has_script else ""

    def _values(self, job: Job) -> Values:
        """Return the values of a job, with the defaults of a variant that has no script."""
        in_script = self.renders_variants or not job.variant
        defaults = {} if in_script else job.template.variants[job.variant]
        return {**defaults, **job.values, **self.settings(job)}

    @classmethod
    def _render(cls, template: Template, variant: str) -> Script:
        from harness.model.scene import LOOK  # pydantic, which workers of LAMMPS do without

        if not cls.has_template(template):
            raise RequestError(f"engine {cls.name!r} has no template {template.name!r}")
        stem = f"{template.name}-{variant}" if variant and cls.renders_variants else template.name
        name = f"{stem}.{cls.extension}"
        settings = template.variants[variant]
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
        folders = [*cls._folders(template.package), *map(_folder, cls._scripted())]
        render = renderer(folders, f"{template.name}.{cls.extension}.j2", cls.jinja)
        try:
            variables = cls.declared(render(values))
            allowed = {**template.allowed, **cls.allowed}
            values["allowed"] = {n: limits for n, limits in allowed.items() if n in variables}
            return Script(name, render(values), variables)
        except EngineError as error:
            package = f" of package {template.package!r}" if template.package else ""
            where = f"{engine_label(cls)}: case {template.name!r}{package}"
            raise EngineError(f"{where}: {error}") from error

    @classmethod
    def _scripted(cls) -> list[type]:
        """Return the classes of scripts behind this one, whose templates may be included."""
        return [base for base in cls.__mro__ if issubclass(base, ScriptSource)]

    @classmethod
    def _folders(cls, package: str) -> list[Folder]:
        """Return where templates are looked for: the case's package, then the engine's folders."""
        folders = [_folder(base) for base in cls._scripted() if not inspect.isabstract(base)]
        if not package:
            return folders
        try:
            root = resources.files(import_module(package))
        except (ImportError, TypeError) as error:
            raise RequestError(
                f"templates of package {package!r}: it cannot be imported ({error})"
            ) from None
        return [root / "templates" / cls.name, *folders]


def _folder(kind: type) -> Folder:
    return Path(inspect.getfile(kind)).parent / "templates"


@cache
def _has_file(kind: type[ScriptSource], package: str, name: str) -> bool:
    file = f"{name}.{kind.extension}.j2"
    return any((folder / file).is_file() for folder in kind._folders(package))


_RENDERED: dict[tuple[type, str, str, str], tuple[Template, Script]] = {}
