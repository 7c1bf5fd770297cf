"""A grain that meets one fixed sphere, as a case; engines qualify with it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence

from harness.cases.case_text import tolerances_of
from harness.cases.contract import Case, LevelName, Reference, Study
from harness.cases.drop.checks import DropEvidence, DropTest, angular_momentum_ratio, drop_tests
from harness.cases.drop.expected import references_of
from harness.cases.drop.parameters import Drop
from harness.cases.drop.runs import DropRun, read, run_drops
from harness.cases.drop.template import HEAD_ON, NAME, TEMPLATE, job_of
from harness.cases.parts import failed_part
from harness.cases.runs import whole
from harness.comparison.baseline_record import BaselineRecord, Quantity, made_by, record_name
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, Kind, judge, not_tested
from harness.engines.contract import Engine, Job, Output
from harness.engines.cost import STATED_SECONDS
from harness.engines.traits import Traits
from harness.errors import EngineError, HarnessError
from harness.parameters.contact import PLASTIC, SOURCE
from harness.report.sections import Section

LONGER = 4.0
"""How many times as long the second of two runs is that tell what a step costs."""


class DropCase(Case[Drop]):
    """A grain meets one fixed sphere: restitution, rest, free fall, oblique contact."""

    name = NAME
    group = "contacts"
    qualifies = True
    template = TEMPLATE
    regression = tolerances_of(__file__, "regression")

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
        found = {
            "largest_sampled_overlap_m": float(overlap.max()),
            "end_overlap_m": float(overlap[-1]),
            "end_speed_m_per_s": float(path.speed_m_per_s[-1]),
        }
        head_on = parameters.speed > 0.0 and parameters.gravity == 0.0
        if parameters.sideways != 0.0:
            found["angular_momentum_ratio"] = angular_momentum_ratio(path)
        elif head_on and bool(overlap.max() > 0.0 >= overlap[-1]):  # met, and over
            found["restitution"] = float(path.vy_m_per_s[-1]) / parameters.speed
        return found

    def references(self, parameters: Drop, traits: Traits) -> Mapping[str, Reference]:
        """Return what is expected under an engine's spring."""
        return references_of(parameters, traits.spring)

    def expected_rows(self, level: LevelName, engine: Engine) -> int:
        """Return a row for each drop, and for each named contact that the engine refuses."""
        refused = [c for c in (SOURCE, PLASTIC) if engine.traits.refuses_contact(c)]
        return len(list(drop_tests(engine.traits))) + len(refused)

    def seconds_to_verify(self, engine: Engine) -> float:
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

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Run the drops that an engine can state and judge each against what its rules ask for."""
        tests = list(drop_tests(engine.traits))
        found = Findings(self.name, engine.name)
        try:
            runs = run_drops(engine, [test.case for test in tests])
        except EngineError as error:
            runs = [error] * len(tests)
        made = []
        for test, run in zip(tests, runs, strict=True):
            check = _judged(f"{engine.name}: {test.name}", test, run)
            found.checks.append(check)
            name = _key(engine.name, test)
            if isinstance(run, EngineError):
                found.errors[name] = run
            elif math.isfinite(check.value):
                found.records.append(_record(name, test, run, check.value))
                made.append((test, run))
        for contact in (SOURCE, PLASTIC):
            refused = engine.traits.refuses_contact(contact)
            if refused:
                name = f"{engine.name}: restitution head-on, {contact.name} contact"
                found.checks.append(not_tested(name, Kind.ANALYTIC, refused))
        found.evidence = DropEvidence(engine.title, tuple(made))
        return found

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the collisions of the engines, with a figure of the main one's."""
        from harness.cases.drop.sections import sections_of

        found = [*([main] if main is not None else []), *beside.values()]
        return sections_of([one.evidence for one in found if one.evidence is not None])


def _seconds(engine: Engine, drop: Drop) -> float:
    """Return the wall time of one drop; raise the error of one that fails."""
    clock = time.monotonic()
    whole(run_drops(engine, [drop])[0])
    return time.monotonic() - clock


def _judged(name: str, test: DropTest, run: DropRun | EngineError) -> Check:
    """Return the row of a test; the failed row of a run that died or cannot be measured."""
    try:
        value = test.measure(whole(run))
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
        quantities={test.quantity: Quantity(value, 0.0, test.tolerance.unit)},
        case=NAME,
        label=test.name,
        family=(test.case.contact.name,),
        **made_by(run.provenance),
    )


CASE = DropCase()
