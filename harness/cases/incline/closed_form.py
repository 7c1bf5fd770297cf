"""Angles that are expected of the incline: closed forms, rigid spheres by events, friction.

``theory`` is the public function. The other functions give what a measured angle is held against,
and refuse contacts that a passage cannot measure.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, NoReturn

from scipy.optimize import brentq

from harness.cases.incline.system import SPEED_AFTER_SHOCK, Incline, settled_before
from harness.errors import RequestError
from harness.model.contact import Contact
from harness.report.notebook import Shown
from harness.theory import incline, incline_friction
from harness.theory.chain import (
    SHOCK_WITHOUT_REBOUND,
    Reading,
    shock_from_impulse_ratio,
    shock_from_restitution,
)
from harness.theory.contact import restitution_clipped, restitution_in_steps, restitution_unclipped
from harness.theory.incline_coulomb import (
    LARGEST_FRICTION,
    Grain,
    LeavesRow,
    integrated_critical_angle,
    integrated_no_flight_bound,
    kept_energy,
    largest_half_angle,
    smallest_size_ratio,
)
from harness.theory.incline_friction import INERTIA, Shape, kept_speed

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.style import Figure

ONE_SHOCK = 0.2  # restitution up to which rebounds within a well hardly move the angle
PASSAGES = 0.4  # restitution up to which a passage is measured, where hops end within the well
NO_REBOUND = 1e-6  # restitution below which the angle of rigid spheres is the closed form to 1e-10
FRICTIONLESS = "closed form, no friction"
ROLLING = "closed form, rolls without slip"
INTEGRATED = "integrated: rigid grain, Coulomb friction in shock and on arcs"
HIGHEST_FRICTION = 1e9
LARGEST_SIZE_RATIO = 100.0  # with a critical angle of 5.6e-5 deg
ONE_SHOCK_CAVEAT = (
    "critical_angle_deg takes one collision for the many rebounds in a well: rigid spheres, "
    "event_driven_deg, differ from both readings at every restitution above 0"
)


# ---- the public function and its results


class _Record(Shown):
    """A result whose JSON and table have its fields."""

    def to_json(self) -> dict[str, Any]:
        """Return the fields, JSON-ready."""
        return asdict(self)  # type: ignore[call-overload, no-any-return]

    def to_frame(self) -> pd.DataFrame:
        """Return the fields as a table of one row."""
        import pandas as pd

        return pd.DataFrame([self.to_json()])


@dataclass(frozen=True, repr=False)
class Theory(_Record):
    """Closed forms of equal spheres without friction [deg]; energies in m g d at that angle.

    Of a restitution, ``one_shock_kept_deg`` and ``one_shock_lost_deg`` are both readings of the
    source. ``event_driven_deg`` is the angle of rigid spheres whose every rebound is followed, None
    above a restitution of 0.7, where the grain flies over the crest.
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
        """Return the angle and its shock; of a restitution also rigid spheres and readings."""
        events, reading = (
            self.event_driven_deg,
            f", reading: {self.reading}" if self.reading else "",
        )
        rigid = {} if self.restitution is None else {
            "rigid spheres, every rebound": "none: the grain flies over the crest"
            if events is None else f"{events:.7g} deg (event-driven)",
            "one shock, energy kept": f"{self.one_shock_kept_deg:.7g} deg",
            "one shock, velocity lost": f"{self.one_shock_lost_deg:.7g} deg",
        }  # fmt: skip
        return {
            "critical angle": f"{self.critical_angle_deg:.7g} deg",
            **rigid,
            "shock": f"{self.shock:.7g} of the energy is left{reading}",
        }

    def draw(self) -> Figure:
        """Draw the critical angle over the shock, this one marked."""
        shocks = [0.01 * n * max(1.0, self.shock) for n in range(101)]
        angles = [incline.critical_angle(shock) for shock in shocks]
        x = "shock: energy after over energy before"
        return _curve(shocks, angles, (self.shock, self.critical_angle_deg), x)


