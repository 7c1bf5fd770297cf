"""A grain dropped on one fixed sphere of its size: every engine qualifies by it.

Each drop shows one fault: a dashpot that is missing or takes another effective mass (restitution),
a contact that is found late (onset), a wrong spring (rest), a wrong clock (free fall), a force
along the tangent (oblique contact). Every path is held against the reference at equal steps, and
what has a closed form against it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, get_args

import numpy as np

from harness.cases.base import Case, Check, Quantity
from harness.cases.bench import OWN, Bench
from harness.cases.drop.system import (
    HEAD_ON,
    TEMPLATE,
    Drop,
    Path,
    closed_forms,
    impact_duration,
    read_path,
    restitution,
    scene_of,
    values_of,
)
from harness.engines.base import Engine, Job, Output
from harness.errors import EngineOutputError
from harness.model.contact import PLASTIC, SOURCE, Contact, EffectiveMass, Tail
from harness.report.content import Drawing, Section, Table
from harness.results.rows import Kind, Tolerance

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

ROUND_OFF = 1e-9  # of a quantity's scale

# ---- what a path shows


def angular_momentum_ratio(path: Path) -> float:
    """Return the angular momentum about the sphere's centre, end over start; NaN for none there."""
    momentum = path.x * path.vy - path.y * path.vx
    return float(momentum[-1] / momentum[0]) if momentum[0] else math.nan


def changes(path: Path, digits: int) -> tuple[int, int]:
    """Return the samples before the velocity changes first and last, as far as digits show."""
    velocity = np.stack([path.vx, path.vy])
    resolution = 10.0 ** (2 - digits) * np.abs(velocity).max()
    changed = np.flatnonzero(np.abs(np.diff(velocity, axis=1)).max(axis=0) > resolution)
    if changed.size == 0:
        raise EngineOutputError("the grain never felt the sphere")
    return int(changed[0]), int(changed[-1])


# ---- the checks


class Trial(NamedTuple):
    """A drop with what is measured on its path, beside the path itself."""

    setup: str
    case: Drop
    quantity: str
    unit: str
    measure: Callable[[Path], float]
    expected: float
    tolerance: Tolerance


SPEED = 1.0  # [m/s] of the collisions, on spheres of 1 m and 1 kg
GAPS = 117.5  # steps before they begin: no number at which a sparse search might happen to look
PRESSED = 1e-4  # [d] of the grain that slides by, at the start


def contacts() -> Iterator[Contact]:
    """Yield the contacts that engines are put to: every rule tells itself from every other."""
    masses: Sequence[EffectiveMass] = get_args(EffectiveMass)
    tails: Sequence[Tail] = get_args(Tail)
    for tail in tails:
        for mass in masses:
            name = f"e = 0.5, {tail}, m_eff {mass}"
            yield Contact(name=name, restitution=0.5, tail=tail, effective_mass=mass)
    yield SOURCE
    yield SOURCE.replace(name="source, clipped", tail="clipped")
    yield SOURCE.replace(name="source, m_eff half", effective_mass="half")
    yield PLASTIC


def trials(contact: Contact, digits: int) -> Iterator[Trial]:
    """Yield the drops that need a contact of some kind; ``digits`` are those of the output."""
    last = 10.0 ** (1 - digits)
    onset = _flying(contact, duration=3.0, every=1)
    yield Trial("contact found within two steps", onset, "onset_steps", "steps",
                lambda path: (1.0 - float(path.y[changes(path, digits)[0]])) / onset.step / SPEED,
                0.0, Tolerance(2.0, reason="a step is the resolution, and a scheme may write one "
                               "late"))  # fmt: skip
    yield Trial("contact lasts its time", onset, "contact_time_ratio", "1",
                lambda path: float(np.ptp(path.time[list(changes(path, digits))])
                                   / impact_duration(onset) * math.sqrt(onset.stiffness)),
                1.0, Tolerance(4.0 / onset.steps_per_contact, reason="two steps at either end"),
                )  # fmt: skip
    # soft, so that single precision resolves the overlap
    rest = Drop(contact=contact, stiffness=1e4, gravity=9.81, duration=40.0, every=1000)
    swing = 2.0 * math.exp(-rest.zeta * math.pi * rest.duration)
    yield Trial("at rest under its weight", rest, "static_overlap_ratio", "1",
                lambda path: (1.0 - float(path.y[-1])) / rest.rest_overlap,
                1.0, Tolerance(swing + 10.0 * last / rest.rest_overlap + ROUND_OFF,
                               reason="what the dashpot has left of the motion, and the digits of "
                               "the output"))  # fmt: skip
    fall = _falling(contact)
    late = Tolerance(2.0 * fall.step / fall.seconds + 20.0 * last / fall.gap,
                     reason="a scheme may begin half a step late or early")  # fmt: skip
    yield Trial("free fall", fall, "fall_ratio", "1",
                lambda path: (1.05 - float(path.y[-1])) / (0.5 * 9.81 * float(path.time[-1]) ** 2),
                1.0, late)  # fmt: skip
    yield Trial("energy of a free fall", fall, "energy_ratio", "1",
                lambda path: 0.5 * float(path.vy[-1]) ** 2 / 9.81 / (1.05 - float(path.y[-1])),
                1.0, late)  # fmt: skip
    aslant = Drop(contact=contact, sideways=SPEED, gap=-PRESSED, duration=3.0, every=100)
    yield Trial("oblique contact", aslant, "angular_momentum_ratio", "1", angular_momentum_ratio,
                1.0, Tolerance(max(ROUND_OFF, 10.0 * last),
                               reason="exact in symplectic schemes but for round-off and digits"),
                )  # fmt: skip


