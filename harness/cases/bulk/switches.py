"""How known defects of LAMMPS are switched on and off in the scripts of the bulk cases.

A :class:`Switch` has two variants of a script that differ in the defect alone: ``off`` is the law,
``on`` the same numbers in the words that have the defect. Where its cause says to what law the
defect amounts, ``predicted`` is that law in words that are right.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.cases.bulk.materials import Sphere
from harness.cases.registry import get_case
from harness.parameters.rules import Rules
from harness.solvers.pair.normal import coefficient
from harness.store.baseline import known_defects
from harness.theory.contact import damping_ratio, restitution_unclipped

if TYPE_CHECKING:
    from harness.comparison.known_defects import Prediction
    from harness.engines.contract import Value

CHEAPER: Mapping[str, Mapping[str, float]] = {
    "silo": {"layers": 14},
    "heap": {"length": 12, "layers": 20},
    "penetration": {"youngs_modulus": 1e6, "steel_youngs_modulus": 2.1e8, "step_size": 1.5e-5},
}
"""Parameters that are not the defaults: fewer grains of the silo (840) and of the heap (560), and
grains and sphere of the penetration that are ten times softer, so that a third of the steps do.
"""

SLOPE = 0.01
"""Overlap over radius at which linear springs and dashpots are those of Hertz's law."""

OLDEST = "2022.6.23.4.0"


@dataclass(frozen=True)
class Variant:
    """A way to run a case: values of its script, lines of it that are replaced, a release.

    ``replaced`` are patterns that match once in the script
    (:class:`~harness.engines.scripts.ScriptSource`).
    """

    values: Mapping[str, Value] = field(default_factory=dict)
    replaced: Mapping[str, str] = field(default_factory=dict)
    release: str = ""

    def __or__(self, other: Variant) -> Variant:
        """Return both together; the second has precedence."""
        return Variant(
            {**self.values, **other.values},
            {**self.replaced, **other.replaced},
            other.release or self.release,
        )


@dataclass(frozen=True)
class Switch:
    """A known defect that is switched in a case: its words, those of the law, the variants.

    ``cause`` says to what law the defect amounts. Where ``exact``, the motions of ``on`` and
    ``predicted`` are the same to round-off: a test holds them against one another, and no seeds are
    spent on it. The defect without a name is none: its two variants are the same law.
    """

    defect: str
    case: str
    words: str
    words_off: str
    off: Variant
    on: Variant
    predicted: Variant | None = None
    cause: str = ""
    exact: bool = False


def default(case: str) -> Any:
    """Return the parameters of a case in this study."""
    return get_case(case).default.replace(**CHEAPER.get(case, {}))


def switches() -> Iterator[Switch]:
    """Yield all switches."""
    for case in ("silo", "drum", "penetration"):
        yield tsuji(case)
    yield from mixing()
    yield from walls()
    yield classic()
    yield moduli()
    yield from turned_round()


# ---- coefficients ------------------------------------------------------------------------


def of_both(first: float, second: float) -> float:
    """Return E12 [Pa], which given for both of one Poisson's ratio has E* and G* of the pair."""
    return 2.0 * first * second / (first + second)


def hertz(modulus: float, poisson_ratio: float) -> float:
    """Return 4/3 E* [Pa] of two bodies of one material."""
    return 2.0 / 3.0 * modulus / (1.0 - poisson_ratio**2)


def mindlin(modulus: float, poisson_ratio: float) -> float:
    """Return 8 G* [Pa] of two bodies of one material."""
    return 2.0 * modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))


def linear(modulus: float, poisson_ratio: float, radius: float) -> float:
    """Return the slope of Hertz's law [N/m] at an overlap of :data:`SLOPE` effective radii.

    F = 4/3 E* sqrt(R) overlap^(3/2) has the slope 2 E* sqrt(R overlap).
    """
    return 1.5 * hertz(modulus, poisson_ratio) * radius * math.sqrt(SLOPE)


def dashpot(restitution: float, stiffness: float, mass: float) -> float:
    """Return eta/m [1/s] of a linear spring with this restitution: 2 zeta sqrt(k/m)."""
    return 2.0 * damping_ratio(restitution) * math.sqrt(stiffness / mass)