@dataclass(frozen=True, repr=False)
class FrictionTheory(_Record):
    """Critical angle of a grain of any size with friction; angles in degrees.

    ``model`` tells a closed form from an integration. Energies are kinetic ones at the critical
    angle in m g (R + r), ``shock`` is energy after over energy before. From ``sticking_friction``
    on the shock of a rolling grain sticks, from ``rolling_friction`` on it rolls all along. Smaller
    grains than ``smallest_grain_diameter_m`` leave the row. ``no_flight_bound_deg`` is None where
    steady motion is not found within 180 wells.
    """

    critical_angle_deg: float
    model: str
    friction: float
    shape: Shape
    diameter_m: float
    grain_diameter_m: float
    smallest_grain_diameter_m: float
    sticking_friction: float
    rolling_friction: float
    shock: float
    static_angle_deg: float
    no_flight_bound_deg: float | None
    well_depth: float
    gain_per_crest: float
    steady_energy: float

    def summary(self) -> dict[str, str]:
        """Return the angle, its model and its bounds."""
        return {
            "critical angle": f"{self.critical_angle_deg:.7g} deg ({self.model})",
            "shock": f"{self.shock:.7g} of the energy is left",
            "friction that sticks": f"{self.sticking_friction:.7g} in the shock, "
            f"{self.rolling_friction:.7g} all along",
            "smallest grain": f"{self.smallest_grain_diameter_m:.7g} m",
            "case": f"{self.shape} of {self.grain_diameter_m:g} m on {self.diameter_m:g} m, "
            f"friction {self.friction:g}",
        }

    def draw(self) -> Figure:
        """Draw the critical angle over friction, this one marked."""
        most = 1.3 * max(self.friction, min(1.0, self.sticking_friction * 2.0))
        frictions = [0.0125 * n * most for n in range(81)]
        angles = [angle_or_nan(mu, self.shape, self.static_angle_deg) for mu in frictions]
        mark = (self.friction, self.critical_angle_deg)
        return _curve(frictions, angles, mark, "friction coefficient")


def _curve(x: list[float], y: list[float], mark: tuple[float, float], label: str) -> Figure:
    from harness.report import style

    figure = style.panels(1, 1)
    (axes,) = figure.axes
    axes.plot(x, y, color=style.BLUE)
    axes.plot(*mark, "o", color=style.RED)
    style.label(axes, label, style.axis("critical angle", "deg"))
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
    """Return the closed forms of the incline [deg], at shock 1/4 (no rebound) without arguments.

    ``reading`` is how a restitution or an impulse ratio makes a shock: ``kept`` (energy after over
    before, default of a restitution) or ``lost`` (by the velocity lost, as the source prints it,
    default of an impulse ratio). ``friction`` of a ``shape``, and a ``grain_diameter`` on a row of
    a ``diameter`` [m], 1 m unless given, return a FrictionTheory. Raise RequestError for options
    that exclude one another, for values out of range, and for a grain that leaves the row.
    """
    options = {"shock": shock, "restitution": restitution, "impulse-ratio": impulse_ratio}
    names = [name for name, value in options.items() if value is not None]
    sizes = {"grain-diameter": grain_diameter, "shape": shape, "diameter": diameter}
    used = [name for name, value in {"friction": friction, **sizes}.items() if value is not None]
    if len(names) > 1:
        raise RequestError(f"--{' and --'.join(names)}: give one of them only")
    if reading is not None and (not names or names == ["shock"]):
        raise RequestError(
            f"--reading {reading!r}: only with --restitution or --impulse-ratio, which it reads"
        )
    if used and names:
        raise RequestError(f"--{used[0]} and --{names[0]}: give one of them only")
    if shape is not None and friction is None:
        raise RequestError(f"--shape {shape!r}: only with --friction, without it nothing rolls")
    if diameter is not None and grain_diameter is None:
        raise RequestError(f"--diameter {diameter!r}: only with --grain-diameter")
    if used:
        row = 1.0 if diameter is None else diameter
        size = row if grain_diameter is None else grain_diameter
        return friction_theory(friction or 0.0, size, shape or "sphere", row)
    return _frictionless(shock, restitution, impulse_ratio, reading)


def _frictionless(
    shock: float | None,
    restitution: float | None,
    impulse_ratio: float | None,
    reading: Reading | None,
) -> Theory:
    rebounds: dict[str, Any] = {}
    if restitution is not None:
        from harness.solvers import hard_sphere  # compiled

        reading = reading or "kept"
        shock = shock_from_restitution(restitution, reading)
        flies = restitution > hard_sphere.MOST_RESTITUTION
        kept, lost = (incline.critical_angle(shock_from_restitution(restitution, r))
                      for r in ("kept", "lost"))  # fmt: skip
        rebounds = {
            "restitution": restitution,
            "one_shock_kept_deg": kept,
            "one_shock_lost_deg": lost,
            "event_driven_deg": None if flies else hard_sphere.critical_angle(restitution),
            "caveat": ONE_SHOCK_CAVEAT if restitution else None,
        }
    elif impulse_ratio is not None:
        reading = reading or "lost"
        shock = shock_from_impulse_ratio(impulse_ratio, reading)
    shock = SHOCK_WITHOUT_REBOUND if shock is None else shock
    angle, grows = incline.critical_angle(shock), shock >= 1.0
    return Theory(
        critical_angle_deg=angle,
        shock=shock,
        reading=reading,
        static_angle_deg=incline.STATIC_ANGLE_DEG,
        no_flight_bound_deg=None if grows else incline.no_flight_bound(shock),
        well_depth=incline.well_depth(angle),
        gain_per_crest=incline.gain_per_crest(angle),
        steady_energy=None if grows else incline.steady_energy(angle, shock),
        **rebounds,
    )


