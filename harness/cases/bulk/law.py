"""The contact law of bulk jobs, and the same law under the rules of a code.

The law is Hertz's with a dashpot for the restitution, Mindlin's without one, Coulomb's. Codes take
its tangential spring and the tail of its dashpot in their own ways: the law of an engine
is the nearest one for which :meth:`harness.engines.base.Engine.rules` raises nothing. Where two
codes have different laws, a difference of means is no fault of either. A code whose scripts take
these rules as values also runs under the rules of another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from harness.engines.base import Engine, Value, Values
from harness.errors import Unsupported
from harness.model.allowed import Allowed
from harness.model.law import Law
from harness.model.scene import Scene, sphere
from harness.theory.contact import restitution_unclipped

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
    def rules(self) -> dict[str, Value]:
        """Return the values of scripts for the rules of the law."""
        return {
            "tangential": self.law.tangential,
            "clipped": "yes" if self.law.clipped else "no",
            "tangential_damping": self.law.tangential_damping or 0.0,
        }

    def values(self, values: Values) -> dict[str, Value]:
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
    """Return the law of an engine for a bulk law: the first of those near to it that it has."""
    for near, part in _near(law):
        if not (reason := _refusal(engine, part)):
            return StatedLaw(near, _refusal(engine, near))
    return StatedLaw(law, f"its rules are not known: {reason}")


def _near(law: Law) -> Iterator[tuple[Law, Law]]:
    """Yield laws, the nearest first, each with the part of it that an engine must have.

    That part is the law as a whole, then without rolling, then without dashpots: a code whose
    tangential dashpot is tied to the normal one has the same share of critical damping in both.
    """
    kinds = product(SPRINGS, (False, True))
    springs = [law.replace(tangential=spring, clipped=clipped) for spring, clipped in kinds]
    yield from ((near, near) for near in springs)
    yield from ((near, near.replace(rolling="none")) for near in springs)
    nu = law.poisson_ratio or 0.0
    tied = math.sqrt(2.0 * (1.0 - nu) / (2.0 - nu))  # sqrt(k_t/k_n) of Mindlin and Hertz
    for near in springs[1::2]:
        bare = near.replace(damping="none", rolling="none")
        yield near.replace(tangential_damping=tied), bare


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
