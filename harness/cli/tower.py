"""``dem-harness tower`` and ``impulse``: one run of a tower, a table over towers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from harness.cli.app import ENGINE, File, Force, Json, Whole
from harness.cli.engines import EngineOptions, Opener, duration_check
from harness.cli.output import check_target, print_frame, print_record, write_all, write_csv
from harness.cli.sweep import figure_writer
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.engines.base import Traits

OWN = ("rk4", "exact")  # solvers of this package; --help must not wait for numba
FORMATS = (".svg", ".png", ".pdf")
MOST_HEIGHT = 10_000
Window = Literal["turnaround", "structure", "first-contact"]


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class SolverOptions:
    """Who runs the towers."""

    solver: Annotated[str, Parameter(metavar="NAME")] = "rk4"
    """`rk4`: fixed steps of fourth order. `exact`: modes, without a step. Or an engine that
    `dem-harness engines` lists, or `module:Class`; the deformable law in LAMMPS in-process."""

    def traits(self) -> Traits | None:
        """Return those of the engine, None for a solver; RequestError for an unknown name."""
        from harness.engines.registry import engine_class

        if self.solver in OWN:
            return None
        try:
            return engine_class(self.solver).traits
        except RequestError as error:
            text = str(error).replace("--engine", "--solver", 1)
            raise RequestError(f"{text}; or a solver of this package: {', '.join(OWN)}") from None

    @contextmanager
    def open(self, opener: Opener, title: str, quiet: bool) -> Iterator[dict[str, Any]]:
        """Yield solver, engine and progress of a workflow; raise RequestError likewise."""
        from harness.workflows.progress import progress_bars

        is_own = self.traits() is None
        opener.options.check({self.solver} - set(OWN), "--solver")
        with progress_bars(title, quiet=quiet) as progress:
            if is_own:
                yield {"solver": self.solver, "engine": None, "progress": progress}
                return
            with opener.qualified(self.solver, progress=progress) as engine:
                yield {"solver": None, "engine": engine, "progress": progress}


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TowerOptions:
    """The tower and the grain, and how it is run."""

    height: Whole = 1
    """Contacts; particles - 1."""
    stiffness: float = 1e6
    """Normal stiffness [N/m]."""
    mass: float = 1.0
    """Mass of each particle [kg]."""
    speed: float = 2.0
    """Speed of the grain at the start [m/s]."""
    gravity: float = 9.81
    """Gravity along the motion [m/s2]; 0 is the air hockey table."""
    law: Literal["overlap", "deformable"] = "deformable"
    """Contact law: what DEM codes do, or the source's."""
    base: Literal["fixed", "free"] = "fixed"
    """Whether the last particle moves."""
    duration: float = 3.0
    """How long, in contact times t0 of grain and one fixed particle."""
    steps_per_contact: float | None = None
    """Steps in pi sqrt(m/k). [default: 4000 rk4, 1000 engines]"""
    window: Window = "turnaround"
    """What the impulse is summed over."""
    series: File = None
    """Write the series to this CSV file."""
    force: Force = False


