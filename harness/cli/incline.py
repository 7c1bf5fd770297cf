"""``dem-harness critical-angle`` and ``theory``: the incline, measured and in closed form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from harness.cli.command import ContactName, Json, Reading, options, panel
from harness.cli.engine_options import EngineOptions, LongRunOptions, answer, completed
from harness.cli.files import (
    print_json,
    print_record,
    print_wrapped,
)
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.cases.incline.system import Incline
    from harness.engines.contract import Engine
    from harness.parameters.law import Contact
    from harness.workflows.progress import Progress


@options()
class RouteOptions(LongRunOptions):
    """How the angle is found."""

    method: Literal["passage", "steady"] = "passage"
    """`passage`: root of the energy margin over one well. `steady`: the smallest angle that keeps
    moving, the source's definition."""
    extrapolate: bool = False
    """Take the step to zero, then the stiffness to infinity (passage route; plastic contact
    unless told otherwise). The ladder spans a factor of 10 about --stiffness."""
    tolerance: float | None = None
    """Resolution of the search, deg. [default: 0.001 passage, 0.005 steady]"""
    wells: int | None = None
    """Wells to pass in steady motion. [default: 10, below 20 steps per contact 100]"""

    def check(self, system: InclineOptions) -> None:
        """Raise RequestError for a tolerance out of range and options that exclude one another."""
        if self.tolerance is not None and not 1e-9 <= self.tolerance <= 1.0:
            raise RequestError(
                f"--tolerance {self.tolerance!r} is not allowed: must be from 1e-9 to 1 deg"
            )
        steady = self.method == "steady"
        if self.wells is not None and not steady:
            raise RequestError(f"--wells {self.wells}: goes with --method steady only")
        step_options = {
            "--method steady": steady or None,
            "--steps-per-contact": system.steps_per_contact,
            "--engine-step": system.engine_step,
        }
        for name, value in step_options.items():
            if self.extrapolate and value is not None:
                text = f"{name} cannot go with --extrapolate, which runs a ladder of steps"
                raise RequestError(text)

    def check_contact(self, case: Incline) -> None:
        """Raise RequestError for a contact that a passage cannot measure."""
        from harness.cases.incline.angle import check_passage
        from harness.cases.incline.levels import Ladder

        if self.method == "passage":
            with _options_named():
                check_passage(*(Ladder().cases(case) if self.extrapolate else [case]))

    def check_cost(self, case: Incline, engine: Engine) -> None:
        """State what a search costs; raise RequestError for one too long, unless it is forced."""
        from harness.cases.incline.angle import passing
        from harness.cases.incline.levels import angle_seconds, extrapolation_seconds

        if self.extrapolate:
            seconds = extrapolation_seconds(case, engine.traits)
        else:
            changed = passing(case, self.wells) if self.method == "steady" else case
            seconds = angle_seconds(changed, self.method, engine.traits)
        self.check_duration(
            seconds, f"a critical angle at --stiffness {case.stiffness:g} in {engine.name}"
        )

    def measure(self, case: Incline, engine: Engine, progress: Progress) -> dict[str, Any]:
        """Return the record of the critical angle."""
        from harness.cases.incline import angle as verb

        if self.extrapolate:
            return verb.extrapolated_critical_angle(
                case, engine=engine, progress=progress
            ).to_json()
        return verb.critical_angle(
            case,
            method=self.method,
            tolerance_deg=self.tolerance,
            wells=self.wells,
            engine=engine,
            progress=progress,
        ).to_json()


@options()
class InclineOptions:
    """Stiffness, step and system."""

    stiffness: Annotated[float, Parameter(group=panel("Contact"))] = 1e6
    """Normal stiffness k, N/m."""
    steps_per_contact: Annotated[float | None, Parameter(group=panel("Contact"))] = None
    """Steps per contact time pi sqrt(m/k). [default: 50]"""
    engine_step: Annotated[float | None, Parameter(metavar="NUMBER", group=panel("Contact"))] = None
    """The step as the engine counts it, in place of --steps-per-contact: of MFiX its
    DTSOLID_FACTOR."""
    diameter: Annotated[float, Parameter(group=panel("System"))] = 1.0
    """Diameter of all spheres, m."""
    density: Annotated[float | None, Parameter(group=panel("System"))] = None
    """Density of the grain, kg/m3. [default: 6/pi, 1 kg at 1 m]"""
    gravity: Annotated[float, Parameter(group=panel("System"))] = 9.81
    """Gravity, m/s2."""

    def case(self, engine: str, contact: Contact) -> Incline:
        """Return the incline; raise RequestError for values that are not allowed."""
        from harness.cases.incline.system import Incline

        optional = {"steps_per_contact": self._steps(engine, contact), "density": self.density}
        return Incline(
            contact=contact,
            stiffness=self.stiffness,
            diameter=self.diameter,
            gravity=self.gravity,
            **{name: value for name, value in optional.items() if value is not None},
        )

    def _steps(self, engine: str, contact: Contact) -> float | None:
        """Return the requested steps per contact, from either option; None without one."""
        from harness.engines.registry import engine_class

        if self.engine_step is None:
            return self.steps_per_contact
        if self.steps_per_contact is not None:
            raise RequestError("--engine-step and --steps-per-contact: must be one of the two")
        return engine_class(engine).steps_of(self.engine_step, contact)


