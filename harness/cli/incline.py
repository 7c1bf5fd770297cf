"""``dem-harness theory`` and ``critical-angle``: the incline, in closed form and measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter, validators

from harness.cli.app import ENGINE, Force, Json, MaybeWhole
from harness.cli.engines import EngineOptions, Opener, duration_check
from harness.cli.output import print_json, print_record, print_wrapped
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.cases.incline.system import Incline

EXTRAPOLATION_ANGLES = 9  # about as many searches as a ladder of steps and stiffnesses has
TOLERANCES = validators.Number(gte=1e-9, lte=1.0)  # [deg]
Number = float | None
Shape = Literal["sphere", "disc"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TheoryOptions:
    """The arguments of :func:`harness.workflows.theory`."""

    shock: Number = None
    """Energy after over energy before the shock, 0 to 1. [default: 1/4]"""
    restitution: Number = None
    """Normal restitution e, 0 to 1, that makes the shock."""
    impulse_ratio: Number = None
    """Impulse ratio alpha = J(n)/J(1), 0 to 2, that makes the shock."""
    reading: Literal["kept", "lost"] | None = None
    """How e or alpha makes a shock: `kept`, energy after over before (default for e); `lost`,
    from the velocity lost, as the source prints it (default for alpha)."""
    friction: Number = None
    """Coulomb's friction coefficient of the grain on the row."""
    grain_diameter: Number = None
    """Diameter of the grain, m. [default: that of the row]"""
    shape: Shape | None = None
    """`sphere`, or `disc` in two dimensions: moment of inertia of a grain that rolls."""
    diameter: Number = None
    """Diameter of the row's spheres, m. [default: 1]"""


