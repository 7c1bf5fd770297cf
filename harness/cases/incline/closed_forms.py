"""The closed forms of the incline from shock, restitution or impulse ratio, and of a contact."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from harness.cases.incline.friction_theory import FrictionTheory, friction_theory
from harness.errors import RequestError
from harness.parameters.law import Contact
from harness.shown import Result
from harness.solvers.hard_sphere import MOST_RESTITUTION
from harness.solvers.hard_sphere import critical_angle as of_rigid_spheres
from harness.theory.chain import (
    SHOCK_WITHOUT_REBOUND,
    Reading,
    shock_from_impulse_ratio,
    shock_from_restitution,
)
from harness.theory.contact import restitution_clipped, restitution_in_steps, restitution_unclipped
from harness.theory.incline import (
    STATIC_ANGLE_DEG,
    critical_angle,
    gain_per_crest,
    no_flight_bound,
    steady_energy,
    well_depth,
)
from harness.theory.incline_friction import Shape

if TYPE_CHECKING:
    from harness.shown.figure import Figure

READINGS: tuple[Reading, ...] = ("kept", "lost")

ONE_SHOCK = 0.2
"""Restitution up to which the rebounds within a well hardly move the critical angle."""

PASSAGES = 0.4
"""Restitution up to which a passage is measured, where the hops in the well have died out."""


NO_PASSAGE = f"none: above e = {MOST_RESTITUTION:g} the grain flies over the crest"

ONE_SHOCK_CAVEAT = (
    "critical_angle_deg takes one collision for the many rebounds in a well: rigid spheres, "
    "event_driven_deg, differ from both readings at every restitution above 0"
)


@dataclass(frozen=True, repr=False)
class Theory(Result):
    """What the closed forms say; angles in degrees, energies in m g d at the critical angle.

    Of a restitution, ``one_shock_kept_deg`` and ``one_shock_lost_deg`` are both readings of the
    source, and ``event_driven_deg`` is the angle of rigid spheres whose every rebound is followed,
    None above a restitution of 0.7, where the grain flies over the crest. The closed form with the
    reading that was chosen is ``critical_angle_deg``.
    """

    critical_angle_deg: float
    shock: float
    reading: str | None
    static_angle_deg: float
    no_flight_bound_deg: float | None
    well_depth: float
    gain_per_crest: float
    steady_energy: float | None
    restitution: float | None = None
    one_shock_kept_deg: float | None = None
    one_shock_lost_deg: float | None = None
    event_driven_deg: float | None = None
    caveat: str | None = None

    def summary(self) -> dict[str, str]:
        """Return the angle and its shock; of a restitution rigid spheres and both readings."""
        reading = f", reading: {self.reading}" if self.reading else ""
        if self.restitution is not None:
            events = self.event_driven_deg
            return {
                "rigid spheres, every rebound": f"{events:.7g} deg (event-driven)"
                if events is not None
                else NO_PASSAGE,
                "one shock, energy kept": f"{self.one_shock_kept_deg:.7g} deg (closed form)",
                "one shock, velocity lost": f"{self.one_shock_lost_deg:.7g} deg (closed form)",
                "shock": f"{self.shock:.7g} of the energy is left{reading}",
                "case": f"incline, e = {self.restitution:g}",
            }
        return {
            "critical angle": f"{self.critical_angle_deg:.7g} deg",
            "shock": f"{self.shock:.7g} of the energy is left{reading}",
            "static angle": f"{self.static_angle_deg:.7g} deg",
            "case": "incline, closed form",
        }

    def draw(self) -> Figure:
        """Draw the critical angle against the shock, this one marked."""
        import numpy as np

        from harness.shown.figure import Figure, label

        figure = Figure(figsize=(6.4, 3.9), layout="constrained")
        axes = figure.add_subplot()
        shocks = np.linspace(0.0, max(1.0, self.shock), 101)
        axes.plot(shocks, [critical_angle(float(shock)) for shock in shocks])
        axes.plot(self.shock, self.critical_angle_deg, "o")
        label(axes, "shock: energy after over energy before", "critical angle (deg)")
        return figure


def theory(
    *,
    shock: float | None = None,
    restitution: float | None = None,
    impulse_ratio: float | None = None,
    reading: Reading | None = None,
    friction: float | None = None,
    grain_diameter: float | None = None,
    shape: Shape | None = None,
    diameter: float | None = None,
) -> Theory | FrictionTheory:
    """Return the closed forms of the incline [deg]; at shock 1/4 (no rebound) without arguments.

    At most one of the three may be given. ``reading`` says how a restitution or
    an impulse ratio makes a shock: ``kept`` (energy after over before; default
    for a restitution) or ``lost`` (from the velocity lost, as the source prints
    it; default for an impulse ratio). Beside a restitution stand both readings, and the
    event-driven angle of rigid spheres, which follows every rebound.

    ``friction`` (mu) of a ``shape``, and a ``grain_diameter`` on a row of a ``diameter`` [m], both
    1 m unless given, go without those, and return a FrictionTheory. Raise RequestError for more
    than one, for a reading or shape without use, for values out of range, and for a grain so
    small that it leaves the row.
    """
    options = {"shock": shock, "restitution": restitution, "impulse-ratio": impulse_ratio}
    names = [name for name, value in options.items() if value is not None]
    if len(names) > 1:
        raise RequestError(f"--{' and --'.join(names)}: give one of them only")
    if reading is not None and (not names or names == ["shock"]):
        raise RequestError(
            f"--reading {reading!r}: only with --restitution or --impulse-ratio, which it reads"
        )
    sizes = {"grain-diameter": grain_diameter, "shape": shape, "diameter": diameter}
    used = [name for name, value in {"friction": friction, **sizes}.items() if value is not None]
    if used and names:
        raise RequestError(f"--{used[0]} and --{names[0]}: give one of them only")
    if shape is not None and friction is None:
        raise RequestError(f"--shape {shape!r}: only with --friction, without it nothing rolls")
    if diameter is not None and grain_diameter is None:
        raise RequestError(f"--diameter {diameter!r}: only with --grain-diameter")
    if used:
        row = 1.0 if diameter is None else diameter
        return friction_theory(friction or 0.0, grain_diameter, shape or "sphere", row)
    if restitution is not None:
        reading = reading or "kept"
        shock = shock_from_restitution(restitution, reading)
        return replace(_at(shock, reading), **_of_rebounds(restitution))
    if impulse_ratio is not None:
        reading = reading or "lost"
        shock = shock_from_impulse_ratio(impulse_ratio, reading)
    elif shock is None:
        shock = SHOCK_WITHOUT_REBOUND
    return _at(shock, reading)


def _of_rebounds(e: float) -> dict[str, Any]:
    """Return the other reading of a restitution, and the angle of rigid spheres."""
    return {
        "restitution": e,
        **{
            f"one_shock_{reading}_deg": critical_angle(shock_from_restitution(e, reading))
            for reading in READINGS
        },
        "event_driven_deg": of_rigid_spheres(e) if e <= MOST_RESTITUTION else None,
        "caveat": ONE_SHOCK_CAVEAT if e else None,
    }


def _at(shock: float, reading: Reading | None) -> Theory:
    angle = critical_angle(shock)
    grows = shock >= 1.0
    return Theory(
        critical_angle_deg=angle,
        shock=shock,
        reading=reading,
        static_angle_deg=STATIC_ANGLE_DEG,
        no_flight_bound_deg=None if grows else no_flight_bound(shock),
        well_depth=well_depth(angle),
        gain_per_crest=gain_per_crest(angle),
        steady_energy=None if grows else steady_energy(angle, shock),
    )


def rebound(contact: Contact) -> float:
    """Return the restitution of the grain on a fixed sphere, with its own effective mass."""
    law = restitution_clipped if contact.tail == "clipped" else restitution_unclipped
    return law(contact.zeta_against_full_mass)


def rebound_in_steps(contact: Contact, steps: float) -> float:
    """Return the greatest restitution on a fixed sphere at so many steps per contact time."""
    zeta, clipped = contact.zeta_against_full_mass, contact.tail == "clipped"
    return restitution_in_steps(zeta, steps, clipped=clipped)


def closed_forms(contact: Contact) -> dict[Reading, float]:
    """Return the critical angle [deg] at the contact's restitution in both readings."""
    e = rebound(contact)
    return {reading: critical_angle(shock_from_restitution(e, reading)) for reading in READINGS}


def angles_beside(contact: Contact) -> dict[str, float | str]:
    """Return the angles that an angle measured with a contact is compared with, by JSON key.

    The angle of rigid spheres without rebound [deg]; where the contact rebounds more than that
    theory allows, both readings of one shock [deg], and what they leave out.
    """
    if rebound(contact) <= ONE_SHOCK:
        return {"closed_form_deg": critical_angle()}
    angles: dict[str, float | str] = {
        f"closed_form_{reading}_deg": angle for reading, angle in closed_forms(contact).items()
    }
    return {**angles, "theory": theory_in_words(contact)}


def theory_in_words(contact: Contact) -> str:
    """Return one sentence on what the theory gives for a contact."""
    kept, lost = closed_forms(contact).values()
    return (
        f"at e = {rebound(contact):.3g} the theory of one shock gives {kept:.4g} deg (energy kept) "
        f"or {lost:.4g} deg (velocity lost), and neither describes the many rebounds within "
        "a well: see `dem-harness theory --restitution` and the report's section on the contacts"
    )
