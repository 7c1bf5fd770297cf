"""Angles that are expected of the incline: closed forms, rigid spheres by events, friction.

``theory`` is the public function. The other functions return what a measured angle is compared
with, and refuse contacts that a passage cannot measure.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NoReturn, get_args

import numpy as np
from scipy.optimize import brentq

from harness.cases.incline.runs import SPEED_AFTER_SHOCK, settled_before
from harness.cases.incline.system import Incline, OverRow
from harness.errors import RequestError
from harness.model.law import Contact
from harness.report.content import Summarized
from harness.theory import incline
from harness.theory.chain import (
    SHOCK_WITHOUT_REBOUND,
    Reading,
    shock_from_impulse_ratio,
    shock_from_restitution,
)
from harness.theory.contact import restitution_clipped, restitution_unclipped
from harness.theory.incline import FRICTIONLESS, Grain, Shape

if TYPE_CHECKING:
    import pandas as pd

ONE_SHOCK = 0.2  # restitution up to which rebounds within a well move the angle by < 0.05 deg
PASSAGES = 0.4  # restitution up to which a passage is measured, where hops end within the well
PLACES = 400  # within a step at which a contact is taken to begin
FINE_STEPS = 1000.0  # per contact time, above which a restitution is the closed form's to 0.2 %
LONGEST_CONTACT = 10.0  # [pi / omega] after which a grain that has not left creeps
NO_REBOUND = 1e-6  # restitution below which the angle of rigid spheres is the closed form to 1e-10
LARGEST_SIZE_RATIO = 100.0  # with a critical angle of 5.6e-5 deg
ONE_SHOCK_CAVEAT = (
    "critical_angle_deg takes one collision for the many rebounds in a well: rigid spheres, "
    "event_driven_deg up to a restitution of 0.7, differ from both readings above 0"
)


# ---- the public function and its results


class Theory(Summarized, SimpleNamespace):
    """A critical angle [deg] by theory, and what it rests on: attributes, JSON keys, a table.

    Of equal spheres without friction: shock, reading, bounds, energies in m g d at that angle. Of a
    restitution, ``one_shock_kept_deg`` and ``one_shock_lost_deg`` are readings of the source,
    ``event_driven_deg`` follows every rebound of rigid spheres; None above 0.7, where they fly.

    With friction or sizes: ``model`` is a closed form or an integration, energies are in m g (R +
    r). From ``sticking_friction`` on the shock of a rolling grain sticks, from ``rolling_friction``
    on it rolls all along. Smaller grains than ``smallest_grain_diameter_m`` leave the row.
    ``no_flight_bound_deg`` is None where steady motion is not reached within 180 wells.
    """

    def to_json(self) -> dict[str, Any]:
        """Return the values by name, JSON-ready."""
        return dict(vars(self))

    def to_frame(self) -> pd.DataFrame:
        """Return the values as a table of one row."""
        import pandas as pd

        return pd.DataFrame([vars(self)])

    def summary(self) -> dict[str, str]:
        """Return the angle, its model and its shock; of a restitution also rigid spheres."""
        texts = {"critical angle": f"{self.critical_angle_deg:.7g} deg"}
        if model := vars(self).get("model"):
            texts["model"] = model
        if events := vars(self).get("event_driven_deg"):
            texts["rigid spheres, every rebound"] = f"{events:.7g} deg"
        return {**texts, "shock": f"{self.shock:.7g} of the energy is left"}


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
) -> Theory:
    """Return the closed forms of the incline [deg], at shock 1/4 (no rebound) without arguments.

    ``reading`` is how a restitution or an impulse ratio makes a shock: ``kept`` (energy after over
    before, default of a restitution) or ``lost`` (by the velocity lost, as the source prints it,
    default of an impulse ratio). ``friction`` of a ``shape``, and a ``grain_diameter`` on a row of
    a ``diameter`` [m], 1 m unless given, are a grain that may roll. Raise RequestError for options
    that exclude one another, for values out of range, and for a grain that leaves the row.
    """
    shocks = {"shock": shock, "restitution": restitution, "impulse-ratio": impulse_ratio}
    grains = {"friction": friction, "grain-diameter": grain_diameter, "shape": shape,
              "diameter": diameter}  # fmt: skip
    names, used = ([n for n, v in group.items() if v is not None] for group in (shocks, grains))
    if len(names) > 1 or (used and names):
        pair = names[:2] if len(names) > 1 else [used[0], names[0]]
        raise RequestError(f"--{' and --'.join(pair)}: give one of them only")
    if reading is not None and names not in (["restitution"], ["impulse-ratio"]):
        raise RequestError(f"--reading {reading!r}: only with --restitution or --impulse-ratio")
    if shape is not None and friction is None:
        raise RequestError(f"--shape {shape!r}: only with --friction, without it nothing rolls")
    if diameter is not None and grain_diameter is None:
        raise RequestError(f"--diameter {diameter!r}: only with --grain-diameter")
    if used:
        row = 1.0 if diameter is None else diameter
        size = row if grain_diameter is None else grain_diameter
        return _of_grain(friction or 0.0, size, shape or "sphere", row)
    if restitution is not None:
        reading = reading or "kept"
        shock = shock_from_restitution(restitution, reading)
    elif impulse_ratio is not None:
        reading = reading or "lost"
        shock = shock_from_impulse_ratio(impulse_ratio, reading)
    return _of_shock(SHOCK_WITHOUT_REBOUND if shock is None else shock, reading, restitution)


def _of_shock(shock: float, reading: Reading | None, restitution: float | None) -> Theory:
    """Return the theory of equal spheres; of a restitution also with rigid spheres by events."""
    angle, grows, e = incline.critical_angle(shock), shock >= 1.0, restitution
    kept, lost = (None, None) if e is None else _readings(e)
    return Theory(
        critical_angle_deg=angle,
        shock=shock,
        reading=reading,
        static_angle_deg=incline.STATIC_ANGLE_DEG,
        no_flight_bound_deg=None if grows else incline.no_flight_bound(shock),
        well_depth=incline.well_depth(angle),
        gain_per_crest=incline.gain_per_crest(angle),
        steady_energy=None if grows else incline.steady_energy(angle, shock),
        restitution=e,
        one_shock_kept_deg=kept,
        one_shock_lost_deg=lost,
        event_driven_deg=None if e is None else _rigid_spheres(e),
        caveat=ONE_SHOCK_CAVEAT if e else None,
    )


def _readings(e: float) -> tuple[float, float]:
    kept, lost = (incline.critical_angle(shock_from_restitution(e, r)) for r in ("kept", "lost"))
    return kept, lost


def _rigid_spheres(e: float) -> float | None:
    """Return the angle of rigid spheres, every rebound followed, None where they fly."""
    from harness.solvers import hard_sphere  # compiled

    return hard_sphere.critical_angle(e) if e <= hard_sphere.MOST_RESTITUTION else None


def _of_grain(friction: float, grain_diameter: float, shape: Shape, diameter: float) -> Theory:
    """Return the theory of a grain with friction or of another size than the row's spheres."""
    most, sizes = LARGEST_SIZE_RATIO * diameter, "from 1e-30 to 1e30 m"
    conditions = (
        (0.0 <= friction <= 1e9, f"friction = {friction!r}", "from 0 to 1e9"),
        (shape in get_args(Shape), f"shape = {shape!r}", "'sphere' or 'disc'"),
        (1e-30 <= diameter <= 1e30, f"diameter = {diameter!r}", sizes),
        (1e-30 <= grain_diameter <= 1e30, f"grain-diameter = {grain_diameter!r}", sizes),
        (grain_diameter <= most, f"grain-diameter = {grain_diameter!r}",
         f"at most {most:g} m, 100 times that of the row"),
    )  # fmt: skip
    for holds, value, allowed in conditions:
        if not holds:
            raise RequestError(f"{value} is not allowed: must be {allowed}")
    half, grain = incline.well_half_angle(grain_diameter / diameter), Grain.of(friction, shape)
    smallest = diameter * incline.smallest_size_ratio(grain)
    try:
        rigid = incline.rigid_angle(half, grain)
    except incline.LeavesRow:
        raise RequestError(
            f"grain-diameter = {grain_diameter!r} is not allowed: must be at least "
            f"{math.ceil(1e6 * smallest / diameter) * 1e-6 * diameter:.7g} m at friction "
            f"{friction:g}, a smaller grain leaves the row below its critical angle"
        ) from None
    return Theory(
        critical_angle_deg=rigid.degrees,
        model=rigid.model,
        friction=friction,
        shape=shape,
        diameter_m=diameter,
        grain_diameter_m=grain_diameter,
        smallest_grain_diameter_m=smallest,
        sticking_friction=incline.sticking_friction(half, grain.inertia),
        rolling_friction=incline.rolling_friction(half, grain.inertia),
        shock=rigid.shock,
        static_angle_deg=half,
        no_flight_bound_deg=incline.no_flight_bound(rigid.shock, half)
        if rigid.model == FRICTIONLESS
        else incline.integrated_no_flight_bound(half, grain),
        well_depth=incline.well_depth(rigid.degrees, half),
        gain_per_crest=incline.gain_per_crest(rigid.degrees, half),
        steady_energy=rigid.energy,
    )


