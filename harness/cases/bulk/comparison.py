"""Means over seeds, laws of codes, and the equivalence of two codes.

Two codes are equivalent where the 90 % interval of the ratio of their means is within a margin that
was stated before: two one-sided tests at 5 % each (Schuirmann, J. Pharmacokinet. Biopharm. 15, 657
(1987)). They are not where it is outside of the margin as a whole; else nothing is decided.
Intervals are Student's of a mean and Welch's of a ratio: percentiles of a bootstrap are too narrow
for few values, and would err in 10 % of all cases for 4 seeds in place of 5 %.

The law is Hertz's with a dashpot for the restitution, Mindlin's without one, Coulomb's. Codes take
its tangential spring and the tail of its dashpot in their own ways: the law of an engine is the
nearest one for which :meth:`harness.engines.base.Engine.rules` raises nothing. Where two codes have
different laws, a ratio of their means is a finding, no fault of either; a code whose scripts take
the rules as values also runs under those of the other, and is compared with it, and with itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from harness.cases.base import Check, Value
from harness.cases.bulk.beds import Bed, Floats
from harness.engines.base import Engine, Values
from harness.engines.base import Value as ScriptValue
from harness.errors import Unsupported
from harness.model.base import Allowed
from harness.model.law import Law
from harness.model.scene import Scene, sphere
from harness.results.rows import Failure, Kind, Tolerance
from harness.theory.contact import restitution_unclipped, stiffness_ratio

if TYPE_CHECKING:
    from harness.cases.bench import Bench
    from harness.cases.bulk import BulkCase, Setup

TIME = "microseconds_per_particle_step"  # differs between runs that are the same
FEWEST = 4  # seeds of an interval: fewer rest on the normal distribution alone
EQUIVALENT = Tolerance(
    0.05,
    reason="stated before any run: codes are equivalent where the 90 % interval of the ratio of "
    "their means is within 5 % of 1, two one-sided tests of 5 %",
    whole_interval=True,
)
BY_CHANCE = Tolerance(
    0.99, reason="chance alone gives such a difference of shares in 1 % of cases"
)  # of Fisher's p, from 1
# tangential springs, from the one of LAMMPS's scripts to the farthest: a displacement times the
# stiffness of the overlap as it is, a force that grows by increments, one that also shrinks with
# the overlap
SPRINGS = ("mindlin", "mindlin/force", "mindlin_rescale/force")
ALLOWED = {
    "tangential": Allowed(words=SPRINGS),
    "tangential_damping": Allowed(bounds={"minimum": 0}),
    "clipped": Allowed(words=("yes", "no")),
}
FIT = (
    *(-6.918798, -16.41105, 146.8049, -796.4559, 2928.711),
    *(-7206.864, 11494.29, -11342.18, 6276.757, -1489.915),
)  # h_1 to h_10 of Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013), B6


# ---- means over the runs of a setup


class Sample(NamedTuple):
    """The runs of a setup in an engine: quantities of each run with a value, and its curves.

    ``undecided`` are the reasons of runs that ended without the event that they wait for.
    """

    rows: tuple[Mapping[str, float], ...]
    curves: tuple[Mapping[str, Floats], ...]
    undecided: tuple[str, ...]

    def decided(self) -> Sample:
        """Return the sample; raise Unsupported where no run has a value."""
        if not self.rows:
            runs = len(self.undecided)
            raise Unsupported(f"{runs} of {runs} runs have no value; {self.undecided[0]}")
        return self

    def values(self, quantity: str) -> Floats:
        """Return the values of a quantity over the runs, (runs,); NaN where it is not measured."""
        return np.array([row.get(quantity, math.nan) for row in self.rows])

    def mean(self, quantity: str) -> float:
        """Return the mean over the runs."""
        return float(self.values(quantity).mean())

    def mean_value(self, quantity: str, note: str = "") -> Value:
        """Return the mean with the half width of its 95 % interval, of few runs without one."""
        low, high = mean_interval(self.values(quantity))
        half = 0.0 if math.isnan(low) else 0.5 * (high - low)
        return Value(self.mean(quantity), half, note)

    def check_spread(self, title: str) -> None:
        """Raise Unsupported where fewer than :data:`FEWEST` runs differ in more than their time.

        A code that ignores the seed has runs that are all the same, and no spread.
        """
        different = {tuple(v for name, v in row.items() if name != TIME) for row in self.rows}
        if len(different) < FEWEST:
            raise Unsupported(f"fewer than {FEWEST} different runs gave a value in {title}")


def mean_interval(values: Floats) -> tuple[float, float]:
    """Return Student's 95 % interval of a mean; of fewer than :data:`FEWEST` values NaN."""
    from scipy import stats

    if len(values) < FEWEST:
        return math.nan, math.nan
    half = stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)
    return float(values.mean() - half), float(values.mean() + half)