def predicts(defect: str) -> Prediction:
    """Return what the cause of a known defect predicts."""
    (known,) = [entry for entry in known_defects() if entry.name == defect]
    return known.predicts


def tsuji_restitution(restitution: float) -> float:
    """Return what ``damping tsuji`` of LAMMPS makes of a restitution.

    Its dashpot is alpha(e) sqrt(m* F/overlap), m* in place of 2 m*. Constant restitution e' has
    sqrt(5) zeta for alpha, zeta = -ln e'/sqrt(pi^2 + ln^2 e') (Antypov and Elliott, EPL 94, 50004
    (2011)).
    """
    from harness.parameters.law import ContactLaw

    law = ContactLaw(
        normal="hertz",
        youngs_modulus=1.0,
        poisson_ratio=0.2,
        damping="tsuji",
        restitution=restitution,
    )
    alpha = coefficient(law, Rules(**predicts("tsuji-restitution").rules))
    return restitution_unclipped(alpha / math.sqrt(5.0))


def mixed_shear_factor(first: float, second: float, poisson_ratio: float) -> float:
    """Return what the cause of mixed-tangential-stiffness makes of k_t, for two moduli [Pa]."""
    from harness.cases.contact.predictions import as_the_defect_makes_it
    from harness.parameters.law import ContactLaw
    from harness.parameters.scene import Body, ContactScene

    law = ContactLaw(
        normal="hertz",
        youngs_modulus=first,
        poisson_ratio=poisson_ratio,
        partner_youngs_modulus=second,
        partner_poisson_ratio=poisson_ratio,
        tangential="mindlin",
        friction=0.3,
    )
    bodies = (Body(1.0, 1.0, (0.0, 0.0, 0.0)), Body(1.0, 1.0, (0.0, 0.0, 2.0)))
    scene = ContactScene(bodies, (), law, 1.0, 1)
    prediction = predicts("mixed-tangential-stiffness")
    return as_the_defect_makes_it(scene, Rules(), prediction)[1].shear_factor


def number(value: float) -> str:
    """Return a number in full."""
    return f"{value:.17g}"


# ---- between grains ------------------------------------------------------------------------


def tsuji(case: str) -> Switch:
    """Return the dashpot of Tsuji; it amounts to another restitution."""
    p = default(case)
    names = [name for name in type(p).model_fields if name.endswith("restitution")]
    made = {name: tsuji_restitution(getattr(p, name)) for name in names}
    pairs = sorted({(getattr(p, name), made[name]) for name in names})
    return Switch(
        "tsuji-restitution",
        case,
        "damping tsuji",
        "damping coeff_restitution",
        Variant(),
        Variant({"damping": "tsuji"}),
        Variant(made),
        "restitution " + ", ".join(f"{e:.3f} for {given:g}" for given, e in pairs),
        exact=True,
    )


def mixing() -> Iterator[Switch]:
    """Yield two types that LAMMPS mixes: moduli as E*, other coefficients by the geometric mean."""
    p = default("drum")
    yield _mixed(
        "drum",
        "1 2",
        (p.large_youngs_modulus, p.small_youngs_modulus),
        math.sqrt(p.large_restitution * p.small_restitution),
        math.sqrt(p.large_friction * p.small_friction),
    )
    p = default("penetration")
    yield _mixed(
        "penetration",
        "1 2*3",
        (p.youngs_modulus, p.steel_youngs_modulus),
        math.sqrt(p.restitution * p.steel_restitution),
        math.sqrt(p.friction * p.steel_friction),
    )


def _mixed(
    case: str, types: str, moduli: tuple[float, float], restitution: float, friction: float
) -> Switch:
    nu = default(case).poisson_ratio
    factor = mixed_shear_factor(*moduli, nu)
    modulus = of_both(*moduli)

    def stated(shear: str) -> str:
        return (
            f"pair_coeff {types} hertz/material {number(modulus)} {number(restitution)} {nu} "
            f"tangential mindlin {shear} 0 {number(friction)} damping coeff_restitution"
        )

    line = rf"^pair_coeff {types.replace('*', '[*]')} .*$"
    return Switch(
        "mixed-tangential-stiffness",
        case,
        "large and small mixed" if case == "drum" else "sphere and grains mixed",
        "stated",
        Variant(replaced={line: stated("NULL")}),
        Variant(replaced={line: ""}),
        Variant(replaced={line: stated(number(factor * mindlin(modulus, nu)))}),
        f"k_t {factor:.4f} of Mindlin's between the two",
        exact=True,
    )


