"""The case ``drop``: a grain meets one fixed sphere; every engine qualifies by it.

Each error of an engine that is known to occur shows here: a dashpot that is silently missing or
takes another effective mass (restitution), a contact that is found late (onset), a force along the
tangent (oblique), a wrong spring (static), a wrong clock (fall). Expected are closed forms.

It is in the group of contacts and no ``ContactCase``. Engines qualify by it that state no contact
with friction: the reference DEM, codes of other packages. It looks at a single step: what a
contact case extrapolates away with the step, such as a contact that is found one late, is what an
engine fails by here. And its parameters are the source's, ``contact.*`` with tail and effective
mass, whose scripts and baseline stay: by the template of contact cases LAMMPS's restitution
differs in the 15th digit.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from pydantic import Field, model_validator

from harness.cases.contract import Case, LevelName, Reference
from harness.cases.display import Display
from harness.cases.grain import COLUMNS, Grain, path_in, run_jobs, run_or_raise
from harness.cases.text import Words
from harness.cases.verification import Study, Verification, failed_part
from harness.comparison.regression import BaselineRecord, made_by, record_name
from harness.comparison.verdicts import Check, Kind, Planned, Tolerance, judge, not_tested
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output, Template, Value
from harness.engines.cost import STATED_SECONDS
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError, HarnessError
from harness.observables.provenance import Provenance
from harness.observables.reference import Trajectory
from harness.observables.row import Row, by_name
from harness.parameters.allowed import COUNT, allowed_in
from harness.parameters.law import (
    PLASTIC,
    SOURCE,
    Contact,
    Tail,
    contact_allowed,
    contact_of,
    contact_values,
)
from harness.parameters.scene import ContactScene
from harness.report.sections import Section
from harness.theory.contact import (
    duration_clipped,
    duration_unclipped,
    largest_overlap,
    restitution_clipped,
    restitution_unclipped,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LEAST_OVERLAP = 1e6 * sys.float_info.epsilon
"""[d] below which the rounding of a place is a millionth of the overlap or more."""

MOST_DECADES = 290.0
"""Between 1 and a mass [kg], and between that and a stiffness [N/m]: floats have 308."""


class Drop(Grain):
    """One run of a grain above a fixed sphere of its size, in SI units.

    The sphere's centre is the origin, the grain starts at (0, diameter + gap) and moves
    down with ``speed`` and along x with ``sideways``; gravity points down. Head-on
    collision, free fall, static contact and oblique contact are cases of it.
    """

    steps_per_contact: float = Field(
        2000.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)"
    )
    gravity: float = Field(0.0, ge=0.0, description="[m/s2] acceleration of gravity, downward")
    gap: float = Field(0.0, gt=-0.25, le=10.0, description="[m] from the sphere; negative: pressed")
    speed: float = Field(0.0, description="[m/s] downward, at the start")
    sideways: float = Field(0.0, description="[m/s] along x, at the start")
    duration: float = Field(
        3.0, gt=0.0, le=1e4, description="[-] of the run, in contact times pi sqrt(m/k)"
    )
    every: int = Field(1, ge=1, description="[-] steps between two samples of the path")

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
        return self

    @property
    def largest_overlap(self) -> float:
        """Return an upper bound of the overlap [m]: of a linear spring, undamped, head-on."""
        weight = self.mass * self.gravity / self.stiffness
        fall = math.sqrt(2.0 * self.gravity * max(self.gap, 0.0))
        speed = math.hypot(self.speed, self.sideways, fall)
        return weight + math.hypot(weight, speed * math.sqrt(self.mass / self.stiffness))

    @property
    def steps(self) -> int:
        """Return the number of steps, a multiple of ``every`` that covers the duration."""
        return self.every * math.ceil(self.duration * self.steps_per_contact / self.every - 1e-9)


NAME = "drop"
"""Name of the case, and of its template."""

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None)
"""The contact of the scripts as they stand."""

SAME = (
    *("stiffness", "steps_per_contact", "gravity", "diameter", "density"),
    *("gap", "speed", "sideways"),
)
"""Parameters that scripts are told under their own names."""


def values_of(case: Drop) -> dict[str, Value]:
    """Return a script's values for a drop."""
    values = {**case.values(*SAME, "steps"), "series_every": case.every}
    return {**values, **contact_values(case.contact)}