def ratio_of_means(first: Floats, second: Floats) -> Value:
    """Return the ratio of two means with the half width of its 90 % interval.

    The ratio r of means a and b is off by (a - r b)/b, to first order in the error of b: the
    interval is Welch's (Biometrika 34, 28 (1947)) of the difference of a and r b, over b. Raise
    Unsupported where both means are 0; a mean that is not finite, or 0 in the second engine alone,
    is a failure.
    """
    from scipy.stats import ttest_ind

    above, below = float(first.mean()), float(second.mean())
    if below == 0.0 and (second.any() or not first.any()):
        raise Unsupported("the mean of the second engine is 0: there is no ratio of means")
    note = f"means {above:.6g} over {len(first)} runs and {below:.6g} over {len(second)}"
    if below == 0.0 or not math.isfinite(above + below):
        return Value(math.nan, math.nan, note, Failure.NOT_A_NUMBER)
    ratio = above / below
    if not np.ptp(first) and not np.ptp(second):
        return Value(ratio, 0.0, note)
    test = ttest_ind(first, ratio * second, equal_var=False)
    low, high = test.confidence_interval(0.90)
    return Value(ratio, float(0.5 * (high - low) / abs(below)), note)


def same_shares(first: Sample, second: Sample) -> Value:
    """Return Fisher's p [-] for equal shares of runs without a value, 1 for equal ones.

    Means are over runs with a value: of engines that differ in how many have none, means decide
    nothing. Raise Unsupported for shares that differ over so few runs that no difference would be
    beyond chance, and where no run has a value.
    """
    from scipy.stats import fisher_exact

    counts = np.array([(len(sample.rows), len(sample.undecided)) for sample in (first, second)])
    note = " and ".join(f"{without} of {of + without}" for of, without in counts)
    chance, numbers = float(fisher_exact(counts).pvalue), counts.sum(axis=1)
    least = float(fisher_exact(np.diag(numbers)).pvalue)  # all of one engine, none of the other
    if not counts[:, 0].any() or (chance < 1.0 and least >= 1.0 - BY_CHANCE.absolute):
        raise Unsupported(f"without a value: {note} runs, which decides nothing")
    return Value(chance, note=f"without a value: {note}")


# ---- the law by which a code runs a bulk job


@dataclass(frozen=True)
class StatedLaw:
    """The law by which an engine runs a bulk job.

    ``lacks`` is the part of it that no value of a script gives, in the engine's words.
    """

    law: Law
    lacks: str = ""

    @property
    def text(self) -> str:
        """Return the rules in words."""
        tail = "never attracts" if self.law.clipped else "attracts at its end"
        text = f"tangential spring {self.law.tangential}, a contact {tail}"
        return f"{text}, {self.lacks}" if self.lacks else text

    @property
    def rules(self) -> dict[str, ScriptValue]:
        """Return the values of scripts for the rules of the law."""
        return {
            "tangential": self.law.tangential,
            "clipped": "yes" if self.law.clipped else "no",
            "tangential_damping": self.law.tangential_damping or 0.0,
        }

    def values(self, values: Values) -> dict[str, ScriptValue]:
        """Return the values of a job under these rules.

        Without a tail, a restitution becomes that of the same dashpot with a tail.
        """
        names = [n for n in values if n.endswith("restitution")] if self.law.clipped else []
        return {**values, **self.rules, **{n: with_tail(float(values[n])) for n in names}}


def bulk_law(poisson_ratio: float = 0.2, rolling_friction: float = 0.0) -> Law:
    """Return the law of two grains of a bulk case, by the coefficients that decide its rules."""
    law = Law(
        normal="hertz", youngs_modulus=1e6, poisson_ratio=poisson_ratio, friction=0.3,
        damping="coeff_restitution", restitution=0.5, tangential="mindlin", tangential_damping=0.0,
    )  # fmt: skip
    if rolling_friction == 0.0:
        return law
    spring = {"rolling_stiffness": 1.0, "rolling_damping": 0.0}
    return law.replace(rolling="sds", rolling_friction=rolling_friction, **spring)


def stated_law(engine: Engine, law: Law) -> StatedLaw:
    """Return the law of an engine for a bulk law: the first of those near to it that it has.

    It must have the law as a whole, else without rolling, else without dashpots: a code whose
    tangential dashpot is tied to the normal one has the same share of critical damping in both.
    """
    kinds = product(SPRINGS, (False, True))
    springs = [law.replace(tangential=spring, clipped=clipped) for spring, clipped in kinds]
    tied = math.sqrt(stiffness_ratio(law.poisson_ratio or 0.0))
    candidates = [(near, near) for near in springs]
    candidates += [(near, near.replace(rolling="none")) for near in springs]
    candidates += [
        (near.replace(tangential_damping=tied), near.replace(damping="none", rolling="none"))
        for near in springs[1::2]
    ]
    for near, part in candidates:
        if not (reason := _refusal(engine, part)):
            return StatedLaw(near, _refusal(engine, near))
    return StatedLaw(law, f"its rules are not known: {reason}")


