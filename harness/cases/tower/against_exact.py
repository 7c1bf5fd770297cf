"""One code against the exact propagator under the same law: force, impulse, contacts, order."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

from harness.cases.contract import Study
from harness.cases.tower import tolerances
from harness.cases.tower.comparison import SeriesComparison, compare
from harness.cases.tower.evidence import CodeEvidence
from harness.cases.tower.records import LEAST_FORCE, force_comparison
from harness.cases.tower.run import tower
from harness.cases.tower.step_convergence import step_convergence
from harness.comparison.divergence import Comparison
from harness.comparison.triage import of_divergence
from harness.comparison.verdicts import Check, Kind, judge
from harness.observables.impulse import impulse
from harness.observables.tower import TowerRun
from harness.parameters.tower import Law, Tower

SHOWN = 2
"""Height whose force series the report shows: three particles, the source's example."""


def against_exact(
    run: TowerRun, exact: TowerRun, evidence: CodeEvidence, divergences: list[Comparison]
) -> list[Check]:
    """Return the rows of a run against the exact one of the same tower, both with profiles.

    A force that left its tolerance is added to ``divergences``.
    """
    found = compare(run, exact, least_force=LEAST_FORCE)
    if run.tower.height == SHOWN:
        evidence.same_law.setdefault(run.tower.law, []).append(found)
    name = f"tower: {run.solver}, {run.tower.law} law, n = {run.tower.height}"
    width = tolerances.FORCE[run.tower.law]
    series = force_comparison(name, found, width.width(0.0))
    triage = ""
    if series.divergence is not None:
        divergences.append(series)
        triage = of_divergence(series.divergence)
    return [
        judge(
            f"{name}: force, largest difference over the peak",
            Kind.CROSS_CODE,
            found.force.peak,
            0.0,
            width,
            triage=triage,
        ),
        judge(
            f"{name}: impulse to the turnaround",
            Kind.CROSS_CODE,
            impulse(run),
            impulse(exact),
            tolerances.IMPULSE,
            triage=triage,
        ),
        _events(name, found, triage),
    ]


def _events(name: str, found: SeriesComparison, triage: str) -> Check:
    """Hold the onsets and breaks of contacts against those of the exact run, one by one."""
    t0 = found.run.tower.contact_time
    alone = len(found.unmatched)
    return judge(
        f"{name}: contact changes, largest time difference",
        Kind.CROSS_CODE,
        math.inf if alone else found.largest_event_difference / t0,
        0.0,
        tolerances.CONTACT_CHANGES,
        note=f"{alone} of {len(found.events)} have no counterpart" if alone else "",
        triage=triage,
    )


def exact_run(case: Tower, samples: int, study: Study, *, profiles: bool = True) -> TowerRun:
    """Return the exact run of a tower with so many samples, made once in a study."""
    make = partial(tower, case, solver="exact", samples=samples, profiles=profiles)
    return study.once((case, samples, profiles), make)


def order(
    law: Law,
    code: str,
    run: Callable[[Tower, float], TowerRun],
    ladder: Sequence[float],
    evidence: CodeEvidence,
    study: Study,
) -> Check:
    """Measure how the force error falls with the step, against second order across onsets.

    ``run`` makes the run of a tower at so many steps per contact, ``ladder`` are those to take.
    """
    case = Tower(height=SHOWN + 1, law=law)
    exact = exact_run(case, 12_000, study, profiles=False)
    found = step_convergence(lambda steps: run(case, steps), exact, ladder)
    evidence.convergence.append(found)
    low, high = found.l2_order.interval
    return judge(
        f"tower: {code}, {law} law: order of the force error in the step, n = {case.height}",
        Kind.CROSS_CODE,
        found.l2_order.value,
        2.0,
        tolerances.ORDER,
        uncertainty=(high - low) / 2,
    )
