"""``dem-harness theory`` and ``critical-angle``: the incline, in closed form and measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from harness.cli.app import ENGINE, Force, Json, MaybeWhole
from harness.cli.engines import EngineOptions, Opener, duration_check
from harness.cli.output import print_json, print_record, print_wrapped
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.cases.incline.system import Incline

CONTACT, SYSTEM = Group("Contact", sort_key=2), Group("System", sort_key=3)
EXTRAPOLATION_ANGLES = 9  # about as many searches as a ladder of steps and stiffnesses has
Reading = Literal["kept", "lost"]
Shape = Literal["sphere", "disc"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class AngleOptions:
    """How the angle is found."""

    method: Literal["passage", "steady"] = "passage"
    """`passage`: root of the energy margin over one well. `steady`: the smallest angle that keeps
    moving, the source's definition."""
    extrapolate: bool = False
    """Take the step to zero, then the stiffness to infinity (by passage; plastic contact unless
    another is named)."""
    tolerance: float | None = None
    """Resolution of the search, deg. [default: 0.001 passage, 0.005 steady]"""
    wells: MaybeWhole = None
    """Wells to pass in steady motion. [default: 10, below 20 steps per contact 100]"""
    engine: Annotated[str, Parameter(metavar="NAME", group=ENGINE)] = "lammps"
    """The engine: a name that `dem-harness engines` lists, or `module:Class` of your own."""
    force: Force = False

    def check(self, system: SystemOptions) -> None:
        """Raise RequestError for values out of range and options that exclude one another."""
        steady = self.method == "steady"
        if self.tolerance is not None and not 1e-9 <= self.tolerance <= 1.0:
            raise RequestError(f"--tolerance {self.tolerance!r}: must be from 1e-9 to 1 deg")
        if self.wells is not None and not steady:
            raise RequestError(f"--wells {self.wells}: goes with --method steady only")
        if self.extrapolate and steady:
            raise RequestError("--extrapolate: goes with --method passage only")
        if self.extrapolate and system.steps_per_contact is not None:
            raise RequestError("--extrapolate: has its own steps, without --steps-per-contact")


@Parameter(name="*", group=CONTACT)
@dataclass(frozen=True, kw_only=True)
class SystemOptions:
    """The contact, and the grain on its row."""

    contact: Literal["source", "clipped", "plastic"] | None = None
    """`source`: e = 1e-20, tail kept. `clipped`: critical damping, tail clipped. `plastic`:
    damping ratio 5, clipped. [default: source]"""
    restitution: float | None = None
    """Nominal restitution, 0 to 1; 0 is critical damping."""
    damping_ratio: float | None = None
    """Damping ratio zeta; overrides --restitution."""
    clip: Annotated[bool | None, Parameter(negative="--no-clip")] = None
    """Clip the attractive tail of a parting contact, or keep it."""
    half_mass: bool = False
    """Effective mass m/2 against a fixed sphere, as in MFiX, instead of m."""
    stiffness: float | None = None
    """Normal stiffness k, N/m. [default: 1e6]"""
    steps_per_contact: float | None = None
    """Steps per contact time pi sqrt(m/k). [default: 50]"""
    diameter: Annotated[float | None, Parameter(group=SYSTEM)] = None
    """Diameter of the row's spheres, m. [default: 1]"""
    density: Annotated[float | None, Parameter(group=SYSTEM)] = None
    """Density of the grain, kg/m3. [default: 6/pi, 1 kg at 1 m]"""
    gravity: Annotated[float | None, Parameter(group=SYSTEM)] = None
    """Gravity, m/s2. [default: 9.81]"""
    friction: Annotated[float | None, Parameter(group=SYSTEM)] = None
    """Coulomb's friction coefficient of the grain on the row. [default: 0]"""
    grain_diameter: Annotated[float | None, Parameter(group=SYSTEM)] = None
    """Diameter of the grain, m. [default: that of the row]"""
    shape: Annotated[Shape | None, Parameter(group=SYSTEM)] = None
    """Moment of inertia of a sphere or, in two dimensions, of a disc. [default: sphere]"""

    def case(self, default_contact: str) -> Incline:
        """Return the incline; raise RequestError, naming the option, for a wrong value."""
        from harness.cases.incline.system import Incline
        from harness.model.contact import CONTACTS, Contact

        own = ("contact", "restitution", "damping_ratio", "clip", "half_mass")
        damped = self.restitution is not None or self.damping_ratio is not None
        base = CONTACTS[self.contact or ("source" if damped else default_contact)]
        changes: dict[str, Any] = {}
        if damped:
            changes |= {"restitution": self.restitution, "damping_ratio": self.damping_ratio}
        if self.clip is not None:
            changes["tail"] = "clipped" if self.clip else "attractive"
        if self.half_mass:
            changes["effective_mass"] = "half"
        values = {k: v for k, v in vars(self).items() if k not in own and v is not None}
        if all(getattr(base, key) == value for key, value in changes.items()):
            return Incline(contact=base, **values)
        contact = Contact(**{**dict(base), **changes, "name": "custom"})
        named = (c for c in CONTACTS.values() if c.replace(name="custom") == contact)
        return Incline(contact=next(named, contact), **values)


