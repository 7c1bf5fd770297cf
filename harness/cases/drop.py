"""A grain dropped on one fixed sphere of its size: every engine qualifies by it.

Each drop shows one fault: a dashpot that is missing or takes another effective mass (restitution),
a contact that is found late (onset), a wrong spring (rest), a wrong clock (free fall), a force
along the tangent (oblique contact). Every path is compared with the reference at equal steps, and
with its closed form.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import NamedTuple, get_args

import numpy as np
from pydantic import Field, model_validator

from harness.cases.base import COLUMNS, Case, Check, EqualSpheres, Quantity, path_in
from harness.cases.bench import Bench
from harness.cases.checks import ROUND_OFF
from harness.engines.base import Engine, Job, Output, Template, Value
from harness.errors import EngineOutputError
from harness.model.base import COUNT, Allowed, allowed_in
from harness.model.law import PLASTIC, SOURCE, Contact, EffectiveMass, NamedContact, Tail
from harness.model.scene import Body, Floats, Scene
from harness.results.rows import Kind, Tolerance
from harness.theory import contact as impact

EPSILON = sys.float_info.epsilon
LEAST_OVERLAP = 1e6 * EPSILON  # [d] so that rounding is a millionth of it at most
MOST_DECADES = 290.0  # between 1 and a mass [kg], and that and a stiffness: floats have 308
RESTED = 1e-6  # part of its motion that a grain at rest keeps at most
SPEED = 1.0  # [m/s] of the collisions, on spheres of 1 m and 1 kg
GAPS = 117.5  # steps before they begin: no number at which a sparse search might happen to look
FEWEST_DIGITS = 6  # with which 7e-4 of a speed is seen, the change in the first step of a contact
HEAD_ON = Contact(name="head-on", restitution=0.5)
IN_SCRIPTS = ("stiffness", "steps_per_contact", "gravity", "diameter", "density", "gap", "speed",
              "sideways")  # fmt: skip


class Drop(EqualSpheres):
    """One run of a grain above a fixed sphere of its size, in SI units.

    The sphere's centre is the origin, the grain starts at (0, diameter + gap) and moves down with
    ``speed`` and along x with ``sideways``; gravity points down.
    """

    # fmt: off
    contact: NamedContact = Field(SOURCE, description="[-] dissipation of the contact")
    steps_per_contact: float = Field(
        2000.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)")
    gravity: float = Field(0.0, ge=0.0, description="[m/s2] acceleration of gravity, downward")
    gap: float = Field(0.0, gt=-0.25, le=10.0, description="[m] from the sphere; negative: pressed")
    speed: float = Field(0.0, description="[m/s] downward, at the start")
    sideways: float = Field(0.0, description="[m/s] along x, at the start")
    duration: float = Field(
        3.0, gt=0.0, le=1e4, description="[-] of the run, in contact times pi sqrt(m/k)")
    every: int = Field(1, ge=1, description="[-] steps between two samples of the path")
    # fmt: on

    @model_validator(mode="after")
    def _is_sound(self) -> Drop:
        mass = 3.0 * math.log10(self.diameter) + math.log10(self.density)
        if max(abs(mass), abs(mass - math.log10(self.stiffness))) > MOST_DECADES:
            raise ValueError(
                f"diameter = {self.diameter:g} m, density = {self.density:g} kg/m3, stiffness = "
                f"{self.stiffness:g} N/m: mass or contact time is beyond floating point"
            )
        if not self.gap > -0.25 * self.diameter:
            raise ValueError(
                f"gap = {self.gap!r} m: must be greater than {-0.25 * self.diameter:.4g} m, a "
                "quarter of the diameter"
            )
        overlap = self.largest_overlap
        if overlap and not LEAST_OVERLAP <= overlap / self.diameter <= 0.5:
            raise ValueError(
                f"the grain would press itself {overlap / self.diameter:.3g} diameters in at "
                f"stiffness = {self.stiffness:g} N/m, diameter = {self.diameter:g} m, speed = "
                f"{math.hypot(self.speed, self.sideways):g} m/s, gravity = {self.gravity:g} m/s2: "
                f"must be from {LEAST_OVERLAP:.2g} to 0.5"
            )
        self._check_end()
        return self

    def _check_end(self) -> None:
        if self.zeta < 1.0 or self.contact.clipped or self.gravity:
            return
        text, ratio = "contact.restitution = 0: must be greater than 0", self.contact.damping_ratio
        if ratio is not None:
            text = f"contact.damping_ratio = {ratio:g}: must be below {ratio / self.zeta:.4g}"
        raise ValueError(f"{text}, or contact.tail = clipped: the contact never ends")

    @property
    def steps(self) -> int:
        """Return the number of steps, a multiple of ``every`` that covers the duration."""
        samples = self.duration * self.steps_per_contact / self.every
        return self.every * max(1, math.ceil(samples - 1e-9))

    @property
    def seconds(self) -> float:
        """Return the time simulated [s]."""
        return self.steps * self.step

    @property
    def zeta(self) -> float:
        """Return the damping ratio of the grain on the fixed sphere."""
        return self.contact.zeta_against_full_mass

    @property
    def rest_overlap(self) -> float:
        """Return m g / k [m]."""
        return self.mass * self.gravity / self.stiffness

    @property
    def largest_overlap(self) -> float:
        """Return an upper bound of the overlap [m]: of a linear spring, undamped, head-on."""
        fall = math.sqrt(2.0 * self.gravity * max(self.gap, 0.0))
        speed = math.hypot(self.speed, self.sideways, fall)
        weight = self.rest_overlap
        return weight + math.hypot(weight, speed * math.sqrt(self.mass / self.stiffness))

    @property
    def largest_speed(self) -> float:
        """Return the size of speeds [m/s]: of the start, and of a fall to the end or the sphere."""
        falls = min(self.seconds, math.sqrt(2.0 * max(self.gap, 0.0) / (self.gravity or 1.0)))
        swings = 0.0 if self.gap > 0.0 else math.sqrt(self.mass / self.stiffness)
        return math.hypot(self.speed, self.sideways) + self.gravity * max(falls, swings)

    @property
    def fallen(self) -> float:
        """Return how far the grain falls in the run without contact [m]."""
        return self.speed * self.seconds + 0.5 * self.gravity * self.seconds**2


# ---- scripts and scenes


def values_of(case: Drop) -> dict[str, Value]:
    """Return a script's values for a drop."""
    values: dict[str, Value] = {name: getattr(case, name) for name in IN_SCRIPTS}
    values |= {"steps": case.steps, "series_every": case.every}
    return {**values, **case.contact.script_values}


