"""``dem-harness theory``, ``critical-angle``, ``tower``, ``impulse``: the two systems by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from math import prod
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_args

from cyclopts import Parameter, validators

from harness import workflows
from harness.cli import options
from harness.cli.options import ENGINE, EngineOptions, Json, Number, Opener, opener
from harness.cli.output import check_target, show, write_all
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.model.base import Parameters

P = TypeVar("P", bound="Parameters")
TOLERANCES = validators.Number(gte=1e-9, lte=1.0)  # [deg]
RUNS, LADDER = 30, 270  # of a search for a critical angle, and of an extrapolation, by their time
SOLVERS = ("rk4", "exact")  # of this package; --help must not wait for numba
Law = Literal["overlap", "deformable"]
Window = Literal["turnaround", "structure", "first-contact"]
Values = Mapping[str, Any]


# ---- the incline


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class GrainOptions:
    """Grain and row of ``theory`` and ``critical-angle``."""

    restitution: Number = None
    """Normal restitution e, 0 to 1."""
    friction: Number = None
    """Coulomb's friction coefficient of the grain on the row. [default: 0]"""
    grain_diameter: Number = None
    """Diameter of the grain [m]. [default: that of the row]"""
    shape: Literal["sphere", "disc"] | None = None
    """Moment of inertia of a sphere or, in two dimensions, of a disc. [default: sphere]"""
    diameter: Number = None
    """Diameter of the row's spheres [m]. [default: 1]"""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TheoryOptions(GrainOptions):
    """The shock."""

    shock: Number = None
    """Energy after over energy before the shock, 0 to 1, unless the restitution makes it.
    [default: 1/4]"""
    impulse_ratio: Number = None
    """Impulse ratio alpha = J(n)/J(1), 0 to 2, that makes the shock."""
    reading: Literal["kept", "lost"] | None = None
    """How e or alpha makes a shock: `kept`, energy after over before (default for e); `lost`,
    from the velocity lost, as the source prints it (default for alpha)."""


def theory(choice: TheoryOptions = TheoryOptions(), *, json: Json = False) -> int:
    """Return the critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock)); 10.2078 deg without
    rebound. With --restitution two readings of the source make the shock of one collision:
    one_shock_kept_deg, one_shock_lost_deg. event_driven_deg is the angle of rigid spheres by
    events, every rebound followed, up to a restitution of 0.7.

    With --friction or --grain-diameter, `model` is a closed form, without friction and from
    rolling_friction on, or an integration. Between them arcs and shocks of a rigid grain are
    integrated under Coulomb's limit. A grain so small that it leaves the row is refused.
    """
    return show(workflows.theory(**vars(choice)).to_json(), json)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class AngleOptions(GrainOptions):
    """How the angle is found, and of which contact."""

    stiffness: float = 1e6
    """Normal stiffness k [N/m]."""
    gravity: float = 9.81
    """Gravity [m/s2]."""
    steps_per_contact: Number = None
    """Steps per contact time pi sqrt(m/k). [default: 50]"""
    method: Literal["passage", "steady"] = "passage"
    """Root of the energy over a well, or smallest angle of lasting motion (the source's)."""
    extrapolate: bool = False
    """Take the step to zero, then the stiffness to infinity (plastic contact unless named)."""
    tolerance: Annotated[Number, Parameter(validator=TOLERANCES)] = None
    """Resolution of the search, 1e-9 to 1 deg. [default: 0.001 passage, 0.005 steady]"""
    wells: options.MaybeWhole = None
    """Wells to pass in steady motion. [default: 10, more with friction or another size of the
    grain; below 20 steps per contact 100 at least]"""
    engine: Annotated[str, Parameter(metavar="NAME", group=ENGINE)] = "lammps"
    """The engine: a name that `dem-harness engines` lists, or `module:Class` of your own."""
    contact: Literal["source", "clipped", "plastic"] | None = None
    """`source`: e = 1e-20, no clip. `clipped`: critical damping. `plastic`: zeta = 5, clipped."""
    damping_ratio: Number = None
    """Damping ratio zeta; overrides --restitution."""
    clip: Annotated[bool | None, Parameter(negative="--no-clip")] = None
    """Clip the attractive tail of a parting contact, or keep it."""
    half_mass: bool = False
    """Effective mass m/2 against a fixed sphere, as in MFiX, instead of m."""
    density: Number = None
    """Density of the grain [kg/m3]. [default: 6/pi, 1 kg at 1 m]"""