def silo_pairs(law: str) -> Variant:
    """Return grains of the silo with a law of their own."""
    return Variant(replaced={r"^pair_coeff \* \* .*$": f"pair_coeff * * {law}"})


def classic() -> Switch:
    """Return mindlin_classic between grains of the silo."""
    p = default("silo")
    normal = f"hertz/material {p.youngs_modulus} {p.restitution} {p.poisson_ratio}"
    k_t = number(mindlin(p.youngs_modulus, p.poisson_ratio))
    on, predicted = (
        silo_pairs(f"{normal} tangential {shear} {k_t} 0 {mu} damping coeff_restitution")
        for shear, mu in (("mindlin_classic", p.friction), ("mindlin", 0.5 * p.friction))
    )
    return Switch(
        "classic-cap-without-radius",
        "silo",
        "mindlin_classic of grains",
        "mindlin",
        Variant(),
        on,
        predicted,
        "half the friction between grains, as of contacts that slide",
    )


def rolling(grain: Sphere) -> Variant:
    """Return rolling resistance in every contact: mu_r = 0.2, 0.3 of the critical dashpot."""
    k = linear(grain.youngs_modulus, grain.poisson_ratio, grain.radius)
    eta = 0.6 * math.sqrt(k * grain.mass)
    return Variant({"damping": f"coeff_restitution rolling sds {number(k)} {number(eta)} 0.2"})


def turned_round() -> Iterator[Switch]:
    """Yield rolling that is turned round by sorting and by newton on; sorting without rolling.

    Sorting once in 1000 steps and newton on are LAMMPS's defaults.
    """
    line = r"^atom_modify map array( sort 0 0)?$"
    never, often = (
        Variant(replaced={line: f"atom_modify map array{words}"})
        for words in (" sort 0 0", " sort 1000 0")
    )
    newton = Variant(replaced={r"^newton off$": "newton on"})
    name, off = "rolling-turned-round-by-defaults", "sort 0 0, newton off"
    laws = {
        "silo": rolling(default("silo").grain),
        "drum": rolling(default("drum").small),
        "heap": Variant(),
    }
    for case, law in laws.items():
        yield Switch(
            name, case, "rolling, sort 1000, newton on", off, law | never, law | often | newton
        )
        if case == "silo":
            yield Switch(name, case, "rolling, sort 1000", off, law | never, law | often)
    yield Switch("", "silo", "sort 1000 without rolling", "sort 0 0", never, Variant())


# ---- walls -----------------------------------------------------------------------------------


def silo_walls(law: str) -> Variant:
    """Return shaft, cone and floor of the silo with a law of their own."""
    return Variant(
        replaced={
            rf"^(fix {wall} all wall/gran\S*) granular .* ((?:region|zplane) .*)$": rf"\1 {law} \2"
            for wall in ("shaft", "cone", "floor")
        }
    )


def drum_walls(laws: Mapping[str, str]) -> Variant:
    """Return the drum with a law for large and for small grains."""
    return Variant(
        replaced={
            rf"^(fix drum_of_{kind} {kind} wall/gran/region) granular .* (region drum)$": (
                rf"\1 {law} \2"
            )
            for kind, law in laws.items()
        }
    )


HOOKE = "granular hooke {k} {gamma} damping mass_velocity tangential linear_history {kt} 0"
LINEAR_WALLS = f"{HOOKE} {{mu}}", "hooke/history {k} {kt} {gamma} 0 {mu} 1", f"{HOOKE} 0"
HERTZ_WALLS = (
    "granular hertz {kn} {gamma} tangential mindlin {kt} 0 {mu} damping viscoelastic",
    "hertz/history {kn} {kt} {gamma} 0 {mu} 1",
    "granular hertz {kn} {gamma} tangential mindlin {kt} 0 {half} damping viscoelastic",
)
MATERIAL = (
    "granular hertz/material {E} {gamma} {nu} tangential mindlin NULL 0 {mu} damping viscoelastic"
)