def case_of(values: Mapping[str, Any]) -> Drop:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    return Drop(
        contact=contact_of(values),
        every=values["series_every"],
        duration=values["steps"] / values["steps_per_contact"],
        **{name: values[name] for name in SAME},
    )


def scene_of(values: Mapping[str, Any]) -> ContactScene:
    """Return the grain, particle 1, and the fixed sphere as arrays."""
    case = case_of(values)
    return case.scene(
        (0.0, case.diameter + case.gap, case.sideways, -case.speed),
        [(0.0, 0.0)],
        gravity=(0.0, -case.gravity),
        steps=values["steps"],
        every=values["series_every"],
    )


TEMPLATE = Template(
    name=NAME,
    variants={"": values_of(Drop(contact=HEAD_ON, gap=1e-3, speed=1.0))},
    scene=scene_of,
    allowed={**allowed_in(Drop), **contact_allowed(), "steps": COUNT, "series_every": COUNT},
)


def job_of(case: Drop) -> Job:
    """Return the job of a drop, which writes the path."""
    return Job(TEMPLATE, values_of(case), sampled=True)


@dataclass(frozen=True)
class DropRun:
    """The grain's path, origin in the fixed sphere's centre; ``seconds`` of wall time it took."""

    case: Drop
    path: Trajectory
    seconds: float
    provenance: Provenance