# ---- what is expected of a case


def rebound(contact: Contact) -> float:
    """Return the restitution [-] of a grain on a fixed sphere, with its own effective mass."""
    law = restitution_clipped if contact.clipped else restitution_unclipped
    return law(contact.zeta_against_full_mass)


def rigid_angle(case: Incline) -> tuple[float, str]:
    """Return the critical angle [deg] of rigid grains without rebound, and its model."""
    if case.is_plain:
        return incline.critical_angle(), FRICTIONLESS
    grain = Grain.of(case.friction, case.shape)
    return incline.rigid_angle(math.degrees(case.half_angle), grain)[:2]


def expected_angle(case: Incline) -> float | None:
    """Return the critical angle [deg] of rigid grains that rebound as a case, None if unknown."""
    e = rebound(case.contact)
    if e <= NO_REBOUND or (e <= ONE_SHOCK and not case.is_plain):
        return rigid_angle(case)[0]
    return _rigid_spheres(e) if case.is_plain else None


def angles_to_compare(case: Incline) -> dict[str, float | str]:
    """Return the angles that a measured angle is compared with, by JSON key.

    The angle without rebound [deg], by its model: closed form, or integration of a rigid grain with
    friction. Of a contact that rebounds, both readings of one shock [deg]; with friction or sizes
    only a text, as there is no theory of it.
    """
    if rebound(case.contact) <= ONE_SHOCK:
        angle, model = rigid_angle(case)
        return {"integrated_deg" if model == incline.INTEGRATED else "closed_form_deg": angle}
    text: dict[str, float | str] = {"theory": _one_shock_text(case)}
    if not case.is_plain:
        return text
    kept, lost = _readings(rebound(case.contact))
    return {"closed_form_kept_deg": kept, "closed_form_lost_deg": lost, **text}


