"""A run over the row: energies, start and end, scene and job, and its outcome.

A run is judged by its *margin*: the mechanical energy, without spin, above that of a grain at rest
on the crest ahead. Contacts only take energy: a grain that moves back with a negative margin is
trapped. LAMMPS's script judges in its own language; the stages of other engines are judged here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from typing import Any, NamedTuple, get_args

import numpy as np

from harness.cases.base import COLUMNS
from harness.cases.incline.system import START_BEHIND_CREST, Floats, Incline, OverRow, Route
from harness.engines.base import Job, Output, Template, Value
from harness.engines.output import STAGES
from harness.errors import EngineOutputError
from harness.model.base import COUNT, Allowed, allowed_in
from harness.model.law import CLIPPED, PLASTIC, SOURCE, Contact
from harness.model.scene import LOOK, Body, Scene, Stage

SPEED_AFTER_SHOCK = 0.35  # [sqrt(g a)] near the critical angle of equal spheres
SETTLING_TIMES = 8.0  # of the contact's slowest rate, until it has settled after a shock
START_SPEED = 0.48  # [sqrt(g d)] of steady motion
PASSAGE, TO_CREST, WELL = 2.1, 8.0, 4.5  # [sqrt(d/g)] of a passage, one to the crest, each well
MOST_SCENE_SPHERES = 9  # a longer periodic row is the same system
SEVEN_DIGITS = 1e-6  # of the place after a well [d], and of the energy there [m g d]


# ---- rest and energies


class Loaded(NamedTuple):
    """A row under a grain: overlap with it [m]; sinking of the sphere [m], energy [J] added."""

    overlap: float
    sunk: float
    energy: float


def loaded(case: OverRow, force: float, beta: float) -> Loaded:
    """Return the row under a ``force`` [N] of the grain at ``beta`` [rad] to the row's normal."""
    load = force * math.cos(beta)
    overlap, sunk = added_overlaps(case, force, load)
    energy = 0.5 * (force * overlap + load * sunk)
    return Loaded(float(case.rest_overlaps(force, load)[0]), sunk, energy)


def added_overlaps(case: OverRow, force: float, load: float) -> tuple[float, float]:
    """Return what a force and a load [N] add to the overlap with the grain, and to those below."""
    added = case.rest_overlaps(force, load) - case.rest_overlaps(0.0, 0.0)
    return float(added[0]), float(np.sum(added[1:]))


def own_sinking(case: OverRow) -> float:
    """Return how deep the row sinks under its own weight [m]."""
    return float(np.sum(case.rest_overlaps(0.0, 0.0)[1:]))


def crest_radius(case: OverRow) -> float:
    """Return the distance [m] of a grain at rest on a crest from the sphere below it."""
    return case.arm - loaded(case, case.weight, case.tilt).overlap


def crest_energy(case: OverRow, *, springs: bool) -> float:
    """Return the energy [J] of a grain at rest on the first crest: its height, and springs."""
    crest = loaded(case, case.weight, case.tilt)
    sunk = own_sinking(case) + crest.sunk
    height = case.arm - crest.overlap - sunk * math.cos(case.tilt)
    return case.weight * height + (crest.energy if springs else 0.0)