# ---- friction and size


def friction_theory(
    friction: float, grain_diameter: float, shape: Shape, diameter: float = 1.0
) -> FrictionTheory:
    """Return the critical angle with friction mu, of a grain and a row of these diameters [m].

    Raise RequestError for values out of range, and for a grain so small that it leaves the row,
    with the bound.
    """
    _check(friction, grain_diameter, shape, diameter)
    half, beta = incline_friction.well_half_angle(grain_diameter / diameter), INERTIA[shape]
    grain = _grain(friction, beta)
    smallest = diameter * smallest_size_ratio(grain)
    try:
        angle, model = angle_with_friction(friction, shape, half)
    except LeavesRow:
        raise RequestError(
            f"grain-diameter = {grain_diameter!r} is not allowed: must be at least "
            f"{math.ceil(1e6 * smallest / diameter) * 1e-6 * diameter:.7g} m at friction "
            f"{friction:g}, a smaller grain leaves the row below its critical angle"
        ) from None
    tilt, phi = math.radians(angle), math.radians(half)
    depth, gain = 1.0 - math.cos(phi - tilt), 2.0 * math.sin(phi) * math.sin(tilt)
    before, after, shock = depth + gain, depth, kept_speed(half, beta * (model == ROLLING)) ** 2
    if model == INTEGRATED:
        before, after = kept_energy(angle, half, grain)
        shock = after / before
    flight = (
        incline_friction.no_flight_bound(half, 0.0)
        if model == FRICTIONLESS
        else integrated_no_flight_bound(half, grain)
    )
    return FrictionTheory(
        critical_angle_deg=angle,
        model=model,
        friction=friction,
        shape=shape,
        diameter_m=diameter,
        grain_diameter_m=grain_diameter,
        smallest_grain_diameter_m=smallest,
        sticking_friction=incline_friction.sticking_friction(half, beta),
        rolling_friction=incline_friction.rolling_friction(half, beta),
        shock=shock,
        static_angle_deg=half,
        no_flight_bound_deg=flight,
        well_depth=depth,
        gain_per_crest=gain,
        steady_energy=after,
    )


def angle_with_friction(friction: float, shape: Shape, half_angle_deg: float) -> tuple[float, str]:
    """Return the critical angle [deg] of rigid grains without rebound, and its model.

    Raise LeavesRow for a grain that leaves the row at a smaller tilt.
    """
    beta = INERTIA[shape]
    if friction == 0.0:
        if half_angle_deg > largest_half_angle(Grain(0.0, beta)):
            raise LeavesRow("the grain leaves the row below its critical angle")
        return incline_friction.critical_angle(half_angle_deg, 0.0), FRICTIONLESS
    if friction >= incline_friction.rolling_friction(half_angle_deg, beta):
        return incline_friction.critical_angle(half_angle_deg, beta), ROLLING
    return integrated_critical_angle(half_angle_deg, _grain(friction, beta)), INTEGRATED


def angle_or_nan(friction: float, shape: Shape, half_angle_deg: float) -> float:
    """Return :func:`angle_with_friction` [deg], NaN for a grain that leaves the row."""
    try:
        return angle_with_friction(friction, shape, half_angle_deg)[0]
    except LeavesRow:
        return math.nan


def _grain(friction: float, inertia: float) -> Grain:
    return Grain(min(friction, LARGEST_FRICTION), inertia)


def _check(friction: float, grain_diameter: float, shape: str, diameter: float) -> None:
    if not 0.0 <= friction <= HIGHEST_FRICTION:
        raise RequestError(f"friction = {friction!r} is not allowed: must be from 0 to 1e9")
    if shape not in INERTIA:
        raise RequestError(f"shape = {shape!r} is not allowed: must be 'sphere' or 'disc'")
    for name, value in (("diameter", diameter), ("grain-diameter", grain_diameter)):
        if not 1e-30 <= value <= 1e30:
            raise RequestError(f"{name} = {value!r} is not allowed: must be from 1e-30 to 1e30 m")
    if grain_diameter > LARGEST_SIZE_RATIO * diameter:
        raise RequestError(
            f"grain-diameter = {grain_diameter!r} is not allowed: must be at most "
            f"{LARGEST_SIZE_RATIO * diameter:g} m, 100 times that of the row"
        )