def _one_shock_text(case: OverRow) -> str:
    if not case.is_plain:
        return "there is no theory of rebounds with friction, or of grains of another size"
    contact = case.contact
    kept, lost = _readings(rebound(contact))
    return (
        f"at e = {rebound(contact):.3g} the theory of one shock gives {kept:.4g} deg (energy kept) "
        f"or {lost:.4g} deg (velocity lost), and neither describes the many rebounds within "
        "a well: see `dem-harness theory --restitution` and the report's section on the contacts"
    )


# ---- contacts that a passage cannot measure


def check_passage(case: OverRow) -> None:
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


def refuse_passage(case: OverRow, reason: str) -> NoReturn:
    """Raise RequestError for a contact that a passage cannot measure."""
    raise RequestError(
        "method=passage needs a contact that ends the rebounds within one well, "
        f"{reason}: use method=steady; {_one_shock_text(case)}"
    )


def most_restitution(case: OverRow) -> float:
    """Return the restitution up to which a passage of a contact of this stiffness is measured.

    The hops of rigid spheres end a contact time before the passage is judged: those of a spring end
    up to half a contact time later or earlier (in the reference at k d / m g of 1e4 to 1e6).
    """
    from harness.solvers import hard_sphere

    settled = settled_before(case.replace(angle=incline.critical_angle()))
    judged = settled + SPEED_AFTER_SHOCK * case.contact_time / case.unit_of_time
    judged = math.degrees(judged)
    if hard_sphere.hops_end(PASSAGES) >= judged:
        return PASSAGES
    return float(brentq(lambda e: hard_sphere.hops_end(e) - judged, 0.0, PASSAGES, xtol=1e-4))


def restitution_in_steps(zeta: float, steps: float, *, clipped: bool) -> float:
    """Return the greatest restitution that the contact has at so many steps per pi / omega.

    v+ = v + h a(x, v), x+ = x + h v+, the recurrence of velocity Verlet in the velocities of half
    steps and of semi-implicit Euler. A step sees the contact only where there is overlap, so the
    restitution depends on where within a step the contact begins: this is the greatest over
    ``PLACES`` places, and not less than that of the closed form.
    """
    exact = (restitution_clipped if clipped else restitution_unclipped)(zeta)
    if steps > FINE_STEPS:
        return exact
    h = math.pi / steps
    x = h * (np.arange(PLACES) + 0.5) / PLACES  # the overlap in the first step that sees it
    v = np.ones(PLACES)
    for _ in range(math.ceil(LONGEST_CONTACT * steps)):
        force = x + 2.0 * zeta * v
        # one that has left flies on, with its overlap negative
        v -= np.where(x > 0.0, h * (np.maximum(force, 0.0) if clipped else force), 0.0)
        x += h * v
        if not np.any(x > 0.0):
            break
    return max(exact, float(-v[x <= 0.0].min(initial=0.0)))