def _refusal(engine: Engine, law: Law) -> str:
    bodies = sphere(1e-3, 2500.0), sphere(1e-3, 2500.0, position=(2e-3, 0.0, 0.0))
    try:
        engine.rules(Scene(bodies=bodies, law=law, step=1e-7, steps=1))
    except Unsupported as error:
        return str(error)
    return ""


def with_tail(restitution: float) -> float:
    """Return the restitution with a tail of the dashpot that gives one without [-].

    Yade and Kratos take gamma of eta_n = 2 gamma sqrt(m* k_n), k_n = 2 E* a, of Hertz's spring
    whose force never attracts, by the fit of Thornton and others (B6), right to 3e-4 of
    restitution up to 0.9. With a tail zeta = |ln e|/sqrt(pi^2 + ln^2 e) gives e with
    eta_n = 2 sqrt(5/6) zeta sqrt(m* k_n) (Antypov and Elliott, EPL 94, 50004 (2011)); 0 where that
    dashpot is above critical damping.
    """
    if restitution == 1.0:
        return 1.0
    exponent = sum(h * restitution**n for n, h in enumerate(FIT, 1))
    gamma = math.sqrt(1.0 / (1.0 - (1.0 + restitution) ** 2 * math.exp(exponent)) - 1.0)
    return restitution_unclipped(math.sqrt(1.2) * gamma)


# ---- engines against one another


class Pair(NamedTuple):
    """A comparison: an engine under the law of another one, or None, and its partner."""

    runner: Engine
    law: StatedLaw | None
    partner: Engine
    kind: Kind
    check: str
    note: str = ""


def comparisons(case: BulkCase[Any], engines: Sequence[Engine]) -> Iterator[tuple[Engine, Check]]:
    """Yield the comparisons of every two engines in every setup that both can run."""
    for setup in case.setups:
        p = setup.runs[0]
        law = bulk_law(p.poisson_ratio, getattr(p, "rolling_friction", 0.0))
        able = [(e, stated_law(e, law)) for e in engines if not e.refuses(case.job(p))]
        for first, other in combinations(able, 2):
            level = setup.level_in(first[0], other[0])
            for pair in _pairs(*first, *other):
                if pair.law is None or not pair.runner.refuses(case.job(p, pair.law)):
                    for check in _ratio_checks(case, setup, pair):
                        yield pair.runner, replace(check, level=level)


def _pairs(first: Engine, law: StatedLaw, second: Engine, other: StatedLaw) -> Iterator[Pair]:
    """Yield the comparisons of two engines, each under its own law, and both under one."""
    over = f"over {second.title}"
    if law == other:
        yield Pair(first, None, second, Kind.CROSS_CODE, over)
        return
    both = f"{first.title}: {law.text}; {second.title}: {other.text}"
    yield Pair(first, None, second, Kind.FINDING, over, both)
    if law.rules == other.rules:
        return
    effect = "effect of the rules in one code; its sign is not predicted"
    for runner, partner, theirs in ((first, second, other), (second, first, law)):
        rules = f"the rules of {partner.title}"
        kind = Kind.FINDING if theirs.lacks else Kind.CROSS_CODE
        lacks = f"{partner.title} {theirs.lacks}" if theirs.lacks else ""
        yield Pair(runner, theirs, partner, kind, f"under {rules}, over {partner.title}", lacks)
        yield Pair(runner, theirs, runner, Kind.FINDING, rules, effect)


def _ratio_checks(case: BulkCase[Any], setup: Setup[Bed], pair: Pair) -> Iterator[Check]:
    """Yield the ratio of means of each compared quantity, and Fisher's test of lost runs."""

    def samples(bench: Bench) -> tuple[Sample, Sample]:
        second = bench.others.get(pair.partner.name, bench)
        return case.sample(bench, setup, pair.law), case.sample(second, setup)

    def ratio(quantity: str, bench: Bench) -> Value:
        decided = [sample.decided() for sample in samples(bench)]
        for sample, engine in zip(decided, (pair.runner, pair.partner), strict=True):
            sample.check_spread(engine.title)
        return ratio_of_means(*(sample.values(quantity) for sample in decided))

    row = partial(
        Check, setup=setup.name, unit="1", expected=1.0, kind=pair.kind, check=pair.check,
        note=pair.note, jobs=[case.job(p, pair.law) for p in setup.runs],
    )  # fmt: skip
    if setup.runs[0].LEAVING and setup.compared:
        yield row(
            quantity="runs_without_value", tolerance=BY_CHANCE,
            measure=lambda bench: same_shares(*samples(bench)),
        )  # fmt: skip
    tolerance = EQUIVALENT if pair.kind is Kind.CROSS_CODE else Tolerance()
    for name in setup.compared:
        yield row(quantity=name, measure=partial(ratio, name), tolerance=tolerance)
