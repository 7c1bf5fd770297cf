"""``dem-harness critical-angle``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.engine_options import EngineOptions
from harness.cli.options import ContactName, Json, Method

if TYPE_CHECKING:
    from harness.cases.incline.parameters import Incline
    from harness.engines.contract import Engine
    from harness.parameters.contact import Contact

_CONTACT = "Contact"
_SYSTEM = "System"


@dataclass(frozen=True)
class RouteOptions:
    """How the angle is found."""

    method: Annotated[
        Method,
        typer.Option(
            help="`passage`: root of the energy margin over one well. `steady`: the smallest "
            "angle that keeps moving, the source's definition."
        ),
    ] = Method.PASSAGE
    extrapolate: Annotated[
        bool,
        typer.Option(
            "--extrapolate",
            help="Take the step to zero, then the stiffness to infinity (passage route; plastic "
            "contact unless told otherwise). The ladder spans a factor of 10 about --stiffness.",
        ),
    ] = False
    tolerance: Annotated[
        float | None,
        typer.Option(help="Resolution of the search, deg.  [default: 0.001 passage, 0.005 steady]"),
    ] = None
    wells: Annotated[
        int | None,
        typer.Option(
            help="Wells to pass in steady motion.  [default: 10, below 20 steps per contact 100]"
        ),
    ] = None

    def check(self, system: SystemOptions) -> None:
        """Raise RequestError for a tolerance out of range and options that exclude one another."""
        from harness.errors import RequestError

        if self.tolerance is not None and not 1e-9 <= self.tolerance <= 1.0:
            raise RequestError(
                f"--tolerance {self.tolerance!r} is not allowed: must be from 1e-9 to 1 deg"
            )
        steady = self.method is Method.STEADY
        if self.wells is not None and not steady:
            raise RequestError(f"--wells {self.wells}: goes with --method steady only")
        given = {
            "--method steady": steady or None,
            "--steps-per-contact": system.steps_per_contact,
            "--engine-step": system.engine_step,
        }
        for option, value in given.items():
            if self.extrapolate and value is not None:
                text = f"{option} cannot go with --extrapolate, which runs a ladder of steps"
                raise RequestError(text)


@dataclass(frozen=True)
class SystemOptions:
    """Stiffness, step and system."""

    stiffness: Annotated[
        float, typer.Option(help="Normal stiffness k, N/m.", rich_help_panel=_CONTACT)
    ] = 1e6
    steps_per_contact: Annotated[
        float | None,
        typer.Option(
            help="Steps per contact time pi sqrt(m/k).  [default: 50]", rich_help_panel=_CONTACT
        ),
    ] = None
    engine_step: Annotated[
        float | None,
        typer.Option(
            metavar="NUMBER",
            help="The step as the engine counts it, in place of --steps-per-contact: of MFiX "
            "its DTSOLID_FACTOR.",
            rich_help_panel=_CONTACT,
        ),
    ] = None
    diameter: Annotated[
        float, typer.Option(help="Diameter of all spheres, m.", rich_help_panel=_SYSTEM)
    ] = 1.0
    density: Annotated[
        float | None,
        typer.Option(
            help="Density of the grain, kg/m3.  [default: 6/pi, 1 kg at 1 m]",
            rich_help_panel=_SYSTEM,
        ),
    ] = None
    gravity: Annotated[float, typer.Option(help="Gravity, m/s2.", rich_help_panel=_SYSTEM)] = 9.81

    def steps(self, engine: str, contact: Contact) -> float | None:
        """Return the steps per contact that are asked for, in either way; None where none are."""
        from harness.engines.registry import engine_class
        from harness.errors import RequestError

        if self.engine_step is None:
            return self.steps_per_contact
        if self.steps_per_contact is not None:
            raise RequestError("--engine-step and --steps-per-contact: must be one of the two")
        return engine_class(engine).steps_of(self.engine_step, contact)


@dataclass(frozen=True)
class ContactOptions:
    """The contact: a named one, and what is changed in it."""

    contact: Annotated[
        ContactName | None,
        typer.Option(
            help="`source`: e = 1e-20, tail kept. `clipped`: critical damping, tail clipped. "
            "`plastic`: damping ratio 5, clipped.  [default: source]",
            rich_help_panel=_CONTACT,
        ),
    ] = None
    restitution: Annotated[
        float | None,
        typer.Option(
            help="Nominal restitution, 0 to 1; 0 is critical damping.", rich_help_panel=_CONTACT
        ),
    ] = None
    damping_ratio: Annotated[
        float | None,
        typer.Option(
            help="Damping ratio zeta; overrides --restitution. Plastic contact is 5, clipped.",
            rich_help_panel=_CONTACT,
        ),
    ] = None
    clip: Annotated[
        bool | None,
        typer.Option(
            "--clip/--no-clip",
            help="Clip the attractive tail of a parting contact, or keep it.",
            rich_help_panel=_CONTACT,
        ),
    ] = None
    half_mass: Annotated[
        bool,
        typer.Option(
            "--half-mass",
            help="Effective mass m/2 against a fixed sphere, as in MFiX, instead of m.",
            rich_help_panel=_CONTACT,
        ),
    ] = False

    def contact_or(self, default: ContactName) -> Contact:
        """Return the named contact with what the other options change in it.

        A restitution or damping ratio without a name starts from the source's rules.
        """
        from harness.parameters.contact import CONTACTS, Contact

        own_damping = self.restitution is not None or self.damping_ratio is not None
        if self.contact is None and own_damping:
            default = ContactName.SOURCE
        base = CONTACTS[(self.contact or default).value]
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
    route: RouteOptions,
    contact: ContactOptions,
    system: SystemOptions,
    engine: EngineOptions,
    json: Json = False,
) -> None:
    """Critical angle of the frictionless incline, measured in an engine.

    Without options: the source's contact (e = 1e-20, attractive tail kept),
    k = 1e6 N/m, 50 steps per contact time, passage route. A single value agrees
    with 10.2078 deg by cancellation at best: --extrapolate is what proves it.
    """
    from harness.cli.engine_options import runs_made
    from harness.cli.history_records import angle_quantities
    from harness.cli.output import print_json, print_record
    from harness.cli.qualified import end_unqualified, qualification
    from harness.cli.recording import recorded
    from harness.theory.critical_angle import critical_angle as closed_form

    default = ContactName.PLASTIC if route.extrapolate else ContactName.SOURCE
    touching = contact.contact_or(default)
    route.check(system)
    case = _case(system, touching, system.steps(engine.engine, touching))
    with recorded("critical-angle") as told, engine.run() as opened:
        found = _measure(case, opened, route)
        found |= qualification(opened, told)
        record = {"closed_form_deg": closed_form(), **found, **runs_made(opened)}
        told.engine, told.quantities = record, angle_quantities(record)
    if json:
        print_json(record)
    else:
        print_record(record)
    end_unqualified(record, engine.engine)


def _case(system: SystemOptions, contact: Contact, steps: float | None) -> Incline:
    from harness.cases.incline.parameters import Incline
    from harness.parameters.material import UNIT_MASS_DENSITY

    return Incline(
        stiffness=system.stiffness,
        steps_per_contact=50.0 if steps is None else steps,
        contact=contact,
        diameter=system.diameter,
        density=UNIT_MASS_DENSITY if system.density is None else system.density,
        gravity=system.gravity,
    )


def _measure(case: Incline, engine: Engine, route: RouteOptions) -> dict[str, Any]:
    from harness.cases.incline import critical_angles as verb
    from harness.cli.progress import progress_bars

    if not route.extrapolate:
        return verb.critical_angle(
            case,
            method=route.method.value,
            tolerance_deg=route.tolerance,
            wells=route.wells,
            engine=engine,
        ).record()
    with progress_bars() as progress:
        return verb.extrapolated_critical_angle(case, engine=engine, progress=progress).record()
