"""By which rules a code follows the bulk cases' law, and that law under the rules of another.

The law is Hertz's with a dashpot for the restitution, Mindlin's without one, Coulomb's. Codes take
its tangential spring and the tail of its dashpot in their own ways, which they declare with the
contact models of pairs. Where two codes' ways differ, means that differ are no fault of either; a
code that can state the other's rules is run under these as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING

from harness.comparison.verdicts import Check, Kind, Verdict, finding
from harness.engines.traits import ContactModel, Traits, stating
from harness.parameters.allowed import Allowed
from harness.theory.contact import restitution_unclipped

if TYPE_CHECKING:
    from harness.engines.contract import Value, Values

SPRINGS = {
    "mindlin": "a displacement, times the stiffness of the overlap as it is",
    "mindlin/force": "a force that grows by increments",
    "mindlin_rescale/force": "a force that grows by increments and shrinks with the overlap",
}
"""Tangential springs, in the order of preference: the first is that of the scripts of LAMMPS."""

ALLOWED = {
    "tangential": Allowed(words=tuple(SPRINGS)),
    "tangential_damping": Allowed(bounds={"minimum": 0}),
    "clipped": Allowed(words=("yes", "no")),
}
"""What the values of a law may be in scripts that are run by hand."""

PAIR: Mapping[str, Value] = {
    "normal": "hertz",
    "poisson_ratio": 0.2,
    "tangential_damping": 0.0,
    "friction": 0.3,
    "rolling": "none",
    "twisting": "none",
    "interface": "current",
    "motion_1": "free",
    "planes": 0,
}
"""Two grains, by the names of values of contact jobs."""

NEUTRAL: Mapping[str, Value] = {"rolling_friction": 0.0}
"""Values of jobs that say nothing, for scripts without rolling."""

FIT = (
    *(-6.918798, -16.41105, 146.8049, -796.4559, 2928.711),
    *(-7206.864, 11494.29, -11342.18, 6276.757, -1489.915),
)
"""h_1 to h_10 of Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013), B6."""


def damping_without_tail(restitution: float) -> float:
    """Return gamma of eta_n = 2 gamma sqrt(m* k_n), k_n = 2 E* a, that gives a restitution [-].

    Of Hertz's spring whose force is never attractive, by the fit of Thornton and others (B6), which
    Yade and Kratos take: the restitution is met to 3e-4 up to 0.9.
    """
    exponent = sum(h * restitution**n for n, h in enumerate(FIT, 1))
    return math.sqrt(1.0 / (1.0 - (1.0 + restitution) ** 2 * math.exp(exponent)) - 1.0)


def with_tail(restitution: float) -> float:
    """Return the restitution with a tail of the dashpot that gives one without [-].

    With a tail zeta = |ln e|/sqrt(pi^2 + ln^2 e) gives e with eta_n = 2 sqrt(5/6) zeta sqrt(m* k_n)
    (Antypov and Elliott, EPL 94, 50004 (2011)); 0 where that dashpot is above critical damping.
    """
    if restitution == 1.0:
        return 1.0
    return restitution_unclipped(math.sqrt(1.2) * damping_without_tail(restitution))


@dataclass(frozen=True)
class Law:
    """The rules by which an engine follows the law, in ``words``: equal for equal rules.

    ``values`` state them in scripts that can, and are empty where none does; ``inexact`` is what
    they leave out, in the engine's words, empty where they state all.
    """

    words: str = ""
    values: Mapping[str, Value] = field(default_factory=dict)
    inexact: str = ""

    def stated(self, values: Values) -> Values:
        """Return the values of a job under these rules.

        Without a tail a restitution becomes the one that the same dashpot has with a tail.
        """
        changed = {**values, **self.values}
        if self.values.get("clipped") == "yes":
            for name in values:
                if name.endswith("restitution"):
                    changed[name] = with_tail(float(values[name]))
        return changed


def law_of(traits: Traits, rolling_friction: float = 0.0) -> Law:
    """Return by which rules an engine follows the law, with resistance to rolling those of it too.

    No script states the spring of rolling of another code: with it there are no values.

    Of an engine that states no dashpot beside tangential springs without one, the values are those
    that its model puts in their place, and its words say what these leave out.
    """
    if rolling_friction > 0.0:
        law = law_of(traits)
        return replace(law, words=f"{law.words}; {rolling_of(traits)}", values={})
    for spring, words in SPRINGS.items():
        for clipped, tail in (("no", "attracts"), ("yes", "never attracts")):
            values: dict[str, Value] = {"tangential": spring, "clipped": clipped}
            if not _lack(traits, {**values, "damping": "coeff_restitution"})[1]:
                text = f"the tangential spring is {words}; the dashpot {tail}"
                return Law(text, {**values, "tangential_damping": 0.0})
    for spring, words in SPRINGS.items():
        values = {"tangential": spring, "clipped": "yes"}
        if not _lack(traits, {**values, "damping": "none"})[1]:
            model, why = _lack(traits, {**values, "damping": "coeff_restitution"})
            more = model.nearest({**PAIR, **values}) if model.nearest else {}
            return Law(f"the tangential spring is {words}; {why}", {**values, **more}, why)
    return Law()


def rolling_of(traits: Traits) -> str:
    """Return what the spring of rolling is in an engine: what its contact models declare."""
    words = product(("no", "yes"), SPRINGS)
    tails: Iterator[Mapping[str, Value]] = (
        {"clipped": clipped, "tangential": spring} for clipped, spring in words
    )
    law: dict[str, Value] = {**PAIR, "damping": "coeff_restitution", "rolling": "sds"}
    law |= {"rolling_stiffness": 1.0, "rolling_damping": 0.0, "rolling_friction": 0.1}
    if any(not stating(traits.contact_models, law | dict(tail))[1] for tail in tails):
        return "the rolling spring is of one stiffness for all overlaps"
    own = "the code's own, as stiff as the tangential spring of the overlap as it is"
    return f"the rolling spring is {own}"


def _lack(traits: Traits, choice: Values) -> tuple[ContactModel, str]:
    """Return the model that states two grains under a choice, or the closest, and why not."""
    return stating(traits.contact_models, {**PAIR, **choice})


def differing(check: Check, title: str, first: Law, second_title: str, second: Law) -> Check:
    """Return a comparison of two engines; a failure between different laws as a finding.

    That there is no ratio is no matter of laws: it stays a failure.
    """
    if first.words == second.words:
        return check
    note = f"{check.note}; {title}: {first.words}; {second_title}: {second.words}"
    if check.verdict is not Verdict.FAIL or not math.isfinite(check.value):
        return replace(check, note=note)
    assert check.kind is Kind.CROSS_CODE
    return finding(check.name, check.value, 1.0, "", note, uncertainty=check.uncertainty)