def critical_angle(
    choice: AngleOptions = AngleOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Measure the critical angle of the incline in an engine.

    Without options: the source's contact (e = 1e-20, attractive tail kept), k = 1e6 N/m, 50 steps
    per contact time, by passage. A single value agrees with 10.2078 deg by cancellation at best:
    --extrapolate proves it.
    """
    from harness.cases.incline.closed_form import angles_to_compare
    from harness.cases.incline.system import Incline, changed_contact

    settings = (choice.method, choice.steps_per_contact, choice.tolerance, choice.wells)
    if choice.extrapolate and settings != ("passage", None, None, None):
        others = "--method steady, --steps-per-contact, --tolerance and --wells"
        raise RequestError(f"--extrapolate: goes without {others}")
    damping = choice.restitution, choice.damping_ratio
    usual = "plastic" if choice.extrapolate and damping == (None, None) else "source"
    contact = changed_contact(choice.contact or usual, *damping, choice.clip, choice.half_mass)
    case = _parameters(Incline, choice, contact=contact)
    _check("--engine", choice.engine, engines, dict(case), LADDER if choice.extrapolate else RUNS)
    with opener(engines, "critical-angle", json) as opening, opening.qualified(choice.engine) as on:
        shared: dict[str, Any] = {"engine": on, "progress": opening.progress}
        if choice.extrapolate:
            record = workflows.extrapolated_critical_angle(case, **shared).to_json()
        else:
            shared |= {"method": choice.method, "tolerance_deg": choice.tolerance}
            record = workflows.critical_angle(case, wells=choice.wells, **shared).to_json()
    return opening.show({**angles_to_compare(case), **record}, json)


# ---- the tower


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ChainOptions:
    """Particles of ``tower`` and ``impulse``, and what runs them."""

    mass: float = 1.0
    """Mass of each particle [kg]."""
    gravity: float = 9.81
    """Gravity along the motion [m/s2]; 0 is the air hockey table."""
    solver: Annotated[str, Parameter(metavar="NAME", group=ENGINE)] = "rk4"
    """`rk4`: fixed steps of fourth order. `exact`: modes, without a step. Or an engine that
    `dem-harness engines` lists, or `module:Class`; the deformable law in LAMMPS in-process."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TowerOptions(ChainOptions):
    """The tower and the grain, and how it is run."""

    stiffness: float = 1e6
    """Normal stiffness k [N/m]."""
    steps_per_contact: Number = None
    """Steps per contact time pi sqrt(m/k). [default: 4000 by rk4, 1000 in engines]"""
    height: options.Whole = 1
    """Contacts; particles - 1."""
    speed: float = 2.0
    """Speed of the grain at the start [m/s]."""
    law: Law = "deformable"
    """Contact law: what DEM codes do, or the source's."""
    base: Literal["fixed", "free"] = "fixed"
    """Whether the last particle moves."""
    duration: float = 3.0
    """How long, in contact times t0 of grain and one fixed particle."""
    window: Window = "turnaround"
    """What the impulse is summed over."""
    series: options.File = None
    """Write the series to this CSV file."""


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
    """
    from harness.cases.tower.impulse import Runner, summary
    from harness.cases.tower.parameters import Tower

    check_target(choice.series, "--series")
    case = _parameters(Tower, choice)
    timing: dict[str, Any] = {
        "duration": choice.duration,
        "steps_per_contact": choice.steps_per_contact,
    }
    longest = {**dict(case), **timing, "duration": max(choice.duration, 3.0)}
    with _runner(choice.solver, engines, "tower", json, longest) as (opening, runner):
        run = workflows.tower(case, **timing, **runner)
        longer = Runner(runner["solver"], runner["engine"])
        record = summary(run, choice.window, longer.covering(run, choice.window))
    write_all({("--series", choice.series): partial(run.to_frame().to_csv, index=False)})
    return opening.show(record, json)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ImpulseOptions(ChainOptions):
    """The rows of the table, how an impulse ratio becomes an angle, and files."""

    heights: options.WholeNumbers = None
    """Heights, as `1-19` or `1,2,5`. [default: 1-19]"""
    stiffness: options.Numbers = None
    """Normal stiffnesses [N/m], commas or repeated. [default: 1e5,1e6,1e7]"""
    speed: options.Numbers = None
    """Speeds of the grain [m/s], commas or repeated. [default: 2,4]"""
    law: Literal["overlap", "deformable", "both"] = "both"
    """Contact law: what DEM codes do, the source's, or both."""
    window: Literal["turnaround", "structure", "first-contact", "all"] = "turnaround"
    """Impulse until twice the time of closest approach, the swing to one contact, or detachment."""
    reading: Literal["lost", "kept"] = "lost"
    """Critical angle from alpha: `lost` rescales the velocity lost in the shock, sqrt(shock) = 1
    - alpha/2, and falls with height; `kept` the velocity kept, alpha/2, and rises."""
    reference: options.File = None
    """Measured angles for the figure: CSV with the columns h_over_d and theta_deg."""
    figure: options.File = None
    """Draw critical angle against height: .svg, .png or .pdf."""
    csv: options.File = None
    """Write the table to this file."""


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
    """
    from harness.cases.tower.impulse import HEIGHTS, MEASURED, SPEEDS, STIFFNESSES, angle_figure
    from harness.cases.tower.parameters import Tower
    from harness.report.figures import figure_writer
    from harness.workflows.settings import read_numbers

    if choice.reference is not None and choice.figure is None:
        raise RequestError(f"--reference {choice.reference}: goes with --figure FILE only")
    check_target(choice.csv, "--csv", (), choice.reference)
    figures = (".svg", ".png", ".pdf")
    check_target(choice.figure, "--figure", figures, choice.csv, choice.reference)
    ranges: dict[str, Any] = {
        "heights": choice.heights or HEIGHTS,
        "stiffnesses": choice.stiffness or STIFFNESSES,
        "speeds": choice.speed or SPEEDS,
        "laws": get_args(Law) if choice.law == "both" else (choice.law,),
    }
    runs = prod(map(len, ranges.values()))
    ranges["windows"] = get_args(Window) if choice.window == "all" else (choice.window,)
    measured = None if choice.reference is None else read_numbers(choice.reference, MEASURED)
    case = Tower(mass=choice.mass, gravity=choice.gravity)
    tallest = {**dict(case), "height": max(ranges["heights"]), "law": "overlap"}  # either: as long
    with _runner(choice.solver, engines, "impulse", json, tallest, runs) as (opening, runner):
        frame = workflows.impulse(case=case, reading=choice.reading, **ranges, **runner)
    draw = partial(angle_figure, frame, readings=(choice.reading,), measured=measured)
    write_all({("--csv", choice.csv): partial(frame.to_csv, index=False),
               ("--figure", choice.figure): figure_writer(draw)})  # fmt: skip
    record: dict[str, Any] = {"solver": choice.solver, "reading": choice.reading}
    record |= {} if measured is None else {"reference": measured.to_dict(orient="records")}
    return opening.show({**record, "rows": frame.to_dict(orient="records")}, json)


# ---- what they share


def _parameters(kind: type[P], choice: AngleOptions | TowerOptions, **more: Any) -> P:
    values = {name: value for name, value in vars(choice).items() if value is not None}
    return kind(**{name: values[name] for name in kind.model_fields if name in values} | more)


def _check(option: str, name: str, engines: EngineOptions, values: Values, runs: int) -> None:
    """Raise RequestError for an unknown engine or option, and for runs that take too long."""
    from harness.cases.registry import get_case
    from harness.engines.registry import engine_class
    from harness.workflows.runs import run_seconds

    case = get_case("incline" if option == "--engine" else "tower")
    engines.check({name} - set(SOLVERS), option)
    try:
        traits = None if name in SOLVERS else engine_class(name).traits
    except RequestError as error:
        text = str(error).replace("--engine", option, 1)
        solvers = f"; or a solver of this package: {', '.join(SOLVERS)}"
        raise RequestError(text + (solvers if option == "--solver" else "")) from None
    seconds = runs * run_seconds(case, case.parameters(**values), traits)
    engines.check_seconds(seconds, f"{case.name} in {name}")


@contextmanager
def _runner(
    name: str, engines: EngineOptions, title: str, quiet: bool, values: Values, runs: int = 1
) -> Iterator[tuple[Opener, dict[str, Any]]]:
    """Yield an opener, and solver, engine and progress as arguments of a workflow."""
    _check("--solver", name, engines, values, runs)
    if is_solver := name in SOLVERS:
        engines.check_no_cluster(name)
    with (
        opener(engines, title, quiet) as opening,
        nullcontext() if is_solver else opening.qualified(name) as engine,
    ):
        solver = engine.name if engine else name
        yield opening, {"solver": solver, "engine": engine, "progress": opening.progress}