# ---- what a case is held against


def rebound(contact: Contact) -> float:
    """Return the restitution [-] of a grain on a fixed sphere, with its own effective mass."""
    law = restitution_clipped if contact.clipped else restitution_unclipped
    return law(contact.zeta_against_full_mass)


def rigid_angle(case: Incline) -> tuple[float, str]:
    """Return the critical angle [deg] of rigid grains without rebound, and its model."""
    if case.is_plain:
        return incline.critical_angle(), FRICTIONLESS
    return angle_with_friction(case.friction, case.shape, math.degrees(case.half_angle))


def shocks_slide(case: Incline) -> bool:
    """Return whether the friction of a case is too small for the shock of a rolling grain."""
    half = math.degrees(case.half_angle)
    return 0.0 < case.friction < incline_friction.sticking_friction(half, case.inertia)


def expected_angle(case: Incline) -> float | None:
    """Return the critical angle [deg] of rigid grains with the rebound of a case, if known."""
    e = rebound(case.contact)
    if e <= NO_REBOUND or (e <= ONE_SHOCK and not case.is_plain):
        return rigid_angle(case)[0]
    from harness.solvers import hard_sphere

    known = case.is_plain and e <= hard_sphere.MOST_RESTITUTION
    return hard_sphere.critical_angle(e) if known else None


def angles_beside(contact: Contact) -> dict[str, float | str]:
    """Return the angles that a measured angle is compared with, by JSON key.

    The angle without rebound [deg]; of a contact that rebounds, both readings of one shock [deg].
    """
    if rebound(contact) <= ONE_SHOCK:
        return {"closed_form_deg": incline.critical_angle()}
    kept, lost = _readings(contact)
    return {
        "closed_form_kept_deg": kept,
        "closed_form_lost_deg": lost,
        "theory": one_shock_text(contact),
    }


def _readings(contact: Contact) -> tuple[float, float]:
    e = rebound(contact)
    kept, lost = (incline.critical_angle(shock_from_restitution(e, r)) for r in ("kept", "lost"))
    return kept, lost


def one_shock_text(contact: Contact) -> str:
    """Return a sentence on both readings of one shock for a contact."""
    kept, lost = _readings(contact)
    return (
        f"at e = {rebound(contact):.3g} the theory of one shock gives {kept:.4g} deg (energy kept) "
        f"or {lost:.4g} deg (velocity lost), and neither describes the many rebounds within "
        "a well: see `dem-harness theory --restitution` and the report's section on the contacts"
    )


def check_passage(case: Incline) -> None:
    """Raise RequestError for a contact whose rebounds go on where a passage is judged.

    The restitution that decides is that of the contact in the steps of the case.
    """
    e, steps = rebound(case.contact), case.steps_per_contact
    if e <= ONE_SHOCK:
        return
    zeta, clipped = case.contact.zeta_against_full_mass, case.contact.clipped
    in_steps = restitution_in_steps(zeta, steps, clipped=clipped)
    if in_steps > (most := most_restitution(case)):
        up_to = f", up to {in_steps:.3g} at {steps:g} steps per contact" if e <= most else ""
        refuse_passage(
            case,
            f"one of restitution {most:.3g} at most at stiffness {case.stiffness:g} (here {e:.3g}"
            f"{up_to})",
        )


def refuse_passage(case: Incline, reason: str) -> NoReturn:
    """Raise RequestError for a contact that a passage cannot measure."""
    raise RequestError(
        "method = 'passage' needs a contact that ends the rebounds within one well, "
        f"{reason}: use method 'steady'; {one_shock_text(case.contact)}"
    )


def most_restitution(case: Incline) -> float:
    """Return the restitution up to which a passage of a contact of this stiffness is measured.

    The hops of rigid spheres end a contact time before the passage is judged: those of a spring end
    up to half a contact time later or earlier (in the reference at k d / m g of 1e4 to 1e6).
    """
    from harness.solvers import hard_sphere

    upright = case.replace(angle=incline.critical_angle())
    contact_way = SPEED_AFTER_SHOCK * case.contact_time * math.sqrt(case.gravity / case.diameter)
    judged = math.degrees(settled_before(upright) + contact_way)
    if hard_sphere.hops_end(PASSAGES) >= judged:
        return PASSAGES
    return float(brentq(lambda e: hard_sphere.hops_end(e) - judged, 0.0, PASSAGES, xtol=1e-4))