def run_drops(engine: Engine, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
    """Run a grain against one fixed sphere, case by case, and return the paths in order.

    Raise RequestError for a case that the engine cannot state.
    """
    return run_jobs(engine, cases, job_of, read)


def read(case: Drop, output: Output) -> DropRun:
    """Return the drop in an output, every sample of it.

    Raise EngineOutputError for what is missing or cut, or ran with other settings, EngineNaNError
    for values that are not finite.
    """
    output.check_numbers({**case.settings(), "steps": case.steps})
    table = output.table(COLUMNS, case.steps // case.every + 1)
    return DropRun(case, path_in(table), output.seconds, output.provenance)


RESTED = 1e-6
"""Part of its motion that a grain keeps at most which is said to rest."""


def restitution(case: Drop) -> float:
    """Return the restitution of a head-on collision with the linear spring."""
    law = restitution_clipped if case.contact.tail == "clipped" else restitution_unclipped
    return law(case.contact.zeta_against_full_mass)


def rest(case: Drop) -> tuple[float, float]:
    """Return the overlap m g / k [m], and the slowest rate [1/s] at which it is reached."""
    zeta = case.contact.zeta_against_full_mass
    slowest = zeta - math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else zeta
    overlap = case.mass * case.gravity / case.stiffness
    return overlap, slowest * math.sqrt(case.stiffness / case.mass)


def _impact(case: Drop) -> dict[str, Reference]:
    """Return the largest overlap of a collision that turns within the run, and the end speed.

    The motion turns at half the time at which the clipped force vanishes.
    """
    zeta, unit = case.contact.zeta_against_full_mass, math.sqrt(case.mass / case.stiffness)
    remaining = (case.steps * case.step - max(case.gap, 0.0) / case.speed) / unit
    parts = clipped = duration_clipped(zeta)
    if case.contact.tail != "clipped":  # from critical damping on it creeps back for ever
        parts = duration_unclipped(zeta) if zeta < 1.0 else math.inf
    references = {}
    if remaining >= 0.5 * clipped:
        deepest = case.speed * largest_overlap(zeta) * unit
        references["largest_sampled_overlap_m"] = Reference(deepest, "closed form")
    if remaining >= parts:
        references["restitution"] = Reference(restitution(case), "closed form")
        references["end_speed_m_per_s"] = Reference(restitution(case) * case.speed, "closed form")
    return references


def _falling(case: Drop) -> dict[str, Reference]:
    """Return where a free fall ends; {} for one that meets the sphere."""
    time = case.steps * case.step
    fallen = case.speed * time + 0.5 * case.gravity * time * time
    if fallen >= case.gap:
        return {}
    return {
        "end_overlap_m": Reference(fallen - case.gap, "closed form"),
        "end_speed_m_per_s": Reference(case.speed + case.gravity * time, "closed form"),
    }


def _resting(case: Drop) -> dict[str, Reference]:
    """Return the overlap under the weight; {} for a grain that is still moving at the end."""
    overlap, rate = rest(case)
    if math.exp(-rate * case.steps * case.step) > RESTED:
        return {}
    return {"end_overlap_m": Reference(overlap, "closed form")}


HEAD_ON_CHECK = "restitution head-on"

HALF = 0.5
"""Restitution that tells every rule from every other."""

GAPS = 117.5
"""Steps that the grain flies before it meets the sphere: no round number, at which a sparse
search for contacts might happen to look."""

SPEED = 1.0
"""[m/s] of the collisions, on spheres of 1 m and 1 kg."""

OVERLAP = 1e-4
"""[d] of the grain that slides by: pressed in at the start."""


@dataclass(frozen=True)
class DropTest:
    """A drop, what is measured on its path, what is expected, and how close.

    ``quantity`` is the name of what is measured, in the baseline.
    """

    name: str
    quantity: str
    case: Drop
    measure: Callable[[DropRun], float]
    expected: float
    tolerance: Tolerance


@dataclass(frozen=True)
class DropEvidence:
    """The runs of an engine's drops with their tests."""

    engine_title: str
    runs: tuple[tuple[DropTest, DropRun], ...]


def drop_tests(traits: Traits) -> Iterator[DropTest]:
    """Yield the tests that an engine with such traits can be put to."""
    for contact in _contacts(traits):
        yield _collision(contact)
    yield _static(traits)
    yield _onset(traits)
    yield _fall(traits)
    yield _oblique(traits)


def _contacts(traits: Traits) -> Iterator[Contact]:
    masses: Sequence[Any] = traits.frictionless.states["effective_mass"]
    named = ((f"e = {HALF:g}, {t}, m_eff {m}", t, m) for t in get_args(Tail) for m in masses)
    contacts = [
        Contact(name=name, restitution=HALF, tail=tail, effective_mass=mass)
        for name, tail, mass in named
    ]
    others = (SOURCE, SOURCE.replace(name="source, clipped", tail="clipped"), PLASTIC)
    contacts += [contact.replace(effective_mass=masses[0]) for contact in others]
    yield from (contact for contact in contacts if not traits.refuses_contact(contact))


def _any_contact(traits: Traits) -> Contact:
    """Return a contact with damping that the engine can state."""
    return next(iter(_contacts(traits)))


def _collision(contact: Contact) -> DropTest:
    """Return the test of a restitution.

    An error of one step in the contact's begin is worth omega h of the speed, and so is
    the first-order error of a scheme that meets damping explicitly.
    """
    # a contact that ends late: at 15 contact times for the source's
    case = _flying(contact, duration=25.0, every=100)
    width = math.pi / case.steps_per_contact * (1.0 + 2.0 * contact.zeta_against_full_mass)
    return DropTest(
        f"{HEAD_ON_CHECK}, {contact.name}",
        "restitution",
        case,
        lambda run: float(run.path.vy_m_per_s[-1]) / SPEED,
        restitution(case),
        Tolerance("", width, 0.0, "omega h (1 + 2 zeta): a step's worth of spring and dashpot"),
    )


def _flying(contact: Contact, duration: float, every: int) -> Drop:
    case = Drop(contact=contact, speed=SPEED, duration=duration, every=every)
    return case.replace(gap=GAPS * case.speed * case.step)


def _onset(traits: Traits) -> DropTest:
    """Return a collision whose result depends on whether the force begins one step late."""
    case = _flying(_any_contact(traits), duration=0.2, every=1)
    resolution = 10.0 ** (1 - traits.digits)
    return DropTest(
        "contact found within two steps",
        "onset_steps",
        case,
        lambda run: _depth_of_onset(run, resolution) / (case.speed * case.step),
        0.0,
        Tolerance("steps", 2.0, 0.0, "a step is the resolution, and a scheme may write one late"),
    )


def _depth_of_onset(run: DropRun, resolution: float) -> float:
    """Return the depth [m] to which the grain flies freely, by its first change of speed."""
    v = run.path.vy_m_per_s
    changed = np.flatnonzero(np.abs(v - v[0]) > 10.0 * resolution * abs(v[0]))
    if changed.size == 0:
        raise EngineOutputError(f"{run.provenance.engine}: the grain never felt the sphere")
    return float(run.case.diameter - run.path.y_m[changed[0] - 1])


def _static(traits: Traits) -> DropTest:
    """Return the grain that comes to rest under its weight: the overlap is m g / k."""
    contact = _any_contact(traits)
    # soft, so that single precision resolves the overlap
    case = Drop(contact=contact, stiffness=1e4, gravity=9.81, duration=40.0, every=1000)
    amplitude = 2.0 * math.exp(-contact.zeta_against_full_mass * math.pi * case.duration)
    overlap, _ = rest(case)
    digits = 10.0 ** (1 - traits.digits) * case.diameter / overlap
    return DropTest(
        "static contact, overlap over m g / k",
        "static_overlap_ratio",
        case,
        lambda run: (case.diameter - float(run.path.y_m[-1])) / overlap,
        1.0,
        Tolerance(
            "",
            amplitude + 10.0 * digits + 1e-9,
            0.0,
            "what the dashpot has left of the motion, and the digits of the output",
        ),
    )


def _fall(traits: Traits) -> DropTest:
    """Return the free fall that ends before it meets the sphere: g t^2 / 2."""
    case = Drop(contact=_any_contact(traits), gravity=9.81, gap=0.05, every=100)
    time = 0.9 * math.sqrt(2.0 * case.gap / case.gravity)
    case = case.replace(duration=time / case.contact_time)

    def fallen(run: DropRun) -> float:
        t = float(run.path.time_s[-1])
        start = case.diameter + case.gap
        return (start - float(run.path.y_m[-1])) / (0.5 * case.gravity * t * t)

    step = 2.0 * case.step / time
    digits = 10.0 ** (1 - traits.digits) / case.gap
    return DropTest(
        "free fall over g t^2 / 2",
        "fall_ratio",
        case,
        fallen,
        1.0,
        Tolerance("", step + 10.0 * digits, 0.0, "a scheme may begin half a step late or early"),
    )


def _oblique(traits: Traits) -> DropTest:
    """Return the grain that slides by a sphere: a central force keeps m (x vy - y vx)."""
    case = Drop(contact=_any_contact(traits), sideways=SPEED, gap=-OVERLAP, duration=3.0, every=100)

    def kept(run: DropRun) -> float:
        ratio = angular_momentum_ratio(run.path)
        if not math.isfinite(ratio):
            raise EngineOutputError(f"{run.provenance.engine}: the grain never moved sideways")
        return ratio

    width = max(1e-9, 10.0 * 10.0 ** (1 - traits.digits))
    return DropTest(
        "oblique contact, angular momentum kept",
        "angular_momentum_ratio",
        case,
        kept,
        1.0,
        Tolerance("", width, 0.0, "exact in symplectic schemes but for round-off and digits"),
    )


def angular_momentum_ratio(path: Trajectory) -> float:
    """Return the angular momentum about the sphere's centre, end over start; NaN for none there."""
    momentum = path.x_m * path.vy_m_per_s - path.y_m * path.vx_m_per_s
    return float(momentum[-1] / momentum[0]) if momentum[0] else math.nan


SHOWN = 4.0
"""[contact times] of the motion that are drawn: later only the source's contact still changes."""


def speeds_of_collisions(runs: Sequence[tuple[DropTest, DropRun]], engine_title: str) -> Figure:
    """Draw the normal speed against time of each collision, with the expected rebound."""
    from matplotlib.figure import Figure

    from harness.report.style import BLACK, COLOURS, MARKERS, STYLES, legend_below

    figure = Figure(figsize=(8.0, 4.2))
    axes = figure.add_subplot()
    for number, (test, run) in enumerate(
        (test, run) for test, run in runs if test.quantity == "restitution"
    ):
        time = run.path.time_s / run.case.contact_time
        axes.plot(
            time,
            run.path.vy_m_per_s / run.case.speed,
            color=COLOURS[number % 7],
            ls=STYLES[number % 6],
            marker=MARKERS[number % 6],
            markevery=(number, 9),
            mfc="none",
            lw=1.1,
            label=run.case.contact.name,
        )
        axes.plot(SHOWN, test.expected, "_", color=BLACK, ms=16, clip_on=False)
    axes.set(xlabel="time (contact times)", ylabel="normal velocity over the first speed")
    axes.set_xlim(0.0, SHOWN)
    axes.set_title(f"{engine_title}; bars: expected after the rebound")
    legend_below(figure, 3)
    return figure


WORDS = Words(__file__)


LONGER = 4.0
"""How many times as long the second of two runs is that tell what a step costs."""


class DropCase(Case[Drop]):
    """A grain meets one fixed sphere: restitution, rest, free fall, oblique contact."""

    name = NAME
    group = "contacts"
    qualifies = True
    template = TEMPLATE
    verified_by = "harness.cases.drop.case:DropVerification"
    shown_by = "harness.cases.drop.case:DropDisplay"

    @property
    def presets(self) -> Mapping[str, Drop]:
        """Return a collision, a rest, a fall and an oblique contact."""
        fall = Drop(contact=HEAD_ON, gravity=9.81, gap=0.05)
        longest = 0.9 * math.sqrt(2.0 * fall.gap / fall.gravity) / fall.contact_time
        return {
            "head-on": Drop(contact=HEAD_ON, gap=1e-3, speed=1.0),
            "plastic": Drop(contact=PLASTIC, gap=1e-3, speed=1.0, duration=25.0, every=10),
            "static": Drop(contact=HEAD_ON, stiffness=1e4, gravity=9.81, duration=40.0, every=100),
            "fall": fall.replace(duration=longest, every=100),
            "oblique": Drop(contact=HEAD_ON, sideways=1.0, gap=-1e-4, every=100),
        }

    def job(self, parameters: Drop) -> Job:
        """Return the job of one drop."""
        return job_of(parameters)

    def read(self, parameters: Drop, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return what the path tells; raise EngineOutputError for one that is cut.

        The restitution is that of a head-on collision that is over; the ratio of angular momenta
        is there where the grain has one.
        """
        path = read(parameters, output).path
        overlap = parameters.diameter - (path.x_m**2 + path.y_m**2) ** 0.5
        quantities = {
            "largest_sampled_overlap_m": float(overlap.max()),
            "end_overlap_m": float(overlap[-1]),
            "end_speed_m_per_s": float(path.speed_m_per_s[-1]),
        }
        head_on = parameters.speed > 0.0 and parameters.gravity == 0.0
        if parameters.sideways != 0.0:
            quantities["angular_momentum_ratio"] = angular_momentum_ratio(path)
        elif head_on and bool(overlap.max() > 0.0 >= overlap[-1]):  # met, and over
            quantities["restitution"] = float(path.vy_m_per_s[-1]) / parameters.speed
        return quantities

    def references(self, parameters: Drop, traits: Traits) -> Mapping[str, Reference]:
        """Return what is expected in closed form; {} where nothing is known."""
        if parameters.sideways != 0.0:
            kept = parameters.gravity == 0.0
            return {"angular_momentum_ratio": Reference(1.0, "closed form")} if kept else {}
        if parameters.gravity > 0.0 and parameters.gap > 0.0:
            return _falling(parameters)
        if parameters.gravity > 0.0:
            return _resting(parameters)
        if parameters.speed <= 0.0:
            return {}
        return _impact(parameters)


class DropVerification(Verification):
    """Runs the drops that an engine supports; engines qualify by it."""

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return a check for each drop, and for each named contact that the engine refuses."""
        drops = [f"{engine.name}: {test.name}" for test in drop_tests(engine.traits)]
        return [Planned(name) for name in (*drops, *_refused(engine))]

    def seconds(self, engine: Engine) -> float:
        """Return the steps of the drops times what one takes, from runs of different lengths [s].

        The first run is not timed: an engine may compile then. What starting a run takes drops out.
        """
        drops = [test.case for test in drop_tests(engine.traits)]
        steps = sum(drop.steps for drop in drops) / engine.workers
        short = min(drops, key=lambda drop: drop.steps)
        longer = short.replace(duration=LONGER * short.duration)
        try:
            _seconds(engine, short)
            least = _seconds(engine, short)
            if least / short.steps * steps < STATED_SECONDS:
                return 0.0
            more = _seconds(engine, longer) - least
        except HarnessError:
            return 0.0  # which its verification tells
        return max(0.0, more / (longer.steps - short.steps) * steps)

    def run(self, engine: Engine, study: Study) -> Findings:
        """Run the drops that an engine supports and judge each against the value of its rules."""
        tests = list(drop_tests(engine.traits))
        findings = Findings(NAME, engine.name)
        try:
            runs = run_drops(engine, [test.case for test in tests])
        except EngineError as error:
            runs = [error] * len(tests)
        completed = []
        for test, run in zip(tests, runs, strict=True):
            check = _judged(f"{engine.name}: {test.name}", test, run)
            findings.checks.append(check)
            name = _key(engine.name, test)
            if isinstance(run, EngineError):
                findings.errors[name] = run
            elif math.isfinite(check.value):
                findings.records.append(_record(name, test, run, check.value))
                completed.append((test, run))
        for name, reason in _refused(engine).items():
            findings.checks.append(not_tested(name, Kind.ANALYTIC, reason))
        findings.evidence = DropEvidence(engine.title, tuple(completed))
        return findings


class DropDisplay(Display):
    """Shows the drops of all engines, and the collisions of the first."""

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the collisions of the engines, with a figure of the main one's."""
        every = [*([main] if main is not None else []), *engines.values()]
        drawn = [
            findings.evidence
            for findings in every
            if findings.evidence is not None and findings.evidence.runs
        ]
        if not drawn:
            return ()
        rows = [
            (evidence.engine_title, test.name, f"{test.measure(run):.8g}", f"{test.expected:.8g}")
            for evidence in drawn
            for test, run in evidence.runs
        ]
        table = WORDS.table("Drops", tuple(dict.fromkeys(rows)))
        first = drawn[0]
        drawing = WORDS.drawing(
            "drop-collisions", lambda: speeds_of_collisions(first.runs, first.engine_title)
        )
        return (WORDS.section("drops", tables=(table,), drawings=(drawing,)),)


def _refused(engine: Engine) -> dict[str, str]:
    """Return the engine's reasons to refuse named contacts, by the name of their row."""
    return {
        f"{engine.name}: restitution head-on, {contact.name} contact": refused
        for contact in (SOURCE, PLASTIC)
        if (refused := engine.traits.refuses_contact(contact))
    }


def _seconds(engine: Engine, drop: Drop) -> float:
    """Return the wall time of one drop; raise the error of one that fails."""
    clock = time.monotonic()
    run_or_raise(run_drops(engine, [drop])[0])
    return time.monotonic() - clock


def _judged(name: str, test: DropTest, run: DropRun | EngineError) -> Check:
    """Return the row of a test; the failed row of a run that died or cannot be measured."""
    try:
        value = test.measure(run_or_raise(run))
    except Exception as error:
        return failed_part(name, error, test.tolerance.unit, Kind.ANALYTIC)
    return judge(name, Kind.ANALYTIC, value, test.expected, test.tolerance)


def _key(engine: str, test: DropTest) -> str:
    words = f"{test.quantity} {test.case.contact.name}".replace("_", " ")
    return record_name(engine, NAME, words)


def _record(name: str, test: DropTest, run: DropRun, value: float) -> BaselineRecord:
    return BaselineRecord(
        name=name,
        parameters=test.case.model_dump(mode="json"),
        quantities=by_name(Row(test.quantity, value, 0.0, test.tolerance.unit)),
        case=NAME,
        label=test.name,
        family=(test.case.contact.name,),
        **made_by(run.provenance),
    )


CASE = DropCase()