def theory(choice: TheoryOptions = TheoryOptions(), *, json: Json = False) -> int:
    """Return the critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock)); 10.2078 deg without
    rebound. With --restitution two readings of the source make the shock of one collision:
    one_shock_kept_deg, one_shock_lost_deg. event_driven_deg is the angle of rigid spheres by
    events, every rebound followed, up to a restitution of 0.7.

    With --friction or --grain-diameter, `model` is a closed form, without friction and from
    rolling_friction on, or an integration. Between them arcs and shocks of a rigid grain are
    integrated under Coulomb's limit. A grain so small that it leaves the row is refused.

    For example:

        dem-harness theory --restitution 0.5

        dem-harness theory --friction 0.5 --shape disc
    """
    from harness.workflows import theory as closed_form

    (print_json if json else print_record)(closed_form(**vars(choice)).to_json())
    return 0


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class AngleOptions:
    """How the angle is found, of which contact and grain."""

    method: Literal["passage", "steady"] = "passage"
    """`passage`: root of the energy margin over one well. `steady`: the smallest angle that keeps
    moving, the source's definition."""
    extrapolate: bool = False
    """Take the step to zero, then the stiffness to infinity (by passage; plastic contact unless
    another is named)."""
    tolerance: Annotated[Number, Parameter(validator=TOLERANCES)] = None
    """Resolution of the search, 1e-9 to 1 deg. [default: 0.001 passage, 0.005 steady]"""
    wells: MaybeWhole = None
    """Wells to pass in steady motion. [default: 10, below 20 steps per contact 100]"""
    engine: Annotated[str, Parameter(metavar="NAME", group=ENGINE)] = "lammps"
    """The engine: a name that `dem-harness engines` lists, or `module:Class` of your own."""
    contact: Literal["source", "clipped", "plastic"] | None = None
    """`source`: e = 1e-20, tail kept. `clipped`: critical damping, tail clipped. `plastic`:
    damping ratio 5, clipped. [default: source]"""
    restitution: Number = None
    """Nominal restitution, 0 to 1; 0 is critical damping."""
    damping_ratio: Number = None
    """Damping ratio zeta; overrides --restitution."""
    clip: Annotated[bool | None, Parameter(negative="--no-clip")] = None
    """Clip the attractive tail of a parting contact, or keep it."""
    half_mass: bool = False
    """Effective mass m/2 against a fixed sphere, as in MFiX, instead of m."""
    stiffness: Number = None
    """Normal stiffness k, N/m. [default: 1e6]"""
    steps_per_contact: Number = None
    """Steps per contact time pi sqrt(m/k). [default: 50]"""
    diameter: Number = None
    """Diameter of the row's spheres, m. [default: 1]"""
    density: Number = None
    """Density of the grain, kg/m3. [default: 6/pi, 1 kg at 1 m]"""
    gravity: Number = None
    """Gravity, m/s2. [default: 9.81]"""
    friction: Number = None
    """Coulomb's friction coefficient of the grain on the row. [default: 0]"""
    grain_diameter: Number = None
    """Diameter of the grain, m. [default: that of the row]"""
    shape: Shape | None = None
    """Moment of inertia of a sphere or, in two dimensions, of a disc. [default: sphere]"""
    force: Force = False

    def system(self) -> Incline:
        """Return the incline; raise RequestError, naming the field, for a wrong value."""
        from harness.cases.incline.system import Incline
        from harness.model.law import CONTACTS, Contact

        damping = {"restitution": self.restitution, "damping_ratio": self.damping_ratio}
        is_damped = any(value is not None for value in damping.values())
        usual = "plastic" if self.extrapolate and not is_damped else "source"
        changes: dict[str, Any] = dict(damping) if is_damped else {}
        if self.clip is not None:
            changes["tail"] = "clipped" if self.clip else "attractive"
        if self.half_mass:
            changes["effective_mass"] = "half"
        contact = Contact(**{**dict(CONTACTS[self.contact or usual]), **changes, "name": "custom"})
        same = (c for c in CONTACTS.values() if c.replace(name="custom") == contact)
        names = [n for n in Incline.model_fields if vars(self).get(n) is not None]
        values = {name: getattr(self, name) for name in names}
        return Incline(**{**values, "contact": next(same, contact)})


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

    For example:

        dem-harness critical-angle --extrapolate

        dem-harness critical-angle --engine yade --contact clipped
    """
    from harness.cases.incline.closed_form import angles_to_compare
    from harness.cases.registry import get_case
    from harness.engines.registry import engine_class
    from harness.workflows import critical_angle as by_search
    from harness.workflows import extrapolated_critical_angle
    from harness.workflows.runs import run_seconds

    if choice.wells is not None and choice.method == "passage":
        raise RequestError(f"--wells {choice.wells}: goes with --method steady only")
    if choice.extrapolate and choice.method == "steady":
        raise RequestError("--extrapolate: goes with --method passage only")
    if choice.extrapolate and choice.steps_per_contact is not None:
        raise RequestError("--extrapolate: has its own steps, without --steps-per-contact")
    options: dict[str, Any] = {
        "method": choice.method,
        "tolerance_deg": choice.tolerance,
        "wells": choice.wells,
    }
    measure: Callable[..., Any] = (
        extrapolated_critical_angle if choice.extrapolate else partial(by_search, **options)
    )
    case, searches = choice.system(), EXTRAPOLATION_ANGLES if choice.extrapolate else 1
    engines.check([choice.engine], "--engine")
    traits, opener = engine_class(choice.engine).traits, Opener(engines)
    seconds = run_seconds(get_case("incline"), case, traits, ["critical_angle_deg"])
    work = f"a critical angle at stiffness {case.stiffness:g} N/m in {choice.engine}"
    duration_check(choice.force, work)(searches * seconds)
    with opener.measuring(choice.engine, "critical-angle", quiet=json) as running:
        record = measure(case, **running).to_json()
    return opener.answer({**angles_to_compare(case.contact), **record}, json, _print)


def _print(record: Mapping[str, Any]) -> None:
    value, error = record["critical_angle_deg"], record["uncertainty_deg"]
    runner = f"{record['engine']} {record['engine_version']}, {record['method']}"
    print_wrapped(f"critical angle: {value:.7g} +- {error:.2g} deg ({runner})")
    if (expected := record.get("closed_form_deg")) is not None:
        print_wrapped(f"closed form: {expected:.7g} deg, difference {value - expected:+.2g} deg")
    print_record(record)
