"""MFiX-DEM as an engine of the harness: the batch solver that a user builds, its inputs, its runs.

A run is stated from its scene (``system.py``) as a keyword file and a list of particles, runs in a
fresh folder, and is read from the frames that MFiX writes. The folder ``recorded`` holds output of
21.3.2.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from harness.engines.contract import Job, Template
from harness.engines.mfix.contacts import (
    CONTACT,
    CONTACTS,
    OBTAIN,
    TRAITS,
    ContactInput,
    contact_table,
)
from harness.engines.mfix.system import (
    REFERENCE,
    Frame,
    Scheme,
    System,
    check_end,
    forced_table,
    path_table,
    read_frames,
    steps_per_contact,
    system_of,
)
from harness.engines.output import SERIES, Output, Table
from harness.engines.process import Ended, Limits, first_words, parallel_map, way_of_death
from harness.engines.programs import ASK_SECONDS, ProgramEngine, fresh_folder
from harness.engines.scripts import renderer
from harness.engines.traits import stating
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    RequestError,
)
from harness.observables.provenance import Provenance
from harness.parameters.law import Contact, contact_values
from harness.parameters.plane_scene import LOOK
from harness.parameters.scene import ContactScene

KEYWORDS, PARTICLES = "mfix.dat", "particle_input.dat"
"""The names that MFiX looks for."""

GRAIN, FORCE = "GRAIN", "FORCE"
"""Names of the files of particles and of contact forces, before ``_0000.vtp``."""

SEARCH_CELL = 2.4
"""[d] least width of the cells of the neighbour search, which looks half a cell about a particle:
neighbours are lost where half a cell is less than a diameter."""


def states_contact(template: Template) -> bool:
    """Return whether there is an input for contacts by the name of a template."""
    return _templates().joinpath(f"{template.name}.dat.j2").is_file()


def contact_files(contact: ContactInput, title: str = "") -> dict[str, str]:
    """Return the inputs of a contact with friction, by their names."""
    values = {"title": title or "A contact with friction.", **contact.context()}
    values["particles"] = len(contact.balls)
    keywords = _render("contacts.dat.j2", **_written(values))
    return {KEYWORDS: keywords, PARTICLES: _lines(contact.particles())}


def system_files(system: System, title: str = "") -> dict[str, str]:
    """Return the inputs of a system, by their names."""
    return {KEYWORDS: keyword_file(system, title), PARTICLES: particle_file(system)}


def keyword_file(system: System, title: str = "") -> str:
    """Return the text of ``mfix.dat``; its title is the system's name unless given."""
    width, height = system.box
    values = {
        "title": title or system.name,
        "name": system.name,
        "forces": system.forces,
        "held": bool(system.held),
        # half a step less: MFiX rounds the number of steps up, in single precision
        "stop": (system.first + system.steps - 0.5) * system.step,
        "start": system.first * system.step if system.first else "",
        "gravity_x": float(system.gravity[0]),
        "gravity_y": float(system.gravity[1]),
        "width": width,
        "height": height,
        "columns": _cells(width, system.diameter),
        "rows": _cells(height, system.diameter),
        "search_columns": _search_cells(width, system.diameter),
        "search_rows": _search_cells(height, system.diameter),
        "diameter": system.diameter,
        "density": system.density,
        "particles": len(system.spheres),
        "stiffness": system.stiffness,
        "restitution": system.restitution,
        "factor": system.factor,
        "scheme": system.scheme,
        "interval": system.every * system.step,
        "regions": [{"name": GRAIN, "data": "P"}, {"name": FORCE, "data": "F"}][
            : 1 + system.forces
        ],
    }
    return _render("mfix.dat.j2", **_written(values))


def particle_file(system: System) -> str:
    """Return the text of ``particle_input.dat``, version 1 in two dimensions.

    A line each, mobile ones first: x, y, radius, density, vx, vy.
    """
    radius, density = 0.5 * system.diameter, system.density
    return _lines((s.x, s.y, radius, density, s.vx, s.vy) for s in system.spheres)