def tower(
    choice: TowerOptions = TowerOptions(),
    solver: SolverOptions = SolverOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Drop a grain on a tower of particles: force, impulse and contacts of the grain.

    The tower stands on a fixed base, at rest and just touching; the grain arrives with its speed,
    gravity along the motion. Times are in t0, the time that the grain would stay on one fixed
    particle.

    For example:

        dem-harness tower --height 4 --law overlap --solver lammps

        dem-harness tower --height 2 --window first-contact --series tower.csv
    """
    from harness.cases.registry import get_case
    from harness.cases.tower.impulse import Runner
    from harness.cases.tower.parameters import Tower
    from harness.cases.tower.windows import summary
    from harness.workflows import tower as run_tower
    from harness.workflows.runs import run_seconds

    check_target(choice.series, "--series")
    names = vars(choice).keys() & Tower.model_fields.keys()
    case = Tower(**{name: getattr(choice, name) for name in names})
    chosen, opener = get_case("tower"), Opener(engines)
    timing = {"duration": max(choice.duration, 3.0), "steps_per_contact": choice.steps_per_contact}
    seconds = run_seconds(chosen, chosen.parameters(**{**dict(case), **timing}), solver.traits())
    work = f"the tower (--height {choice.height} --duration {choice.duration:g})"
    duration_check(choice.force, work)(seconds)
    with solver.open(opener, "tower", json) as options:
        found = run_tower(
            case, duration=choice.duration, steps_per_contact=choice.steps_per_contact, **options
        )
        longer = Runner(options["solver"] or OWN[0], options["engine"])
        record = summary(found, choice.window, longer.covering(found, choice.window))
    write_all({("--series", choice.series): partial(write_csv, found.to_frame())})
    return opener.answer(record, solver.solver, json, print_record)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ImpulseOptions:
    """The rows of the table, how an impulse ratio becomes an angle, and files."""

    heights: str = "1-19"
    """Heights, as `1-19` or `1,2,5`."""
    stiffness: Annotated[list[str], Parameter(metavar="NUMBERS")] = field(default_factory=list)
    """Normal stiffnesses [N/m], commas or repeated. [default: 1e5,1e6,1e7]"""
    speed: Annotated[list[str], Parameter(metavar="NUMBERS")] = field(default_factory=list)
    """Speeds of the grain [m/s], commas or repeated. [default: 2,4]"""
    law: Literal["overlap", "deformable", "both"] = "both"
    """Contact law: what DEM codes do, the source's, or both."""
    window: Literal["turnaround", "structure", "first-contact", "all"] = "turnaround"
    """Impulse until: `turnaround`, twice the time of closest approach (the source's);
    `structure`, the grain's chain swings from all contacts to one; `first-contact`, the grain
    first detaches."""
    gravity: float = 9.81
    """Gravity along the motion [m/s2]."""
    mass: float = 1.0
    """Mass of each particle [kg]."""
    reading: Literal["lost", "kept"] = "lost"
    """Critical angle from alpha: `lost` rescales the velocity lost in the shock, sqrt(shock) = 1
    - alpha/2, and falls with height; `kept` the velocity kept, alpha/2, and rises."""
    reference: File = None
    """Measured angles for the figure: CSV with the columns h_over_d and theta_deg."""
    figure: File = None
    """Draw critical angle against height: .svg, .png or .pdf."""
    csv: File = None
    """Write the table to this file."""
    force: Force = False

    def over(self) -> dict[str, Any]:
        """Return the ranges of the table; raise RequestError for lists that cannot be read."""
        ranges: dict[str, Any] = {"heights": _heights(self.heights)}
        if self.stiffness:
            ranges["stiffnesses"] = _numbers(self.stiffness, "--stiffness")
        if self.speed:
            ranges["speeds"] = _numbers(self.speed, "--speed")
        if self.law != "both":
            ranges["laws"] = (self.law,)
        windows = ("turnaround", "structure", "first-contact")
        return ranges | {"windows": windows if self.window == "all" else (self.window,)}

    def check_files(self) -> None:
        """Raise RequestError for files that cannot be written."""
        check_target(self.figure, "--figure", FORMATS)
        check_target(self.csv, "--csv")
        if self.figure and self.csv and self.figure.resolve() == self.csv.resolve():
            raise RequestError(f"--figure and --csv {self.csv}: must be two files")
        if self.reference is not None and self.figure is None:
            raise RequestError(f"--reference {self.reference}: goes with --figure FILE only")


def impulse(
    choice: ImpulseOptions = ImpulseOptions(),
    solver: SolverOptions = SolverOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Tabulate impulse on the grain and critical angle against the height of the tower.

    alpha(n) = J(n) / J(1): the impulse on a grain dropped on a tower of height n, over that on a
    rigid base. It rescales the shock in the well of the incline, hence the critical angle. Without
    options: the source's six runs, both laws.

    For example:

        dem-harness impulse --heights 1-4 --stiffness 1e6 --speed 2

        dem-harness impulse --law overlap --figure angles.svg --reference measured.csv
    """
    from harness.cases.tower.parameters import Tower
    from harness.cases.tower.show import angle_figure
    from harness.workflows import impulse as tabulate
    from harness.workflows.points import read_points

    choice.check_files()
    file, over = choice.reference, choice.over()
    points = None if file is None else read_points(file, "h_over_d", "theta_deg")
    case, opener = Tower(mass=choice.mass, gravity=choice.gravity), Opener(engines)
    with solver.open(opener, "impulse", json) as options:
        frame = tabulate(case=case, reading=choice.reading, **options, **over)
    measured = None if points is None else (points.x.tolist(), points.y.tolist())
    draw = partial(angle_figure, frame, readings=(choice.reading,), measured=measured)
    suffix = "" if choice.figure is None else choice.figure.suffix
    write_all({("--csv", choice.csv): partial(write_csv, frame),
               ("--figure", choice.figure): figure_writer(draw, suffix)})  # fmt: skip
    record: dict[str, Any] = {"solver": solver.solver, "reading": choice.reading}
    record["rows"] = frame.to_dict(orient="records")
    if measured is not None:
        pairs = zip(*measured, strict=True)
        record["reference"] = [{"h_over_d": h, "theta_deg": angle} for h, angle in pairs]
    return opener.answer(record, solver.solver, json, lambda _: print_frame(frame, len(frame)))


def _heights(text: str) -> list[int]:
    """Return the heights of ``1-19,30``, each once. Raise RequestError for anything else."""
    numbers: dict[int, None] = {}
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip(), re.ASCII)
        first, last = (int(ends[1]), int(ends[2] or ends[1])) if ends else (0, 0)
        if not 1 <= first <= last <= MOST_HEIGHT:
            raise RequestError(
                f"--heights {text!r}: {part.strip()!r} must be a whole number or a range that "
                f"rises, as 1-19, within 1 to {MOST_HEIGHT}"
            )
        numbers |= dict.fromkeys(range(first, last + 1))
    return list(numbers)


def _numbers(texts: Sequence[str], option: str) -> list[float]:
    """Return the numbers of ``["1e5,1e6", "1e7"]``, each once. Raise RequestError for others."""
    numbers: dict[float, None] = {}
    for text in texts:
        for part in text.split(","):
            try:
                numbers[float(part)] = None
            except ValueError:
                raise RequestError(f"{option} {text!r}: {part!r} must be a number") from None
    return list(numbers)