@options("Contact")
class ContactOptions:
    """The contact: a named one, and what is changed in it."""

    contact: ContactName | None = None
    """`source`: e = 1e-20, tail kept. `clipped`: critical damping, tail clipped. `plastic`:
    damping ratio 5, clipped. [default: source]"""
    restitution: float | None = None
    """Nominal restitution, 0 to 1; 0 is critical damping."""
    damping_ratio: float | None = None
    """Damping ratio zeta; overrides --restitution. Plastic contact is 5, clipped."""
    clip: Annotated[bool | None, Parameter(negative="--no-clip")] = None
    """Clip the attractive tail of a parting contact, or keep it."""
    half_mass: bool = False
    """Effective mass m/2 against a fixed sphere, as in MFiX, instead of m."""

    def contact_or(self, default: ContactName) -> Contact:
        """Return the named contact with what the other options change in it.

        A restitution or damping ratio without a name starts from the source's rules.
        """
        from harness.parameters.law import CONTACTS, Contact

        own_damping = self.restitution is not None or self.damping_ratio is not None
        base = CONTACTS[self.contact or ("source" if own_damping else default)]
        changes: dict[str, Any] = {}
        if own_damping:
            changes |= {"restitution": self.restitution, "damping_ratio": self.damping_ratio}
        if self.clip is not None:
            changes["tail"] = "clipped" if self.clip else "attractive"
        if self.half_mass:
            changes["effective_mass"] = "half"
        changed = {key: value for key, value in changes.items() if getattr(base, key) != value}
        if not changed:
            return base
        custom = Contact(**{**dict(base), **changed, "name": "custom"})
        return next((c for c in CONTACTS.values() if c.replace(name="custom") == custom), custom)


def critical_angle(
    route: RouteOptions = RouteOptions(),
    contact: ContactOptions = ContactOptions(),
    system: InclineOptions = InclineOptions(),
    engine: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Critical angle of the frictionless incline, measured in an engine.

    Without options: the source's contact (e = 1e-20, attractive tail kept),
    k = 1e6 N/m, 50 steps per contact time, passage route. A single value agrees
    with 10.2078 deg by cancellation at best: --extrapolate is what proves it.

    For example:

        dem-harness critical-angle --extrapolate
        dem-harness critical-angle --engine yade --program yade=/opt/yade/bin/yade --contact clipped
    """
    from harness.cases.incline.closed_forms import angles_beside
    from harness.workflows import progress_bars

    touching = contact.contact_or("plastic" if route.extrapolate else "source")
    route.check(system)
    case = system.case(engine.engine, touching)
    route.check_contact(case)
    with progress_bars("critical-angle", quiet=json) as progress, engine.run() as opened:
        route.check_cost(case, opened)
        with _options_named():
            angle = route.measure(case, opened, progress)
        record = completed({**angles_beside(touching), **angle}, opened, progress)
    return answer(record, engine.engine, json, _print)


@contextmanager
def _options_named() -> Iterator[None]:
    """Name the options in an error that names the arguments of Python."""
    try:
        yield
    except RequestError as error:
        text = str(error).replace("method = 'passage'", "--method passage")
        raise RequestError(text.replace("method 'steady'", "--method steady")) from None


def _print(record: Mapping[str, Any]) -> None:
    """Print the angle, who measured it and what is expected; then all that belongs to it."""
    print_wrapped(
        f"critical angle: {record['critical_angle_deg']:.7g} +- {record['uncertainty_deg']:.2g} deg"
        f" ({record['engine']} {record['engine_version']}, {record['method']})"
    )
    expected = record.get("closed_form_deg")
    if expected is not None:
        apart = record["critical_angle_deg"] - expected
        print_wrapped(f"closed form: {expected:.7g} deg, {apart:+.2g} deg apart")
    print_record(record)


@options("Friction and size")
class GrainOptions:
    """A grain with friction, or of another size than the spheres of the row."""

    friction: float | None = None
    """Coulomb's friction coefficient of the grain on the row."""
    grain_diameter: float | None = None
    """Diameter of the grain, m. [default: that of the row]"""
    shape: Literal["sphere", "disc"] | None = None
    """`sphere`, or `disc` in two dimensions: the moment of inertia of a grain that rolls.
    [default: sphere]"""
    diameter: float | None = None
    """Diameter of the row's spheres, m. [default: 1]"""


def theory(
    *,
    shock: float | None = None,
    restitution: float | None = None,
    impulse_ratio: float | None = None,
    reading: Reading | None = None,
    grain: GrainOptions = GrainOptions(),
    json: Json = False,
) -> int:
    """Critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock));
    10.2078 deg without rebound. With --restitution two readings of the source make the shock of
    one collision: one_shock_kept_deg, one_shock_lost_deg. event_driven_deg is the angle of rigid
    spheres by events, every rebound followed, up to a restitution of 0.7.

    With --friction or --grain-diameter, `model` says whether the angle is a closed form: without
    friction, and from rolling_friction on. Between them arcs and shocks of a rigid grain are
    integrated under Coulomb's limit. A grain so small that it leaves the row is refused.

    For example:

        dem-harness theory --restitution 0.5
        dem-harness theory --friction 0.5 --shape disc
        dem-harness theory --grain-diameter 2
        dem-harness theory --shock 0.1 --json

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
    """
    from harness.workflows import theory as closed_forms

    record = closed_forms(
        shock=shock,
        restitution=restitution,
        impulse_ratio=impulse_ratio,
        reading=reading,
        friction=grain.friction,
        grain_diameter=grain.grain_diameter,
        shape=grain.shape,
        diameter=grain.diameter,
    ).to_json()
    (print_json if json else print_record)(record)
    return 0