def _lines(rows: Iterable[Iterable[float]]) -> str:
    return "".join(" ".join(map(_number, row)) + "\n" for row in rows)


def input_files(templates: Iterable[Template]) -> dict[str, str]:
    """Return an input of each template that has an example, by its name.

    An example ``templates/<template>.toml`` says in which values it differs from the template's
    main variant with the contact of the recorded runs, and has a title.
    """
    files: dict[str, str] = {}
    for template in templates:
        if states_contact(template):
            files |= _contact_examples(template)
        example = _templates().joinpath(f"{template.name}.toml")
        if template.scene is not None and example.is_file():
            table = tomllib.loads(example.read_text(encoding="utf-8"))
            system = _example(template, table)
            written = system_files(system, table["title"])
            files |= {f"{template.name}/{name}": text for name, text in written.items()}
    return files


def _contact_examples(template: Template) -> dict[str, str]:
    """Return the inputs of the variants of a contact that MFiX states as they stand."""
    files: dict[str, str] = {}
    for variant, values in template.variants.items():
        if stating(CONTACTS, values)[1]:
            continue
        title = f"A contact with friction: {template.notes[variant]}"
        written = contact_files(ContactInput(values), title)
        files |= {f"{template.name}-{variant}/{name}": t for name, t in written.items()}
    return files


def _example(template: Template, settings: Mapping[str, Any]) -> System:
    """Return the system of a template's example."""
    assert template.scene is not None
    defaults = template.variants[template.main]
    contact = {name: v for name, v in contact_values(CONTACT).items() if name in defaults}
    scene = template.scene({**defaults, **contact, **settings["values"]})
    if "velocity" in settings:
        grain, *others = scene.bodies
        grain = replace(grain, velocity=(*settings["velocity"], 0.0))
        scene = replace(scene, bodies=(grain, *others))
    return system_of(template.name, scene, scene.steps, scene.every or LOOK)


def _cells(length: float, diameter: float) -> int:
    """Return the number of cells, two diameters wide as in the recorded runs."""
    return max(3, math.floor(0.5 * length / diameter))


def _search_cells(length: float, diameter: float) -> int:
    return max(1, math.floor(length / (SEARCH_CELL * diameter)))


def _number(value: float) -> str:
    """Return the shortest Fortran double that reads back as the same number."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{point}d{int(exponent)}" if exponent else point


def _written(value: Any) -> Any:
    """Return numbers of a template's values, at any depth, as Fortran reads them."""
    if isinstance(value, float):
        return _number(value)
    if isinstance(value, dict):
        return {name: _written(item) for name, item in value.items()}
    return [_written(item) for item in value] if isinstance(value, list) else value


def _render(template: str, **values: object) -> str:
    return renderer([_templates()], template, {})(values)


def _templates() -> Traversable:
    return resources.files(__package__).joinpath("templates")


IN_HELP = ("mfix.dat", "<KEYWORD>=<VALUE>", "--print-flags")
"""Words of the help of a batch solver, and of no other program (``mfix.f``)."""

OLDEST = (21, 3)
"""The version whose source the inputs follow; older ones lack some of the keywords."""

UNVERSIONED = "unversioned"
"""The version of a build that was not told its own: cmake then writes 0.0, or in a checkout
without tags nothing."""

TRAPPED = (
    "its builds stop at a division by zero, an overflow or a value that is not a number; look for "
    "a restitution of 0, a step too coarse for the contact, numbers beyond 1e38 in its output"
)
"""What raises SIGFPE: cmake compiles with ``-ffpe-trap=invalid,zero,overflow``, in 21.3.2."""

REFUSAL = re.compile(r"^.*\b(?:Error|ERROR) \d+:.*$", re.MULTILINE)
"""What a numbered refusal of an input begins with."""

UNNUMBERED = re.compile(
    r"^ *(?:Illegal or unknown input|Invalid|Required input not specified)\b.*$", re.MULTILINE
)
"""What a refusal without a number begins with; the solver ends without a run."""


MOST_FRAMES = 100_000
"""Files that a run writes at most: MFiX writes one a sample."""

