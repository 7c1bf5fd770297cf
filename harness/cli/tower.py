"""``dem-harness tower`` and ``impulse``: one run of a tower, a table over towers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from harness.cli.app import ENGINE, File, Force, Json, Whole
from harness.cli.engines import EngineOptions, Opener, duration_check
from harness.cli.output import check_target, print_frame, print_record, write_all
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.engines.base import Traits

SOLVERS = ("rk4", "exact")  # of this package; --help must not wait for numba
WINDOWS = ("turnaround", "structure", "first-contact")
MOST_HEIGHT = 10_000
Numbers = Annotated[list[str], Parameter(metavar="NUMBERS")]
SOLVER_HELP = (
    "`rk4`: fixed steps of fourth order. `exact`: modes, without a step. Or an engine that "
    "`dem-harness engines` lists, or `module:Class`; the deformable law in LAMMPS in-process."
)
Solver = Annotated[str, Parameter(metavar="NAME", group=ENGINE, help=SOLVER_HELP)]


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
    window: Literal["turnaround", "structure", "first-contact"] = "turnaround"
    """What the impulse is summed over."""
    series: File = None
    """Write the series to this CSV file."""
    solver: Solver = "rk4"
    force: Force = False


def tower(
    choice: TowerOptions = TowerOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Drop a grain on a tower of particles: force, impulse and contacts of the grain.

    The tower is on a fixed base, at rest and just touching; the grain arrives with its speed,
    gravity along the motion. Times are in t0, the time that the grain would stay on one fixed
    particle.

    For example:

        dem-harness tower --height 4 --law overlap --solver lammps

        dem-harness tower --height 2 --window first-contact --series tower.csv
    """
    from harness.cases.registry import get_case
    from harness.cases.tower.impulse import Runner, summary
    from harness.cases.tower.parameters import Tower
    from harness.workflows import tower as run_tower
    from harness.workflows.runs import run_seconds

    check_target(choice.series, "--series")
    traits, opener, tower_case = _traits(choice.solver, engines), Opener(engines), get_case("tower")
    case = Tower(
        **{name: value for name, value in vars(choice).items() if name in Tower.model_fields}
    )
    timing = {"duration": max(choice.duration, 3.0), "steps_per_contact": choice.steps_per_contact}
    parameters = tower_case.parameters(**{**dict(case), **timing})
    work = f"the tower (--height {choice.height} --duration {choice.duration:g})"
    duration_check(choice.force, work)(run_seconds(tower_case, parameters, traits))
    with opener.measuring(choice.solver, "tower", quiet=json, solvers=SOLVERS) as options:
        run = run_tower(
            case, duration=choice.duration, steps_per_contact=choice.steps_per_contact, **options
        )
        longer = Runner(options.get("solver", ""), options.get("engine"))
        record = summary(run, choice.window, longer.covering(run, choice.window))
    write_all({("--series", choice.series): partial(run.to_frame().to_csv, index=False)})
    return opener.answer(record, json, print_record)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ImpulseOptions:
    """The rows of the table, how an impulse ratio becomes an angle, and files."""

    heights: str = "1-19"
    """Heights, as `1-19` or `1,2,5`."""
    stiffness: Numbers = field(default_factory=list)
    """Normal stiffnesses [N/m], commas or repeated. [default: 1e5,1e6,1e7]"""
    speed: Numbers = field(default_factory=list)
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
    solver: Solver = "rk4"
    force: Force = False


def impulse(
    choice: ImpulseOptions = ImpulseOptions(),
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
    from harness.cases.tower.impulse import SPEEDS, STIFFNESSES, angle_figure
    from harness.cases.tower.parameters import LAWS, Tower
    from harness.workflows import impulse as tabulate
    from harness.workflows.sweep_figure import figure_writer, read_points

    check_target(choice.figure, "--figure", (".svg", ".png", ".pdf"))
    check_target(choice.csv, "--csv")
    if choice.figure and choice.csv and choice.figure.resolve() == choice.csv.resolve():
        raise RequestError(f"--figure and --csv {choice.csv}: must be two files")
    if choice.reference is not None and choice.figure is None:
        raise RequestError(f"--reference {choice.reference}: goes with --figure FILE only")
    ranges: dict[str, Any] = {
        "heights": _heights(choice.heights),
        "stiffnesses": _numbers(choice.stiffness, "--stiffness") or STIFFNESSES,
        "speeds": _numbers(choice.speed, "--speed") or SPEEDS,
        "laws": LAWS if choice.law == "both" else (choice.law,),
        "windows": WINDOWS if choice.window == "all" else (choice.window,),
    }
    record: dict[str, Any] = {"solver": choice.solver, "reading": choice.reading}
    measured = None
    if choice.reference is not None:
        points = read_points(choice.reference, "h_over_d", "theta_deg")
        measured = points.x.tolist(), points.y.tolist()
        pairs = zip(*measured, strict=True)
        record["reference"] = [{"h_over_d": h, "theta_deg": angle} for h, angle in pairs]
    _traits(choice.solver, engines)
    case, opener = Tower(mass=choice.mass, gravity=choice.gravity), Opener(engines)
    with opener.measuring(choice.solver, "impulse", quiet=json, solvers=SOLVERS) as options:
        frame = tabulate(case=case, reading=choice.reading, **options, **ranges)
    draw = partial(angle_figure, frame, readings=(choice.reading,), measured=measured)
    write_all({("--csv", choice.csv): partial(frame.to_csv, index=False),
               ("--figure", choice.figure): figure_writer(draw)})  # fmt: skip
    record["rows"] = frame.to_dict(orient="records")
    return opener.answer(record, json, lambda _: print_frame(frame, len(frame)))


def _traits(solver: str, engines: EngineOptions) -> Traits | None:
    """Return those of an engine, None for a solver; RequestError for an unknown name or option."""
    from harness.engines.registry import engine_class

    engines.check({solver} - set(SOLVERS), "--solver")
    try:
        return None if solver in SOLVERS else engine_class(solver).traits
    except RequestError as error:
        text, names = str(error).replace("--engine", "--solver", 1), ", ".join(SOLVERS)
        raise RequestError(f"{text}; or a solver of this package: {names}") from None


def _numbers(texts: Sequence[str], option: str) -> list[float]:
    """Return numbers with commas between, each once; raise RequestError for anything else."""
    numbers: dict[float, None] = {}
    for text in texts:
        for part in text.split(","):
            try:
                numbers[float(part)] = None
            except ValueError:
                raise RequestError(f"{option} {text!r}: {part!r} must be a number") from None
    return list(numbers)


def _heights(text: str) -> list[int]:
    """Return whole numbers of a text as 1-19 or 1,2,5, each once; raise RequestError for others."""
    heights: dict[int, None] = {}
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip(), re.ASCII)
        first, last = (int(ends[1]), int(ends[2] or ends[1])) if ends else (0, 0)
        if not 1 <= first <= last <= MOST_HEIGHT:
            raise RequestError(
                f"--heights {text!r}: {part.strip()!r} must be a whole number or a range that "
                f"rises, as 1-19, within 1 to {MOST_HEIGHT}"
            )
        heights |= dict.fromkeys(range(first, last + 1))
    return list(heights)