def collision(contact: Contact) -> Trial:
    """Return the test of a restitution.

    An error of one step in the contact's begin is worth omega h of the speed, and so is the
    first-order error of a scheme that meets damping explicitly.
    """
    # a contact that ends late: at 15 contact times for the source's
    case = _flying(contact, duration=25.0, every=100)
    width = math.pi / case.steps_per_contact * (1.0 + 2.0 * case.zeta)
    return Trial(f"head-on, {contact.name}", case, "restitution", "1",
                 lambda path: float(path.vy[-1]) / SPEED, restitution(case),
                 Tolerance(width, reason="omega h (1 + 2 zeta): a step of spring and dashpot"),
                 )  # fmt: skip


def _flying(contact: Contact, duration: float, every: int) -> Drop:
    case = Drop(contact=contact, speed=SPEED, duration=duration, every=every)
    return case.replace(gap=GAPS * SPEED * case.step)


def _falling(contact: Contact) -> Drop:
    case = Drop(contact=contact, gravity=9.81, gap=0.05, every=100)
    return case.replace(duration=0.9 * math.sqrt(2.0 * case.gap / 9.81) / case.contact_time)


class DropCase(Case[Drop]):
    """A grain dropped on one fixed sphere: restitution, rest, free fall, oblique contact."""

    name = "drop"
    group = "contacts"
    summary = "a grain dropped on one fixed sphere; every engine qualifies by it"
    parameters = Drop
    qualifies = True
    quantities = (
        Quantity("restitution", "1", "speed of departure over that of approach"),
        Quantity("largest_sampled_overlap_m", "m", "largest overlap of the samples, or - gap",
                 lambda case: case.largest_overlap or max(case.gap, 0.0)),
        Quantity("end_overlap_m", "m", "overlap at the end; negative is a gap",
                 lambda case: max(case.largest_overlap, case.gap - case.fallen)),
        Quantity("end_speed_m_per_s", "m/s", "speed at the end",
                 lambda case: case.largest_speed),
        Quantity("angular_momentum_ratio", "1", "about the sphere's centre, end over start"),
    )  # fmt: skip

    @property
    def presets(self) -> Mapping[str, Drop]:  # type: ignore[override]
        """Return a collision, a rest, a fall and an oblique contact."""
        return {
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
        found = {
            "largest_sampled_overlap_m": float(overlap.max()),
            "end_overlap_m": float(overlap[-1]),
            "end_speed_m_per_s": float(np.hypot(path.vx[-1], path.vy[-1])),
        }
        head_on = parameters.speed > 0.0 and parameters.gravity == 0.0
        if parameters.sideways != 0.0:
            found["angular_momentum_ratio"] = angular_momentum_ratio(path)
        elif head_on and bool(overlap.max() > 0.0 >= overlap[-1]):
            found["restitution"] = float(path.vy[-1]) / parameters.speed
        return found

    def exact(self, parameters: Drop) -> Mapping[str, float]:
        """Return the quantities with a closed form."""
        return closed_forms(parameters)

    def checks(self, engine: Engine) -> Iterator[Check]:
        """Return the checks of an engine: of each trial its closed form, and the path."""
        digits = engine.traits.digits
        stated = (one for one in contacts() if not engine.refuses(self.job(collision(one).case)))
        any_contact = next(stated, SOURCE)
        seen = set[Drop]()
        for trial in (*map(collision, contacts()), *trials(any_contact, digits)):
            yield self._closed_form(trial)
            if trial.case not in seen:  # two quantities of one path
                yield self._equal_steps(trial, digits)
            seen.add(trial.case)

    def _closed_form(self, trial: Trial) -> Check:
        job = self.job(trial.case)
        return Check(
            setup=trial.setup, quantity=trial.quantity, unit=trial.unit, kind=Kind.ANALYTIC,
            measure=lambda bench: trial.measure(read_path(trial.case, bench.output(job))),
            expected=trial.expected, tolerance=trial.tolerance, jobs=(job,),
        )  # fmt: skip

    def _equal_steps(self, trial: Trial, digits: int) -> Check:
        """Return the check of a whole path, over the sizes of its overlap and its speed."""
        case, job = trial.case, self.job(trial.case)
        size = case.diameter / (case.largest_overlap or case.gap)
        # a step rounds a place by half a unit at most, an output from the edge of a box once
        rounding = 0.5 * case.steps * sys.float_info.epsilon * size
        resolution = 20.0 * 10.0 ** (1 - digits) * size

        def off(bench: Bench) -> float:
            path = read_path(case, bench.output(job))
            expected = read_path(case, bench.reference_output(scene_of(case)))
            return path_difference(case, path, expected)

        return Check(
            setup=trial.setup, quantity="path_difference", unit="1", measure=off, expected=0.0,
            tolerance=Tolerance(ROUND_OFF + rounding + resolution,
                                reason="round-off of places over the largest overlap, and the "
                                "digits of the output"), jobs=(job,),
        )  # fmt: skip

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return what each engine's drops measure, and the collisions of the first."""
        benches = {name: bench for name, bench in benches.items() if name != OWN}
        frame = _table(benches)
        if frame is None:
            return ()
        first = next(iter(benches.values()))
        drawing = Drawing(
            "drop-collisions", "Head-on collisions",
            "Normal speed of a grain over time, before and after it meets a fixed sphere, by "
            "contact. The bars are the expected speeds of the rebound.",
            lambda: draw_collisions(first),
        )  # fmt: skip
        text = "An engine's other results are used after these drops on one fixed sphere hold."
        table = Table("Restitutions", frame, "Measured, and by the closed form.")
        return (Section("How an engine qualifies", text, (table,), (drawing,)),)


def path_difference(case: Drop, path: Path, expected: Path) -> float:
    """Return the largest difference of place and velocity, over the largest overlap and speed."""
    length, speed = case.largest_overlap or case.gap, case.largest_speed
    time = np.abs(path.time - expected.time).max() / case.step
    places = np.abs(np.stack([path.x - expected.x, path.y - expected.y])).max() / length
    speeds = np.abs(np.stack([path.vx - expected.vx, path.vy - expected.vy])).max() / speed
    return float(max(time * sys.float_info.epsilon**0.5, places, speeds))


# ---- report


def _runs(bench: Bench) -> Iterator[tuple[Trial, Path]]:
    """Yield the collisions that a bench has run."""
    for trial in map(collision, contacts()):
        job = CASE.job(trial.case)
        if not bench.refusal(job):
            outcome = bench.outcomes([job])[0]
            if isinstance(outcome, Output):
                yield trial, read_path(trial.case, outcome)


def _table(benches: Mapping[str, Bench]) -> pd.DataFrame | None:
    import pandas as pd

    rows = [
        {"engine": name, "contact": trial.case.contact.name, "measured": trial.measure(path),
         "expected": trial.expected}
        for name, bench in benches.items() for trial, path in _runs(bench)
    ]  # fmt: skip
    return pd.DataFrame(rows) if rows else None


def draw_collisions(bench: Bench) -> Figure:
    """Draw the normal speed against time of each collision, with the expected rebound."""
    from harness.report.style import COLOURS, STYLES, axis, label, legend_below, panels

    figure = panels(1, 1, 8.0, 4.2)
    (axes,) = figure.axes
    for number, (trial, path) in enumerate(_runs(bench)):
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(path.time / trial.case.contact_time, path.vy / trial.case.speed, color=colour,
                  ls=STYLES[number % len(STYLES)], label=trial.case.contact.name)  # fmt: skip
        axes.plot(4.0, trial.expected, "_", color=colour, ms=16, clip_on=False)
    axes.set_xlim(0.0, 4.0)
    label(axes, axis("time", "contact times"), axis("normal velocity over the first speed"))
    legend_below(figure, 3)
    return figure


CASE = DropCase()