STRETCHES = (8.0, 32.0, 128.0, 512.0)
"""[sqrt(d/g)] that a scene is run for before all its steps: MFiX cannot stop early."""


class Mfix(ProgramEngine):
    """The batch solver of MFiX at ``program``, a path or a name on PATH.

    ``workers`` processes run side by side, as many as there are cores unless told
    otherwise. Raise EngineMissingError without a program or with one that is no MFiX,
    RequestError where there is no such file. ``scheme`` is MFiX's integrator.
    """

    name = "mfix"
    traits = TRAITS
    self_contained = True

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        scheme: Scheme = "EULER",
    ) -> None:
        super().__init__(program, workers, limits)
        self._scheme: Scheme = scheme
        self.opened_with["scheme"] = scheme
        if scheme != "EULER":
            self.traits = replace(self.traits, integrator=REFERENCE[scheme], contact_powers=())
        self.identify()

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the absolute path of the program, which must be named."""
        if program is None:
            raise EngineMissingError(f"MFiX was not found: {OBTAIN}")
        return super().find(program)

    @classmethod
    def deciding(cls, **options: Any) -> Mapping[str, str]:
        """Return the integrator."""
        return {"scheme": options.get("scheme", "EULER")}

    def ask_version(self) -> Provenance:
        """Return the version that the solver names, UNVERSIONED where it was built without one.

        Raise EngineMissingError where it is no MFiX, which is known by its help, or too old.
        """
        option = f"--program mfix={self.program}"
        help_text, usage = self.ask([self.program, "--help"])
        if usage.timed_out:
            raise EngineMissingError(f"{option} does not run: no answer within {ASK_SECONDS:g} s")
        if not all(word in help_text for word in IN_HELP):
            raise EngineMissingError(
                f"{option} is not an MFiX solver: its --help does not speak of "
                f"{IN_HELP[0]}{first_words(help_text)}"
            )
        text, answer = self.ask([self.program, "--version"])
        if answer.code != 0:
            raise EngineMissingError(
                f"{option} is not an MFiX solver: --version gave no version{first_words(text)}"
            )
        match = re.fullmatch(r"v?(\d+)\.(\d+)[\w.+-]*", text.strip())
        version = UNVERSIONED if match is None or match[1] == match[2] == "0" else match[0]
        if match and version is not UNVERSIONED and (int(match[1]), int(match[2])) < OLDEST:
            raise EngineMissingError(
                f"{option} is version {version}: must be 21.3 or later (tried: 21.3.2)"
            )
        return Provenance(self.name, version, (), self.program, "executable", KEYWORDS)

    @classmethod
    def states(cls, template: Template) -> bool:
        """Return whether it takes a template: as a scene, or as an input of its own."""
        return super().states(template) or states_contact(template)

    @classmethod
    def steps_of(cls, factor: float, contact: Contact) -> float:
        """Return the steps per contact of a ``DTSOLID_FACTOR``."""
        return steps_per_contact(factor, contact)

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job, or nothing where it can."""
        reason = super().refuses(job)
        if reason or job.template.scene is None:
            return reason
        try:
            scene = job.template.scene(job.values)
            _supported_system(job.template.name, scene, _stretches(scene)[0], self._scheme)
        except RequestError as error:
            return str(error)
        return ""

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the scenes of the jobs, a process for each, in longer stretches until decided."""
        self.check(jobs)
        return parallel_map(self._run_job, jobs, self.workers)

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:
        """Return the inputs of templates that have an example, by their names."""
        return input_files(templates)

    def progress(self, folder: Path) -> int:  # noqa: ARG002
        """Return 0: the limit is for all of a run, which writes a file each sample."""
        return 0

    def _run_job(self, job: Job) -> Output | EngineError:
        """Run one job until it is decided, or all its steps."""
        if job.template.scene is None:
            contact = ContactInput(job.values, self._scheme)
            return self._solve(contact_files(contact), lambda f, _: contact_table(contact, f))
        scene, seconds = job.template.scene(job.values), 0.0
        for steps in _stretches(scene):
            try:
                system = _supported_system(job.template.name, scene, steps, self._scheme)
            except RequestError as error:
                return EngineOutputError(f"MFiX: undecided after {seconds:.3g} s; {error}")
            output = self._solve(system_files(system), partial(_table, system, scene))
            if isinstance(output, EngineError):
                return output
            seconds += output.seconds
            output = replace(output, seconds=seconds)
            if scene.decided is None or scene.decided(output.tables[SERIES]):
                break
        return output

    def _solve(
        self, texts: Mapping[str, str], table: Callable[[list[Frame], list[Frame]], Table]
    ) -> Output | EngineError:
        """Run files in a folder of their own: what an earlier run left (``.RES``) stops a new one.

        ``table`` makes a table of frames of particles, and of forces. The log has the files.
        """
        if self.processes.closed:
            return self.closed_error()
        with fresh_folder() as folder:
            for file, text in texts.items():
                (folder / file).write_text(text, encoding="utf-8")
            ended = self.start([self.program, "-f", KEYWORDS], folder, self.limits.seconds)
            files = (f"# {file}\n{text}" for file, text in texts.items())
            log = "\n".join([f"# {Path(self.program).name} -f {KEYWORDS}", *files, ended.said])
            try:
                series = table(self._frames(folder, ended), read_frames(folder, FORCE))
            except EngineError as error:
                return error.with_log(log)
        return Output((), self.identify(), {SERIES: series}, log, ended.seconds, self.title)

    def _frames(self, folder: Path, ended: Ended) -> list[Frame]:
        """Return the frames of particles; raise EngineError for a run that failed."""
        refusal = REFUSAL.search(ended.said)
        if refusal is None and (ended.code != 0 or not any(folder.glob(f"{GRAIN}_*.vtp"))):
            refusal = UNNUMBERED.search(ended.said)
        if refusal is not None and not ended.timed_out:
            raise EngineInputError(f"MFiX refused its input: {refusal[0].strip()[:160]}")
        if way_of_death(ended.code) == "signal SIGFPE" and not ended.timed_out:
            raise EngineNaNError(f"MFiX died: signal SIGFPE: {TRAPPED}")
        error = ended.error(f"MFiX ({self.program})")
        if error is not None:
            raise error
        frames = read_frames(folder, GRAIN)
        if not frames:
            raise EngineOutputError(f"MFiX wrote no particles{first_words(ended.said)}")
        return frames


def _table(system: System, scene: ContactScene, frames: list[Frame], forces: list[Frame]) -> Table:
    """Return the table of a run; a scene that nothing decides early must reach its end."""
    if scene.forces:
        table = forced_table(system, scene, frames, forces)
    else:
        table = path_table(system, scene, frames)
    if scene.decided is None:
        check_end(system, frames)
    return table


def _stretches(scene: ContactScene) -> list[int]:
    """Return the steps to run a scene for, in order, until it is decided."""
    gravity = math.hypot(*scene.gravity)
    if scene.decided is None or gravity == 0.0:
        return [scene.steps]
    unit = math.sqrt(float(scene.diameter[0]) / gravity) / scene.step
    return sorted({*(min(math.ceil(s * unit), scene.steps) for s in STRETCHES), scene.steps})


def _supported_system(name: str, scene: ContactScene, steps: int, scheme: Scheme) -> System:
    """Return the system of a scene; raise RequestError for one that MFiX has no keywords for."""
    refused = TRAITS.refuses_contact(scene.contact)
    if scene.columns is not None:
        refused = "it holds no particles to the axis of a column"
    if refused:
        raise RequestError(refused)
    every = scene.every or max(LOOK, math.ceil(steps / MOST_FRAMES))
    system = system_of(name, scene, steps, every, scheme)
    frames = system.steps // system.every
    if frames > MOST_FRAMES:
        raise RequestError(
            f"every = {system.every} steps: MFiX writes a file each, {frames} of them; "
            f"must be at most {MOST_FRAMES}"
        )
    assert system.factor > 0.0
    return system