def critical_angle(
    choice: AngleOptions = AngleOptions(),
    system: SystemOptions = SystemOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Measure the critical angle of the incline in an engine.

    Without options: the source's contact (e = 1e-20, attractive tail kept), k = 1e6 N/m, 50 steps
    per contact time, by passage. A single value agrees with 10.2078 deg by cancellation at best:
    --extrapolate proves it.

    For example:

        dem-harness critical-angle --extrapolate

        dem-harness critical-angle --engine yade --contact clipped
    """
    from harness.cases.incline.closed_form import angles_to_compare
    from harness.cases.registry import get_case
    from harness.engines.registry import engine_class
    from harness.workflows import critical_angle as by_search
    from harness.workflows import extrapolated_critical_angle
    from harness.workflows.progress import progress_bars
    from harness.workflows.runs import run_seconds

    choice.check(system)
    case = system.case("plastic" if choice.extrapolate else "source")
    engines.check([choice.engine], "--engine")
    traits, opener = engine_class(choice.engine).traits, Opener(engines)
    angles = EXTRAPOLATION_ANGLES if choice.extrapolate else 1
    work = f"a critical angle at stiffness {case.stiffness:g} N/m in {choice.engine}"
    check_duration = duration_check(choice.force, work)
    check_duration(angles * run_seconds(get_case("incline"), case, traits, ["critical_angle_deg"]))
    with (
        progress_bars("critical-angle", quiet=json) as progress,
        opener.qualified(choice.engine, progress=progress) as engine,
    ):
        if choice.extrapolate:
            found = extrapolated_critical_angle(case, engine=engine, progress=progress).to_json()
        else:
            found = by_search(
                case, method=choice.method, tolerance_deg=choice.tolerance, wells=choice.wells,
                engine=engine, progress=progress,
            ).to_json()  # fmt: skip
    return opener.answer({**angles_to_compare(case.contact), **found}, choice.engine, json, _print)


def theory(  # noqa: PLR0913 - the options of a user
    *,
    shock: float | None = None,
    restitution: float | None = None,
    impulse_ratio: float | None = None,
    reading: Reading | None = None,
    friction: float | None = None,
    grain_diameter: float | None = None,
    shape: Shape | None = None,
    diameter: float | None = None,
    json: Json = False,
) -> int:
    """Return the critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock)); 10.2078 deg without
    rebound. With --restitution two readings of the source make the shock of one collision:
    one_shock_kept_deg, one_shock_lost_deg. event_driven_deg is the angle of rigid spheres by
    events, every rebound followed, up to a restitution of 0.7.

    With --friction or --grain-diameter, `model` says whether the angle is a closed form: without
    friction, and from rolling_friction on. Between them arcs and shocks of a rigid grain are
    integrated under Coulomb's limit. A grain so small that it leaves the row is refused.

    For example:

        dem-harness theory --restitution 0.5

        dem-harness theory --friction 0.5 --shape disc

    Parameters
    ----------
    shock
        Energy after over energy before the shock, 0 to 1. [default: 1/4]
    restitution
        Normal restitution e, 0 to 1, that makes the shock.
    impulse_ratio
        Impulse ratio alpha = J(n)/J(1), 0 to 2, that makes the shock.
    reading
        How e or alpha makes a shock: `kept`, energy after over before (default for e); `lost`,
        from the velocity lost, as the source prints it (default for alpha).
    friction
        Coulomb's friction coefficient of the grain on the row.
    grain_diameter
        Diameter of the grain, m. [default: that of the row]
    shape
        `sphere`, or `disc` in two dimensions: moment of inertia of a grain that rolls.
    diameter
        Diameter of the row's spheres, m. [default: 1]
    """
    from harness.workflows import theory as closed_form

    record = closed_form(
        shock=shock, restitution=restitution, impulse_ratio=impulse_ratio, reading=reading,
        friction=friction, grain_diameter=grain_diameter, shape=shape, diameter=diameter,
    ).to_json()  # fmt: skip
    (print_json if json else print_record)(record)
    return 0


def _print(record: Mapping[str, Any]) -> None:
    value, error = record["critical_angle_deg"], record["uncertainty_deg"]
    who = f"{record['engine']} {record['engine_version']}, {record['method']}"
    print_wrapped(f"critical angle: {value:.7g} +- {error:.2g} deg ({who})")
    if (expected := record.get("closed_form_deg")) is not None:
        print_wrapped(f"closed form: {expected:.7g} deg, difference {value - expected:+.2g} deg")
    print_record(record)