def linear_wall(p: Any, grain: Sphere, words: str) -> str:
    """Return a wall with linear springs, k_t = 2/7 k_n."""
    modulus = of_both(grain.youngs_modulus, p.steel_youngs_modulus)
    k = linear(modulus, p.poisson_ratio, grain.radius)
    gamma = dashpot(p.steel_restitution, k, grain.mass)
    numbers = {"k": k, "kt": 2.0 / 7.0 * k, "gamma": gamma}
    return words.format(**{n: number(x) for n, x in numbers.items()}, mu=p.steel_friction)


def hertz_wall(p: Any, grain: Sphere, words: str) -> str:
    """Return a wall with Hertz's spring.

    Its viscoelastic dashpot, gamma times mass and radius of the contact, is that of the restitution
    at an overlap of :data:`SLOPE` radii.
    """
    modulus, nu = of_both(grain.youngs_modulus, p.steel_youngs_modulus), p.poisson_ratio
    slope = linear(modulus, nu, grain.radius)
    numbers = {
        "E": modulus,
        "kn": hertz(modulus, nu),
        "kt": mindlin(modulus, nu),
        "gamma": dashpot(p.steel_restitution, slope, grain.mass)
        / (grain.radius * math.sqrt(SLOPE)),
        "nu": nu,
    }
    mu = p.steel_friction
    return words.format(**{n: number(x) for n, x in numbers.items()}, mu=mu, half=0.5 * mu)


def walls() -> Iterator[Switch]:
    """Yield the old styles of walls."""
    name, words, off = "old-wall-friction", "walls hooke/history", "walls granular, the same law"
    p = default("silo")
    right, on, predicted = (silo_walls(linear_wall(p, p.grain, law)) for law in LINEAR_WALLS)
    yield Switch(name, "silo", words, off, right, on, predicted, "walls without friction")
    drum = default("drum")
    kinds = {"large": drum.large, "small": drum.small}
    # grains slide on the drum for long, in which a weak spring grows: no limit is predicted there
    right, on = (
        drum_walls({kind: linear_wall(drum, grain, law) for kind, grain in kinds.items()})
        for law in LINEAR_WALLS[:2]
    )
    yield Switch(name, "drum", words, off, right, on)
    name, words = "old-wall-cap-without-radius", "walls hertz/history"
    right, on, predicted = (silo_walls(hertz_wall(p, p.grain, law)) for law in HERTZ_WALLS)
    cause = "half the friction at walls, as of contacts that slide"
    yield Switch(name, "silo", words, off, right, on, predicted, cause)


def moduli() -> Switch:
    """Return walls of 23 Jun 2022, which take wrong moduli from a material, and k_n, k_t as told.

    That release has no coeff_restitution: its grains have a viscoelastic dashpot, of two bodies.
    """
    p = default("silo")
    nu, half = p.poisson_ratio, 0.5 * p.grain.radius
    slope = linear(p.youngs_modulus, nu, half)
    gamma = dashpot(p.restitution, slope, 0.5 * p.grain.mass) / (half * math.sqrt(SLOPE))
    k_n, k_t = hertz(p.youngs_modulus, nu), mindlin(p.youngs_modulus, nu)
    shear = f"tangential mindlin {number(k_t)} 0 {p.friction}"
    # the value names a dashpot of that release; the lines that are replaced state their own
    old = Variant({"damping": "viscoelastic"}, release=OLDEST)
    old |= silo_pairs(f"hertz {number(k_n)} {number(gamma)} {shear} damping viscoelastic")
    return Switch(
        "wall-youngs-modulus",
        "silo",
        "walls by material in 23 Jun 2022",
        "walls of stated k_n, k_t in 23 Jun 2022",
        old | silo_walls(hertz_wall(p, p.grain, HERTZ_WALLS[0])),
        old | silo_walls(hertz_wall(p, p.grain, MATERIAL)),
    )
