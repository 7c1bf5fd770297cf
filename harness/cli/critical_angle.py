"""``dem-harness critical-angle``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.cached_engines import Cache, Chosen, Fresh
from harness.cli.options import (
    ContactName,
    EngineName,
    Esys,
    Integrator,
    Json,
    Kratos,
    Liggghts,
    Lmp,
    Method,
    Mfix,
    Mpirun,
    Yade,
    programs_of,
)

if TYPE_CHECKING:
    from harness.cases.incline.parameters import Incline
    from harness.engines.contract import Engine
    from harness.parameters.contact import Contact

_CONTACT = "Contact"
_SYSTEM = "System"


def critical_angle(
    method: Annotated[
        Method,
        typer.Option(
            help="`passage`: root of the energy margin over one well. `steady`: the smallest "
            "angle that keeps moving, the source's definition."
        ),
    ] = Method.PASSAGE,
    extrapolate: Annotated[
        bool,
        typer.Option(
            "--extrapolate",
            help="Take the step to zero, then the stiffness to infinity (passage route; plastic "
            "contact unless told otherwise). The ladder spans a factor of 10 about --stiffness.",
        ),
    ] = False,
    tolerance: Annotated[
        float | None,
        typer.Option(help="Resolution of the search, deg.  [default: 0.001 passage, 0.005 steady]"),
    ] = None,
    stiffness: Annotated[
        float, typer.Option(help="Normal stiffness k, N/m.", rich_help_panel=_CONTACT)
    ] = 1e6,
    steps_per_contact: Annotated[
        float | None,
        typer.Option(
            help="Steps per contact time pi sqrt(m/k).  [default: 50]", rich_help_panel=_CONTACT
        ),
    ] = None,
    contact: Annotated[
        ContactName | None,
        typer.Option(
            help="`source`: e = 1e-20, tail kept. `clipped`: critical damping, tail clipped. "
            "`plastic`: damping ratio 5, clipped.  [default: source]",
            rich_help_panel=_CONTACT,
        ),
    ] = None,
    restitution: Annotated[
        float | None,
        typer.Option(
            help="Nominal restitution, 0 to 1; 0 is critical damping.", rich_help_panel=_CONTACT
        ),
    ] = None,
    damping_ratio: Annotated[
        float | None,
        typer.Option(
            help="Damping ratio zeta; overrides --restitution. Plastic contact is 5, clipped.",
            rich_help_panel=_CONTACT,
        ),
    ] = None,
    clip: Annotated[
        bool | None,
        typer.Option(
            "--clip/--no-clip",
            help="Clip the attractive tail of a parting contact, or keep it.",
            rich_help_panel=_CONTACT,
        ),
    ] = None,
    half_mass: Annotated[
        bool,
        typer.Option(
            "--half-mass",
            help="Effective mass m/2 against a fixed sphere, as in MFiX, instead of m.",
            rich_help_panel=_CONTACT,
        ),
    ] = False,
    diameter: Annotated[
        float, typer.Option(help="Diameter of all spheres, m.", rich_help_panel=_SYSTEM)
    ] = 1.0,
    density: Annotated[
        float | None,
        typer.Option(
            help="Density of the grain, kg/m3.  [default: 6/pi, 1 kg at 1 m]",
            rich_help_panel=_SYSTEM,
        ),
    ] = None,
    gravity: Annotated[float, typer.Option(help="Gravity, m/s2.", rich_help_panel=_SYSTEM)] = 9.81,
    engine: EngineName = "lammps",
    integrator: Integrator = None,
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    liggghts: Liggghts = None,
    yade: Yade = None,
    kratos: Kratos = None,
    esys: Esys = None,
    mfix: Mfix = None,
    cache: Cache = None,
    fresh: Fresh = False,
    json: Json = False,
) -> None:
    """Critical angle of the frictionless incline, measured in an engine.

    Without options: the source's contact (e = 1e-20, attractive tail kept),
    k = 1e6 N/m, 50 steps per contact time, passage route. A single value agrees
    with 10.2078 deg by cancellation at best: --extrapolate is what proves it.
    """
    from harness.cases.incline.parameters import UNIT_MASS_DENSITY, Incline
    from harness.cli.cached_engines import open_cached_engine, open_entries, runs_made
    from harness.cli.history_records import angle_quantities
    from harness.cli.output import print_json, print_record
    from harness.cli.recording import recorded
    from harness.errors import RequestError

    if tolerance is not None and not 1e-9 <= tolerance <= 1.0:
        raise RequestError(f"--tolerance {tolerance!r} is not allowed: must be from 1e-9 to 1 deg")
    if extrapolate and (steps_per_contact is not None or method is Method.STEADY):
        option = "--method steady" if method is Method.STEADY else "--steps-per-contact"
        raise RequestError(f"{option} cannot go with --extrapolate, which runs a ladder of steps")
    default = ContactName.PLASTIC if extrapolate else ContactName.SOURCE
    case = Incline(
        stiffness=stiffness,
        steps_per_contact=50.0 if steps_per_contact is None else steps_per_contact,
        contact=_contact(contact, default, restitution, damping_ratio, clip, half_mass),
        diameter=diameter,
        density=UNIT_MASS_DENSITY if density is None else density,
        gravity=gravity,
    )
    entries = open_entries(cache)
    programs = programs_of(
        [engine], liggghts=liggghts, yade=yade, kratos=kratos, esys=esys, mfix=mfix
    )
    chosen = Chosen(engine, lmp, mpirun, integrator, programs)
    with recorded("critical-angle") as told, open_cached_engine(chosen, entries, fresh) as opened:
        found = _measure(case, opened, method, tolerance, extrapolate)
        record = {"closed_form_deg": _closed_form(), **found, **runs_made(opened)}
        told.engine, told.quantities = record, angle_quantities(record)
    if json:
        print_json(record)
    else:
        print_record(record)


def _measure(
    case: Incline, engine: Engine, method: Method, tolerance: float | None, extrapolate: bool
) -> dict[str, Any]:
    from harness.cases.incline import critical_angles as verb
    from harness.cli.progress import progress_bars

    if not extrapolate:
        return verb.critical_angle(
            case, method=method.value, tolerance_deg=tolerance, engine=engine
        ).record()
    with progress_bars() as progress:
        return verb.extrapolated_critical_angle(case, engine=engine, progress=progress).record()


def _contact(
    named: ContactName | None,
    default: ContactName,
    restitution: float | None,
    damping_ratio: float | None,
    clip: bool | None,
    half_mass: bool,
) -> Contact:
    """Return the named contact with what the other options change in it.

    A restitution or damping ratio without a name starts from the source's rules.
    """
    from harness.parameters.contact import CONTACTS, Contact

    own_damping = restitution is not None or damping_ratio is not None
    if named is None and own_damping:
        default = ContactName.SOURCE
    base = CONTACTS[(named or default).value]
    changes: dict[str, Any] = {}
    if own_damping:
        changes |= {"restitution": restitution, "damping_ratio": damping_ratio}
    if clip is not None:
        changes["tail"] = "clipped" if clip else "attractive"
    if half_mass:
        changes["effective_mass"] = "half"
    changed = {key: value for key, value in changes.items() if getattr(base, key) != value}
    if not changed:
        return base
    custom = Contact(**{**dict(base), **changed, "name": "custom"})
    return next((c for c in CONTACTS.values() if c.replace(name="custom") == custom), custom)


def _closed_form() -> float:
    from harness.theory.critical_angle import critical_angle as closed_form

    return closed_form()