def scene_of(case: Drop) -> Scene:
    """Return the grain, body 0, and the fixed sphere."""
    size = {"radius": 0.5 * case.diameter, "mass": case.mass}
    place, velocity = (0.0, case.diameter + case.gap, 0.0), (case.sideways, -case.speed, 0.0)
    fixed = "frozen" if case.contact.effective_mass == "full" else "held"
    return Scene(
        bodies=(Body(**size, position=place, velocity=velocity), Body(**size, motion=fixed)),
        law=case.contact.law(case.stiffness), gravity=(0.0, -case.gravity, 0.0),
        step=case.step, steps=case.steps, every=case.every,
    )  # fmt: skip


class Path(NamedTuple):
    """The grain's path, (M,) each: time [s], place [m] and velocity [m/s]."""

    time: Floats
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats

    @property
    def momentum_ratio(self) -> float:
        """Return the angular momentum about the sphere's centre, end over start; NaN for none."""
        momentum = self.x * self.vy - self.y * self.vx
        return float(momentum[-1] / momentum[0]) if momentum[0] else math.nan


def read_path(case: Drop, output: Output) -> Path:
    """Return every sample of the grain; raise EngineOutputError for what is missing or cut."""
    output.check_numbers({"step_s": case.step, "steps": case.steps})
    table = path_in(output, case.steps // case.every + 1)
    return Path(*(table[name] for name in COLUMNS))


# ---- closed forms


def restitution(case: Drop) -> float:
    """Return the restitution of a head-on collision with the linear spring [-]."""
    law = impact.restitution_clipped if case.contact.clipped else impact.restitution_unclipped
    return law(case.zeta)


def _impact_duration(case: Drop) -> float:
    """Return how long the force of an impact lasts, over sqrt(m/k); from critical on for ever."""
    if case.contact.clipped:
        return impact.duration_clipped(case.zeta)
    return impact.duration_unclipped(case.zeta) if case.zeta < 1.0 else math.inf


# ---- the case


def _falling(contact: Contact) -> Drop:
    """Return a free fall that ends before the sphere."""
    case = Drop(contact=contact, gravity=9.81, gap=0.05, every=100)
    return case.replace(duration=0.9 * math.sqrt(2.0 * case.gap / 9.81) / case.contact_time)


class DropCase(Case[Drop]):
    """A grain dropped on one fixed sphere: restitution, rest, free fall, oblique contact."""

    name = "drop"
    group = "contacts"
    summary = "a grain dropped on one fixed sphere; every engine qualifies by it"
    parameters = Drop
    quantities = (
        Quantity("restitution", "1", "speed of departure over that of approach"),
        Quantity("largest_sampled_overlap_m", "m", "largest overlap of the samples, or - gap",
                 lambda case: case.largest_overlap or max(case.gap, 0.0)),
        Quantity("end_overlap_m", "m", "overlap at the end; negative is a gap",
                 lambda case: max(case.largest_overlap, case.gap - case.fallen)),
        Quantity("end_speed_m_per_s", "m/s", "speed at the end", lambda case: case.largest_speed),
        Quantity("angular_momentum_ratio", "1", "about the sphere's centre, end over start"),
    )  # fmt: skip
    presets = {  # noqa: RUF012 - as the base declares it
        "head-on": Drop(contact=HEAD_ON, gap=1e-3, speed=1.0),
        "plastic": Drop(contact=PLASTIC, gap=1e-3, speed=1.0, duration=25.0, every=10),
        "static": Drop(contact=HEAD_ON, stiffness=1e4, gravity=9.81, duration=40.0, every=100),
        "fall": _falling(HEAD_ON),
        "oblique": Drop(contact=HEAD_ON, sideways=1.0, gap=-1e-4, every=100),
    }

    def job(self, parameters: Drop) -> Job:
        """Return the job of one drop, which samples the path."""
        return Job(TEMPLATE, values_of(parameters), sampled=True, scene=scene_of(parameters))

    def measure(self, parameters: Drop, output: Output) -> Mapping[str, float]:
        """Return the quantities of a path.

        The restitution is that of a head-on collision that is over.
        """
        path = read_path(parameters, output)
        overlap = parameters.diameter - np.hypot(path.x, path.y)
        values = {
            "largest_sampled_overlap_m": float(overlap.max()),
            "end_overlap_m": float(overlap[-1]),
            "end_speed_m_per_s": float(np.hypot(path.vx[-1], path.vy[-1])),
        }
        head_on = parameters.speed > 0.0 and parameters.gravity == 0.0
        if parameters.sideways != 0.0:
            values["angular_momentum_ratio"] = path.momentum_ratio
        elif head_on and bool(overlap.max() > 0.0 >= overlap[-1]):
            values["restitution"] = float(path.vy[-1]) / parameters.speed
        return values

    def exact(self, parameters: Drop) -> Mapping[str, float]:
        """Return the quantities with a closed form, none where nothing is known."""
        p, unit = parameters, math.sqrt(parameters.mass / parameters.stiffness)  # [s]
        if p.sideways != 0.0:
            return {"angular_momentum_ratio": 1.0} if p.gravity == 0.0 else {}
        if p.gravity > 0.0 and p.gap > 0.0:
            speed = p.speed + p.gravity * p.seconds
            end = {"end_overlap_m": p.fallen - p.gap, "end_speed_m_per_s": speed}
            return end if p.fallen < p.gap else {}
        if p.gravity > 0.0:
            slowest = p.zeta - math.sqrt(max(p.zeta**2 - 1.0, 0.0))
            part = math.exp(-slowest * p.seconds / unit)
            return {"end_overlap_m": p.rest_overlap} if part <= RESTED else {}
        values: dict[str, float] = {}
        if p.speed > 0.0:
            remaining = (p.seconds - max(p.gap, 0.0) / p.speed) / unit
            # the motion turns at half the time at which the clipped force vanishes
            if remaining >= 0.5 * impact.duration_clipped(p.zeta):
                overlap = p.speed * impact.largest_overlap(p.zeta) * unit
                values["largest_sampled_overlap_m"] = overlap
            if remaining >= _impact_duration(p):
                values["restitution"] = restitution(p)
                values["end_speed_m_per_s"] = restitution(p) * p.speed
        return values

    def checks(self, engine: Engine) -> Iterator[Check]:
        """Return the checks of an engine: of each drop its closed form, and the path."""
        digits = engine.traits.digits
        able = (c for c in contacts() if not engine.refuses(self.job(_flying(c))))
        seen = set[Drop]()
        for trial in (*map(collision, contacts()), *trials(next(able, SOURCE), digits)):
            yield _closed_form_check(trial)
            if trial.case not in seen:  # two quantities of one path
                yield _path_check(trial, digits)
            seen.add(trial.case)


CASE = DropCase()
TEMPLATE = Template(
    "drop", {"": values_of(CASE.default)},
    allowed={**allowed_in(Drop), "damping": Allowed(words=("restitution", "ratio")),
             **allowed_in(Contact), "steps": COUNT, "series_every": COUNT},
)  # fmt: skip


# ---- the checks


class Trial(NamedTuple):
    """A drop, and a quantity of its path that has a closed form."""

    setup: str
    case: Drop
    quantity: str
    measure: Callable[[Path], float]
    expected: float
    tolerance: Tolerance
    unit: str = "1"


def contacts() -> list[Contact]:
    """Return the contacts that engines are put to: each rule differs from every other."""
    rules = product(get_args(Tail), get_args(EffectiveMass))
    return [
        *(HEAD_ON.replace(name=f"e = 0.5, {tail}, m_eff {mass}", tail=tail, effective_mass=mass)
          for tail, mass in rules),
        SOURCE,
        SOURCE.replace(name="source, clipped", tail="clipped"),
        SOURCE.replace(name="source, m_eff half", effective_mass="half"),
        PLASTIC,
    ]  # fmt: skip


def collision(contact: Contact) -> Trial:
    """Return the test of a restitution.

    An error of one step in the contact's begin is omega h of the speed, and so is the
    first-order error of a scheme that meets damping explicitly.
    """
    case = _flying(contact)
    width = math.pi / case.steps_per_contact * (1.0 + 2.0 * case.zeta)
    tolerance = Tolerance(width, reason="omega h (1 + 2 zeta): a step of spring and dashpot")
    return Trial(f"head-on, {contact.name}", case, "restitution",
                 lambda path: float(path.vy[-1]) / SPEED, restitution(case), tolerance)  # fmt: skip


def trials(contact: Contact, digits: int) -> Iterator[Trial]:
    """Yield the drops that need a contact of some kind; ``digits`` are those of the output."""
    last = 10.0 ** (1 - digits)
    onset = _flying(contact, duration=3.0, every=1)
    yield Trial(
        "contact found within two steps", onset, "onset_steps",
        lambda path: (1.0 - float(path.y[_changes(path, digits)[0]])) / onset.step / SPEED, 0.0,
        Tolerance(2.0, reason="a step is the resolution, and a scheme may write one late"), "steps",
    )  # fmt: skip

    def contact_time_ratio(path: Path) -> float:
        lasts = np.ptp(path.time[list(_changes(path, digits))])
        return float(lasts / _impact_duration(onset) * math.sqrt(onset.stiffness))

    yield Trial(
        "contact lasts its time", onset, "contact_time_ratio", contact_time_ratio, 1.0,
        Tolerance(4.0 / onset.steps_per_contact, reason="two steps at either end"),
    )  # fmt: skip
    # soft, so that single precision resolves the overlap
    rest = Drop(contact=contact, stiffness=1e4, gravity=9.81, duration=40.0, every=1000)
    swing = 2.0 * math.exp(-rest.zeta * math.pi * rest.duration)
    reason = "what the dashpot has left of the motion, and the digits of the output"
    yield Trial(
        "at rest under its weight", rest, "static_overlap_ratio",
        lambda path: (1.0 - float(path.y[-1])) / rest.rest_overlap, 1.0,
        Tolerance(swing + 10.0 * last / rest.rest_overlap + ROUND_OFF, reason=reason),
    )  # fmt: skip
    fall = _falling(contact)
    late = Tolerance(2.0 * fall.step / fall.seconds + 20.0 * last / fall.gap,
                     reason="a scheme may begin half a step late or early")  # fmt: skip
    yield Trial(
        "free fall", fall, "fall_ratio",
        lambda path: (1.05 - float(path.y[-1])) / (0.5 * 9.81 * float(path.time[-1]) ** 2),
        1.0, late,
    )  # fmt: skip
    yield Trial(
        "energy of a free fall", fall, "energy_ratio",
        lambda path: 0.5 * float(path.vy[-1]) ** 2 / 9.81 / (1.05 - float(path.y[-1])), 1.0, late,
    )  # fmt: skip

    def momentum_ratio(path: Path) -> float:
        if not np.ptp(path.vy):
            raise EngineOutputError("the grain never felt the sphere")  # which changes no momentum
        return path.momentum_ratio

    aslant = Drop(contact=contact, sideways=SPEED, gap=-1e-4, duration=3.0, every=100)
    reason = "exact in symplectic schemes but for round-off and digits"
    yield Trial(
        "oblique contact", aslant, "angular_momentum_ratio", momentum_ratio, 1.0,
        Tolerance(max(ROUND_OFF, 10.0 * last), reason=reason),
    )  # fmt: skip


def _closed_form_check(trial: Trial) -> Check:
    job = CASE.job(trial.case)
    return Check(
        setup=trial.setup, quantity=trial.quantity, unit=trial.unit, kind=Kind.ANALYTIC,
        measure=lambda bench: trial.measure(read_path(trial.case, bench.output(job))),
        expected=trial.expected, tolerance=trial.tolerance, jobs=(job,),
    )  # fmt: skip


def _path_check(trial: Trial, digits: int) -> Check:
    """Return the check of a whole path, over the sizes of its overlap and its speed."""
    case, job = trial.case, CASE.job(trial.case)
    length, speed = case.largest_overlap or case.gap, case.largest_speed
    sizes = np.array([case.step / EPSILON**0.5, length, length, speed, speed])
    # a step rounds a place by half a unit at most, an output from the edge of a box once
    rounding = 0.5 * case.steps * EPSILON * (case.diameter / length)
    resolution = 1.25 * 10.0 ** (1 - digits) * (case.diameter / length)
    reason = "round-off of places over the largest overlap, and the digits of the output"

    def difference(bench: Bench) -> float:
        path = read_path(case, bench.output(job))
        reference = read_path(case, bench.reference_output(scene_of(case)))
        off = np.abs(np.array(path) - np.array(reference)).max(axis=1)
        return float((off / sizes).max())

    return Check(
        setup=trial.setup, quantity="path_difference", unit="1", measure=difference, expected=0.0,
        tolerance=Tolerance(ROUND_OFF + rounding + resolution, reason=reason),
        jobs=(job,),
    )  # fmt: skip


def _changes(path: Path, digits: int) -> tuple[int, int]:
    """Return the samples before the velocity changes first and last, as far as digits show."""
    if digits < FEWEST_DIGITS:
        reason = f"{digits} digits do not show where a contact begins"
        raise EngineOutputError(f"{reason}: the engine must write at least {FEWEST_DIGITS}")
    velocity = np.stack([path.vx, path.vy])
    resolution = 10.0 ** (2 - digits) * np.abs(velocity).max()
    changed = np.flatnonzero(np.abs(np.diff(velocity, axis=1)).max(axis=0) > resolution)
    if changed.size == 0:
        raise EngineOutputError("the grain never felt the sphere")
    return int(changed[0]), int(changed[-1])


def _flying(contact: Contact, duration: float = 25.0, every: int = 100) -> Drop:
    """Return a flight to the sphere; a contact ends late, the source's at 15 contact times."""
    case = Drop(contact=contact, speed=SPEED, duration=duration, every=every)
    return case.replace(gap=GAPS * SPEED * case.step)