def overlaps(case: OverRow, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the overlaps [m] with the spheres behind and ahead at rest; negative is a gap."""
    behind, height = case.diameter * np.floor(x / case.diameter), y + own_sinking(case)
    return tuple(case.arm - np.hypot(x - at, height) for at in (behind, behind + case.diameter))


def margin(case: OverRow, well: Any, state: Sequence[Any]) -> Any:
    """Return the energy [m g d] above that of a grain at rest on the crest after ``well`` wells.

    ``well`` and ``state``, x, y [m], vx, vy [m/s], are numbers or arrays of one shape.
    """
    x, y, vx, vy = state
    height = y * math.cos(case.tilt) - x * math.sin(case.tilt)
    total = 0.5 * case.mass * (vx * vx + vy * vy) + case.weight * height
    if case.counts_springs:
        behind, ahead = (np.maximum(overlap, 0.0) for overlap in overlaps(case, x, y))
        total = total + 0.5 * case.stiffness * (behind**2 + ahead**2)
    fall = case.weight * well * case.diameter * math.sin(case.tilt)
    return (total - crest_energy(case, springs=case.counts_springs) + fall) / case.weight_energy


def allowed_margin(case: OverRow) -> float:
    """Return the margin [J] up to which a grain that moves back is trapped, 0 on a fixed row.

    On a row that gives way the grain's own energy is not highest at the crest: the sinking changes
    there as the load turns, by (compliance m g) sin(theta) per radian, which adds
    m g (s' cos(theta))^2 / 2 d. Four times this is allowed.
    """
    _, give = added_overlaps(case, 0.0, case.weight)
    turn = give * math.sin(case.tilt) * math.cos(case.tilt)
    return 2.0 * case.weight / case.diameter * turn**2


# ---- where a run starts and ends


def start_of(case: OverRow, route: Route) -> tuple[float, float, float, float, float]:
    """Return x, y [m], vx, vy [m/s] and the spin along z [rad/s] at the start of a route."""
    if route == "passage":
        return _start_behind_crest(case)
    # in a well, along the tangent of the sphere ahead
    height = math.sqrt(case.arm**2 - 0.25 * case.diameter**2)
    speed = START_SPEED * math.sqrt(case.gravity * case.diameter)
    vx, vy = speed * height / case.arm, speed * 0.5 * case.diameter / case.arm
    return 0.5 * case.diameter, height - own_sinking(case), vx, vy, _spin(case, speed)


def start_load(case: OverRow) -> tuple[float, float]:
    """Return the force [N] on the first sphere where a passage starts, and its angle phi [rad].

    A grain with friction rolls, v^2 = 2 g a (1 - cos(phi)) / (1 + beta); without, beta = 0. The
    force is m g ((3 + beta) cos(phi) - 2) / (1 + beta).
    """
    beta, behind = case.rolling_inertia, math.radians(case.start_degrees)
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(behind)) / case.arm / (1.0 + beta))
    phi = behind + case.phase * rate * case.step
    return case.weight * ((3.0 + beta) * math.cos(phi) - 2.0) / (1.0 + beta), phi


def _start_behind_crest(case: OverRow) -> tuple[float, float, float, float, float]:
    """Start with the energy of the crest, contact and row in balance; the row starts at rest."""
    inertia, (force, phi) = case.rolling_inertia, start_load(case)
    beta, weight = phi - case.tilt, case.weight
    sine, cosine = math.sin(beta), math.cos(beta)
    start, crest = loaded(case, force, beta), loaded(case, weight, case.tilt)
    r = case.arm - start.overlap
    change = -(3.0 + inertia) * weight * math.sin(phi) / (1.0 + inertia)  # of the force, with phi
    slope = -added_overlaps(case, change, change * cosine - force * sine)[0]  # of r
    kinetic = weight * (case.arm - crest.overlap - r * math.cos(phi)) + crest.energy - start.energy
    kinetic += weight * (start.sunk - crest.sunk) * math.cos(case.tilt)
    omega = math.sqrt(2.0 * kinetic / case.mass / ((1.0 + inertia) * r * r + slope * slope))
    return (
        r * sine,
        r * cosine - own_sinking(case) - start.sunk,
        omega * (r * cosine + slope * sine),
        omega * (slope * cosine - r * sine),
        _spin(case, omega * r),
    )


def _spin(case: OverRow, speed: float) -> float:
    return -2.0 * speed / case.grain if case.rolling_inertia else 0.0


def end_of(case: OverRow, route: Route, well: Any) -> Any:
    """Return the x [m] that ends a well: the crest, or before it where a passage has settled."""
    before = settled_before(case) if route == "passage" else 0.0
    return well * case.diameter - crest_radius(case) * math.sin(case.tilt + before)


def settled_before(case: OverRow) -> float:
    """Return how far before the crest [rad] a contact has settled after a shock, 10 deg at most.

    From there on the energy is conserved, and the slow way to the crest is not run. The slowest
    rate is that of x'' + 2 zeta omega x' + omega^2 x = 0.
    """
    if case.ends_on_crest:
        return 0.0
    zeta, omega = case.contact.zeta_against_full_mass, math.sqrt(case.stiffness / case.mass)
    slowest = zeta + math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else 1.0 / (zeta + 1e-9)
    speed = SPEED_AFTER_SHOCK * math.sqrt(case.gravity / case.arm) * case.half_angle * 6.0 / math.pi
    swept = SETTLING_TIMES * slowest / omega * speed
    return min(max(case.half_angle - case.tilt - swept, 0.0), math.radians(START_BEHIND_CREST))


# ---- scenes and jobs


def scene_of(case: Incline, route: Route, every: int | None = None) -> Scene:
    """Return a run as a scene, whose first body is the grain, with a stage for each well.

    Without ``every`` the start is the only sample: the ends of stages are enough to judge a run.
    """
    x, y, vx, vy, spin = start_of(case, route)
    grain = _body(case, case.grain).replace(position=(x, y, 0.0), velocity=(vx, vy, 0.0),
                                            angular_velocity=(0.0, 0.0, spin))  # fmt: skip
    fixed = "frozen" if case.contact.effective_mass == "full" else "held"
    spheres = min(case.spheres, MOST_SCENE_SPHERES)
    row = _row(_body(case, case.diameter).replace(motion=fixed), spheres)
    return scene_over(case, route, every, spheres, bodies=(grain, *row), law=case.law)


def _body(case: Incline, diameter: float) -> Body:
    mass = case.density * math.pi / 6.0 * diameter**3
    inertia = case.inertia * mass * (0.5 * diameter) ** 2 if case.shape == "disc" else None
    return Body(radius=0.5 * diameter, mass=mass, inertia=inertia)


@lru_cache(maxsize=64)
def _row(sphere: Body, count: int) -> tuple[Body, ...]:
    """Return touching spheres along x: the same objects for all cases of a search."""
    places = 2.0 * sphere.radius * np.arange(count)
    return tuple(sphere.replace(position=(float(x), 0.0, 0.0)) for x in places)


def scene_over(case: OverRow, route: Route, every: int | None, spheres: int, **parts: Any) -> Scene:
    """Return the scene of a run over a row of so many spheres, with bodies and laws as given."""
    g, steps = case.gravity, math.ceil(case.time_limit * case.unit_of_time / case.step)
    wells = 1 if route == "passage" else case.wells
    fall = case.weight * case.diameter * math.sin(case.tilt)
    floor = crest_energy(case, springs=False) + allowed_margin(case)  # a Stage has no springs
    return Scene(
        **parts,
        gravity=(g * math.sin(case.tilt), -g * math.cos(case.tilt), 0.0),
        period=(spheres * case.diameter, None, None),
        step=case.step,
        steps=steps,
        every=every or steps,
        stages=tuple(
            Stage(place=end_of(case, route, well), floor=floor - well * fall)
            for well in range(1, wells + 1)
        ),
    )


def expected_steps(case: OverRow, route: Route) -> float:
    """Return how many steps a run takes near the critical angle."""
    passage = TO_CREST if case.ends_on_crest else PASSAGE
    longest = passage if route == "passage" else WELL * case.wells
    return min(longest, case.time_limit) * case.unit_of_time / case.step


def job_of(case: Incline, route: Route, every: int | None = None) -> Job:
    """Return the job of a run: in the script of its contact, a custom one in the main script.

    ``every`` is the number of steps between samples of the path, which are else not written.
    """
    variant = case.contact.name if case.contact.name in TEMPLATE.variants else TEMPLATE.main
    return Job(TEMPLATE, values_of(case, route, every), variant, sampled=every is not None,
               scene=scene_of(case, route, every), steps=expected_steps(case, route))  # fmt: skip


def values_of(case: Incline, route: Route, every: int | None = None) -> dict[str, Value]:
    """Return the values of a script for a run, sampled every so many steps."""
    stiffness, damping = case.tangential_ratios
    return {
        **row_values(case, route, every),
        "friction": case.friction,
        "shape": case.shape,
        "grain_diameter": case.grain_diameter or 0.0,
        "tangential_stiffness": stiffness,
        "tangential_damping": damping,
    }


def row_values(case: OverRow, route: Route, every: int | None) -> dict[str, Value]:
    """Return the values that scripts over any row have."""
    fields = [name for name in OverRow.model_fields if name != "contact"]
    sampled: dict[str, Value] = {} if every is None else {"series_every": every}
    return {
        "route": route,
        **{name: getattr(case, name) for name in fields},
        "start": case.start_degrees,
        **case.contact.script_values,
        **sampled,
    }


def allowed_values(kind: type[OverRow], values: Mapping[str, Value]) -> dict[str, Allowed]:
    """Return what the values of a script may be; the angle is changed the most, and comes first."""
    ranges = allowed_in(kind)
    return {
        **{name: ranges[name] for name in ("angle", *ranges) if name in values},
        "damping": Allowed(words=("restitution", "ratio")),
        **allowed_in(Contact),
        "route": Allowed(words=get_args(Route)),
        # at 10 sqrt(g d) the softest contact is pressed in by a diameter, v sqrt(m / k)
        "speed": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 10}, unit="sqrt(g d)"),
        "start": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 30}, unit="deg"),
        "series_every": COUNT,
    }


TEMPLATE = Template(
    name="incline",
    variants={
        contact.name: values_of(Incline(contact=contact, steps_per_contact=steps), "steady")
        for contact, steps in ((PLASTIC, 100.0), (SOURCE, 50.0), (CLIPPED, 50.0))
    },
    notes={
        "plastic": "overdamped and clipped: no tail, no rebound; the one to extrapolate.",
        "source": "e = 1e-20 with the attractive tail, as Harper, Dufek and Breard ran it.",
        "clipped": "critical damping, tail clipped; it rebounds with e = exp(-2) = 0.135.",
    },
    allowed={
        **allowed_values(Incline, values_of(Incline(), "steady")),
        "grain_diameter": Allowed(bounds={"minimum": 0}, unit="m"),  # 0: that of the row
    },
)


# ---- outcomes


class Fate(StrEnum):
    """The outcome of a run. Cut off by its time limit it is undecided, never trapped."""

    MOVES_ON = "moves_on"
    TRAPPED = "trapped"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Run:
    """One run, judged. Margins [m g d] are those at the end, and at each crest that was passed."""

    case: OverRow
    fate: Fate
    margin: float
    touching: bool
    time_s: float
    steps: int
    crest_margins: Floats
    output: Output = field(repr=False)


def read(case: OverRow, route: Route, output: Output) -> Run:
    """Return the run in an output: judged by its script, else by the ends of its stages.

    Raise EngineOutputError for an output that is incomplete or has other settings, EngineNaNError
    for values that are not finite.
    """
    if output.has("route") and output.text("route") != route:
        raise EngineOutputError(f"{output.engine} ran another route than {route!r}")
    output.check_numbers(
        {
            "angle_deg": case.angle,
            "mass_kg": case.mass,
            "stiffness_N_per_m": case.stiffness,
            "damping_coefficient_N_s_per_m": case.contact.dashpot(case.stiffness, case.mass),
            "gravity_m_per_s2": case.gravity,
            "step_s": case.step,
        }
    )
    return (_judged_by_script if output.results else _judged_by_stages)(case, route, output)


def _judged_by_script(case: OverRow, route: Route, output: Output) -> Run:
    crests, wells = output.rows("crest", 4), 1 if route == "passage" else case.wells
    try:
        fate = Fate(output.text("verdict"))
        touching = {"0": False, "1": True}[output.text("touching")]
    except (ValueError, KeyError) as error:
        raise EngineOutputError(f"{output.engine} left an incomplete result ({error})") from None
    if len(crests) > wells or (len(crests) == wells) != (fate is Fate.MOVES_ON):
        raise EngineOutputError(
            f"{output.engine} printed a grain that is {fate} after {len(crests)} crests of {wells}"
        )
    energy, time = output.number("margin_J"), output.number("time_s")
    steps, crest_margins = round(output.number("steps")), crests[:, 2] / case.weight_energy
    return Run(
        case, fate, energy / case.weight_energy, touching, time, steps, crest_margins, output
    )


def _judged_by_stages(case: OverRow, route: Route, output: Output) -> Run:
    """Judge the ends of stages, one in each well from the first on.

    With friction margins have 1 + beta times the energy of the velocity, as of a grain that rolls.
    One that slides over the crest has no other root, and its margin keeps its slope there. A grain
    is trapped by its energy of translation. The engine ends a stage by all digits, and may write
    fewer.
    """
    table, wells = output.table(COLUMNS, name=STAGES), 1 if route == "passage" else case.wells
    time, x, y, vx, vy = (table[name][1:] for name in COLUMNS)
    if not 1 <= x.size <= wells:
        raise EngineOutputError(f"{output.engine} left {x.size} ends of stages, of {wells} wells")
    well = np.arange(1, x.size + 1)
    sliding = margin(case, well, (x, y, vx, vy))
    rolling = 0.5 * case.rolling_inertia * case.mass * (vx**2 + vy**2) / case.weight_energy
    limit = case.time_limit * case.unit_of_time
    cut_off = time[-1] >= limit * (1.0 - 1e-9) - LOOK * case.step
    rounding = SEVEN_DIGITS * well
    rounding[-1] *= not cut_off
    margins, beyond = sliding + rolling, x > end_of(case, route, well) - rounding * case.diameter
    below = sliding[-1] < allowed_margin(case) / case.weight_energy + rounding[-1]
    fate = Fate.UNDECIDED
    if beyond[-1] and x.size == wells:
        fate = Fate.TRAPPED if route == "passage" and margins[-1] < 0.0 else Fate.MOVES_ON
    elif not beyond[-1] and vx[-1] < 0.0 and below:
        fate = Fate.TRAPPED
    if fate is Fate.UNDECIDED and not cut_off:
        raise EngineOutputError(
            f"{output.engine} left a run that ends at {time[-1]:g} s, undecided, before the time "
            f"limit of {limit:g} s"
        )
    touching = bool(max(*overlaps(case, x[-1], y[-1])) > 0.0)
    steps, last = round(time[-1] / case.step), float(margins[-1])
    return Run(case, fate, last, touching, float(time[-1]), steps, margins[beyond], output)
