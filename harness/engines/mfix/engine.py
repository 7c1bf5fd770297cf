"""MFiX-DEM as an engine of the harness: the batch solver that a user builds, its inputs and runs.

``system.py`` puts a scene in MFiX's terms, ``frames.py`` reads the motion from what it writes.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from harness.engines.contract import Job, Template
from harness.engines.mfix.frames import motion, read_frames
from harness.engines.mfix.system import REFERENCE, Scheme, System, steps_per_contact, system_of
from harness.engines.output import SERIES, Output, Table
from harness.engines.process import Ended, Limits, first_words, parallel_map, way_of_death
from harness.engines.programs import ProgramEngine, fresh_folder
from harness.engines.scripts import renderer
from harness.engines.traits import FRICTIONLESS, ContactModel, ContactValues, Traits
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    RequestError,
)
from harness.observables.provenance import Provenance
from harness.parameters.law import Contact, contact_of, contact_values
from harness.parameters.plane_scene import LOOK

KEYWORDS, PARTICLES = "mfix.dat", "particle_input.dat"  # the names that MFiX looks for
TEMPLATES = resources.files(__package__).joinpath("templates")

CONTACT = Contact(name="MFiX", restitution=1e-20, effective_mass="half")  # the source's

REFUSAL = re.compile(r"(?im)^.*\berror \d+:.*$|^ *(?:Illegal|Invalid|Required input)\b.*$")
MOST_FRAMES = 100_000  # files that a run writes at most, one a sample
STRETCHES = (8.0, 32.0, 128.0, 512.0)  # [sqrt(d/g)] to run first: MFiX cannot stop early


def input_texts(system: System) -> dict[str, str]:
    """Return the inputs of a system by their names."""
    values = system.keywords()
    size = (0.5 * values["diameter"], values["density"])
    spheres = zip(system.place.tolist(), system.start_velocity().tolist(), strict=True)
    lines = (" ".join(map(_fortran, (*place, *size, *moves))) for place, moves in spheres)
    written = {name: _fortran(value) for name, value in values.items()}
    keywords = renderer([TEMPLATES], "mfix.dat.j2", {})(written)
    return {KEYWORDS: keywords, PARTICLES: "".join(f"{line}\n" for line in lines)}


def _fortran(value: Any) -> Any:
    """Return a float as the shortest Fortran double that reads back the same."""
    if not isinstance(value, float):
        return value
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{point}d{int(exponent)}" if exponent else point


def _underdamped(values: ContactValues) -> str:
    """Return why a dashpot cannot be stated, or nothing where it can."""
    if "damping" not in values or contact_of(values).zeta <= CONTACT.zeta:
        return ""
    return f"takes a restitution of at least 1e-20, a damping ratio of at most {CONTACT.zeta:g}"


class Mfix(ProgramEngine):
    """The batch solver of MFiX at ``program``, by default ``mfixsolver`` on PATH.

    ``scheme`` is MFiX's integrator. Raise EngineMissingError without a program or for another one.
    """

    name = "mfix"
    programs = ("mfixsolver",)
    self_contained = True
    traits = Traits(
        install_hint="build it (mfix.netl.doe.gov, MFiX 21.3.2, batch solver, "
        "cmake -DVERSION=21.3.2) and give --program mfix=PATH",
        versions=("21.3.2",),
        integrator="mfix-euler",
        microseconds_per_step=32.0,
        frictionless=ContactModel(
            "contact",
            FRICTIONLESS | {"tail": ("attractive",), "effective_mass": ("half",)},
            needs=_underdamped,
        ),
        digits=7,
        title="MFiX",
        caveats=(
            "m_eff is m/2 against fixed spheres too: a restitution of 1e-20 is 0.044.",
            "At e = 1e-20 the default DTSOLID_FACTOR of 50 is 4.8 steps per pi sqrt(m/k).",
            "No keyword holds a particle: fixed spheres hang at a mass outflow of no velocity.",
        ),
    )

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
        self.traits = replace(self.traits, integrator=REFERENCE[scheme])
        self.identify()

    @classmethod
    def deciding(cls, **options: Any) -> Mapping[str, str]:
        """Return the integrator."""
        return {"scheme": options.get("scheme", "EULER")}

    def ask_version(self) -> Provenance:
        """Return the version; raise EngineMissingError for another program, known by its help."""
        usage, _ = self.ask([self.program, "--help"])
        if not ("mfix.dat" in usage and "<KEYWORD>=<VALUE>" in usage):
            raise EngineMissingError(
                f"--program mfix={self.program} is not an MFiX solver{first_words(usage)}"
            )
        version = self.ask([self.program, "--version"])[0].strip().removeprefix("v")
        if version == "0.0" or not re.match(r"\d+\.\d+", version):
            version = "unversioned"  # a build without -DVERSION calls itself 0.0, or nothing
        return Provenance(self.name, version, (), self.program, "executable", KEYWORDS)

    @classmethod
    def steps_of(cls, factor: float, contact: Contact) -> float:
        """Return the steps per contact of a ``DTSOLID_FACTOR``."""
        return steps_per_contact(factor, contact)

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:
        """Return the inputs of templates that have an example, by their names."""
        examples = tomllib.loads(TEMPLATES.joinpath("examples.toml").read_text(encoding="utf-8"))
        texts: dict[str, str] = {}
        for template in templates:
            if template.scene is not None and template.name in examples:
                main = template.variants[template.main]
                contact = {n: value for n, value in contact_values(CONTACT).items() if n in main}
                scene = template.scene({**main, **contact, **examples[template.name]})
                system = system_of(template.name, scene, scene.steps, scene.every, "EULER")
                for name, text in input_texts(system).items():
                    texts[f"{template.name}/{name}"] = text
        return texts

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job, or nothing where it can."""
        if reason := super().refuses(job):
            return reason
        try:
            self._systems(job)
        except RequestError as error:
            return str(error)
        return ""

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the scenes of the jobs, a process for each, in longer stretches until decided."""
        self.check(jobs)
        return parallel_map(self._run_job, jobs, self.workers)

    def _systems(self, job: Job) -> list[System]:
        """Return ever longer stretches of a job's scene; RequestError where MFiX cannot run it."""
        assert job.template.scene is not None
        scene = job.template.scene(job.values)
        stretches, gravity = {scene.steps}, math.hypot(*scene.gravity)
        if scene.decided is not None and gravity > 0.0:
            unit = math.sqrt(float(scene.diameter[0]) / gravity) / scene.step
            stretches |= {min(math.ceil(s * unit), scene.steps) for s in STRETCHES}
        systems = []
        for steps in sorted(stretches):
            every = scene.every or max(LOOK, math.ceil(steps / MOST_FRAMES))
            if steps <= MOST_FRAMES * every:
                systems.append(system_of(job.template.name, scene, steps, every, self._scheme))
        if not systems:
            raise RequestError(f"every = {every} steps: MFiX writes more than {MOST_FRAMES} files")
        systems[0].keywords()  # raises for a step that is too coarse
        return systems

    def _run_job(self, job: Job) -> Output | EngineError:
        seconds = 0.0
        for system in self._systems(job):
            output = self._solve(system, seconds)
            if isinstance(output, EngineError):
                break
            seconds, decided = output.seconds, system.scene.decided
            if decided is None or decided(output.tables[SERIES]):
                break
        return output

    def _solve(self, system: System, before: float) -> Output | EngineError:
        """Run a system in a fresh folder, where no restart file stops it, after some seconds."""
        if self.processes.closed:
            return self.closed_error()
        texts = input_texts(system)
        with fresh_folder() as folder:
            for file, text in texts.items():
                (folder / file).write_text(text, encoding="utf-8")
            ended = self.start([self.program, "-f", KEYWORDS], folder, self.limits.seconds)
            log = "\n".join(f"# {file}\n{text}" for file, text in texts.items()) + ended.said
            try:
                series = self._series(system, folder, ended)
            except EngineError as error:
                return error.with_log(log)
        return Output(
            (), self.identify(), {SERIES: series}, log, before + ended.seconds, self.title
        )

    def _series(self, system: System, folder: Path, ended: Ended) -> Table:
        """Return the motion that a run left; raise EngineError for one that failed."""
        wrote, refusal = any(folder.glob("GRAIN_*.vtp")), REFUSAL.search(ended.said)
        if refusal and (ended.code or not wrote) and not ended.timed_out:
            raise EngineInputError(f"MFiX refused its input: {refusal[0].strip()[:160]}")
        if way_of_death(ended.code) == "signal SIGFPE":
            raise EngineNaNError("MFiX died: signal SIGFPE: an overflow, or not a number")
        if error := ended.error(f"MFiX ({self.program})"):
            raise error
        if not wrote:
            raise EngineOutputError(f"MFiX wrote no particles{first_words(ended.said)}")
        return motion(system, read_frames(folder, "GRAIN"), read_frames(folder, "FORCE"))
