"""How known defects of LAMMPS are switched on and off in the scripts of the bulk cases.

A :class:`Switch` has two variants of a script that differ in the defect alone: ``off`` is the law,
``on`` the same numbers in the words that have the defect. Where its cause says to what law the
defect amounts, ``predicted`` is that law in words that are right.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
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

OLDEST, OLDER = "2022.6.23.4.0", "2023.8.2.3.1"


@dataclass(frozen=True)
class Variant:
    """A way to run a case: values of its script, lines of it that are replaced, a release, ranks.

    ``replaced`` are patterns that match once in the script
    (:class:`~harness.engines.scripts.ScriptSource`).
    """

    values: Mapping[str, Value] = field(default_factory=dict)
    replaced: Mapping[str, str] = field(default_factory=dict)
    release: str = ""
    ranks: int = 1

    def __or__(self, other: Variant) -> Variant:
        """Return both together; the second has precedence."""
        return Variant(
            {**self.values, **other.values},
            {**self.replaced, **other.replaced},
            other.release or self.release,
            max(self.ranks, other.ranks),
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
    for case in ("silo", "drum", "penetration", "heap"):
        yield tsuji(case)
    yield from mixing()
    yield from walls()
    yield from classic()
    yield from linear_classic()
    yield from moduli()
    yield from coefficients()
    yield from tsuji_again()
    yield from turned_round()
    yield from exchanged()


NO_RADIUS = "its script does not run in 23 Jun 2022, whose variables have no radius of a particle"
SMOOTH = "its sides have no friction, and its floor is glued grains"

UNSWITCHED: Mapping[tuple[str, str], str] = {
    ("mixed-tangential-stiffness", "silo"): (
        "its grains are of one type and its walls of none: LAMMPS mixes no pair"
    ),
    ("old-wall-friction", "heap"): SMOOTH,
    ("old-wall-cap-without-radius", "heap"): SMOOTH,
    ("old-wall-hooke-coefficients", "heap"): SMOOTH,
    ("wall-youngs-modulus", "penetration"): NO_RADIUS,
    ("wall-youngs-modulus", "heap"): f"{SMOOTH}: the stiffness of sides bears on no slope",
    ("wall-tsuji-again", "penetration"): NO_RADIUS,
    ("wall-tsuji-again", "heap"): f"{SMOOTH}: the dashpot of sides bears on no slope",
}
"""Why a defect, by its name and a case, is not switched there."""


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
    yield _mixed_heap()


def _mixed_heap() -> Switch:
    """Return grains and glued ones as two types of one material, which LAMMPS mixes."""
    p = default("heap")
    nu, modulus = p.poisson_ratio, p.youngs_modulus
    factor = mixed_shear_factor(modulus, modulus, nu)
    shear = f"tangential mindlin {number(factor * mindlin(modulus, nu))} 0 ${{friction}}"
    of_both = (
        f"hertz/material {number(modulus)} ${{restitution}} {nu} {shear} ${{rolling}} "
        "damping ${damping}"
    )
    types = '"pair_coeff 1 1 ${of_grains}" "pair_coeff 2 2 ${of_grains}"'
    on, predicted = (
        Variant(replaced={r"^pair_coeff \* \* .*$": f'if "1 == 1" then {types}{more}'})
        for more in ("", f' "pair_coeff 1 2 {of_both}"')
    )
    return Switch(
        "mixed-tangential-stiffness",
        "heap",
        "grains and glued grains mixed",
        "stated",
        Variant(),
        on,
        predicted,
        f"k_t {factor:.4f} of Mindlin's between the two",
        exact=True,
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


def smaller(case: str) -> Sphere:
    """Return the grains of a case, of the drum its small ones."""
    p = default(case)
    grain: Sphere = p.small if case == "drum" else p.grain
    return grain


def pair_moduli(case: str) -> Mapping[str, float]:
    """Return Young's modulus [Pa] of the pairs of grains, by the string that states their law."""
    p = default(case)
    if case != "drum":
        return {"of_grains": p.youngs_modulus}
    large, small = p.large_youngs_modulus, p.small_youngs_modulus
    return {"of_large": large, "of_small": small, "of_both": of_both(large, small)}


def between_grains(case: str, model: str, stiffness: Callable[[float], float]) -> Variant:
    """Return a case whose grains have another tangential spring, k_t of the modulus of a pair."""
    return Variant(
        replaced={
            rf"^(variable {name} +string .*) \$\{{law\}} (.*)$": (
                rf"\1 tangential {model} {number(stiffness(modulus))} 0 \2"
            )
            for name, modulus in pair_moduli(case).items()
        }
    )


def classic() -> Iterator[Switch]:
    """Yield mindlin_classic between grains."""
    p = default("silo")
    normal = f"hertz/material {p.youngs_modulus} {p.restitution} {p.poisson_ratio}"
    k_t = number(mindlin(p.youngs_modulus, p.poisson_ratio))
    on, predicted = (
        silo_pairs(f"{normal} tangential {shear} {k_t} 0 {mu} damping coeff_restitution")
        for shear, mu in (("mindlin_classic", p.friction), ("mindlin", 0.5 * p.friction))
    )
    name, words, right = "classic-cap-without-radius", "mindlin_classic of grains", "mindlin"
    cause = "half the friction between grains, as of contacts that slide"
    yield Switch(name, "silo", words, right, Variant(), on, predicted, cause)
    for case in ("drum", "penetration", "heap"):
        nu = default(case).poisson_ratio
        on = between_grains(case, "mindlin_classic", partial(mindlin, poisson_ratio=nu))
        yield Switch(name, case, words, right, Variant(), on)


def linear_classic() -> Iterator[Switch]:
    """Yield linear_history_classic between grains, k_t = 2/7 k_n of a linear spring."""
    words, right = "linear_history_classic of grains", "linear_history of grains"
    for case in ("silo", "drum", "penetration", "heap"):
        grain = smaller(case)

        def shear(modulus: float, grain: Sphere = grain) -> float:
            return 2.0 / 7.0 * linear(modulus, grain.poisson_ratio, 0.5 * grain.radius)

        off, on = (
            between_grains(case, model, shear)
            for model in ("linear_history", "linear_history_classic")
        )
        yield Switch("linear-history-classic", case, words, right, off, on)


def rolling(grain: Sphere) -> Variant:
    """Return rolling resistance in every contact: mu_r = 0.2, 0.3 of the critical dashpot."""
    k = linear(grain.youngs_modulus, grain.poisson_ratio, grain.radius)
    eta = 0.6 * math.sqrt(k * grain.mass)
    return Variant({"damping": f"coeff_restitution rolling sds {number(k)} {number(eta)} 0.2"})


def sorting(words: str) -> Variant:
    """Return a script that sorts by these words of atom_modify."""
    return Variant(
        replaced={r"^atom_modify map array( sort 0 0)?$": f"atom_modify map array{words}"}
    )


def rolling_cases() -> Mapping[str, Variant]:
    """Return the cases with rolling resistance; the heap has its own."""
    added = {case: rolling(smaller(case)) for case in ("silo", "drum", "penetration")}
    return {**added, "heap": Variant()}


def turned_round() -> Iterator[Switch]:
    """Yield rolling that is turned round by sorting and by newton on; sorting without rolling.

    Sorting once in 1000 steps and newton on are LAMMPS's defaults.
    """
    never, often = (sorting(words) for words in (" sort 0 0", " sort 1000 0"))
    newton = Variant(replaced={r"^newton off$": "newton on"})
    name, off = "rolling-turned-round-by-defaults", "sort 0 0, newton off"
    for case, law in rolling_cases().items():
        yield Switch(
            name, case, "rolling, sort 1000, newton on", off, law | never, law | often | newton
        )
        if case == "silo":
            yield Switch(name, case, "rolling, sort 1000", off, law | never, law | often)
    yield Switch("", "silo", "sort 1000 without rolling", "sort 0 0", never, Variant())


def exchanged() -> Iterator[Switch]:
    """Yield rolling that is turned round where a contact crosses from rank to rank."""
    name, words, off = "rolling-turned-round-on-exchange", "rolling, 2 ranks", "1 rank"
    for case, law in rolling_cases().items():
        right = law | sorting(" sort 0 0")
        yield Switch(name, case, words, off, right, right | Variant(ranks=2))


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


def box_walls(laws: Mapping[str, str]) -> Variant:
    """Return the box of the penetration with a law for grains and for the sphere."""
    return Variant(
        replaced={
            rf'^(  "fix {axis}_of_{kind} {kind} wall/gran) granular .* ({axis}plane .*)$': (
                rf"\1 {law} \2"
            )
            for kind, law in laws.items()
            for axis in "xyz"
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


TSUJI_WALL = "granular hertz {kn} {e} tangential mindlin {kt} 0 {mu} damping tsuji"
DASHPOT_WALLS = (
    "granular hooke {k} {gamma} damping mass_velocity tangential linear_nohistory 0.5 {mu}",
    "hooke {k} 0 {gamma} {half_gamma} {mu} 1",
    "granular hooke {k} {gamma} damping mass_velocity tangential linear_nohistory 0 0.5",
)
"""Half the dashpot along the wall; the defect takes K_t, 0, for this ratio, and it for mu."""


def linear_wall(p: Any, grain: Sphere, words: str) -> str:
    """Return a wall with linear springs, k_t = 2/7 k_n."""
    modulus = of_both(grain.youngs_modulus, p.steel_youngs_modulus)
    k = linear(modulus, p.poisson_ratio, grain.radius)
    gamma = dashpot(p.steel_restitution, k, grain.mass)
    numbers = {"k": k, "kt": 2.0 / 7.0 * k, "gamma": gamma, "half_gamma": 0.5 * gamma}
    return words.format(**{n: number(x) for n, x in numbers.items()}, mu=p.steel_friction)


def hertz_wall(p: Any, grain: Sphere, words: str) -> str:
    """Return a wall with Hertz's spring.

    Its viscoelastic dashpot, gamma times mass and radius of the contact, is that of the restitution
    at an overlap of :data:`SLOPE` radii.
    """
    modulus, nu = of_both(grain.youngs_modulus, p.steel_youngs_modulus), p.poisson_ratio
    numbers = {
        "E": modulus,
        "kn": hertz(modulus, nu),
        "kt": mindlin(modulus, nu),
        "gamma": viscous(p.steel_restitution, modulus, nu, grain.radius, grain.mass),
        "nu": nu,
        "e": p.steel_restitution,
    }
    mu = p.steel_friction
    return words.format(**{n: number(x) for n, x in numbers.items()}, mu=mu, half=0.5 * mu)


def walled(case: str, law: Callable[[Any, Sphere, str], str], words: str) -> Variant:
    """Return a case whose walls have a law of these words, for each kind of spheres."""
    p = default(case)
    if case == "silo":
        return silo_walls(law(p, p.grain, words))
    if case == "drum":
        return drum_walls({"large": law(p, p.large, words), "small": law(p, p.small, words)})
    laws = {"grains": law(p, p.grain, words), "sphere": law(p, p.steel, words)}
    return box_walls(laws)


def walls() -> Iterator[Switch]:
    """Yield the old styles of walls."""
    name, words, off = "old-wall-friction", "walls hooke/history", "walls granular, the same law"
    for case in ("silo", "drum", "penetration"):
        right, on, predicted = (walled(case, linear_wall, law) for law in LINEAR_WALLS)
        # grains slide on the drum for long, in which a weak spring grows, and in the penetration
        # hardly at all: no limit is predicted there
        limit = (predicted, "walls without friction") if case == "silo" else ()
        yield Switch(name, case, words, off, right, on, *limit)
    name, words = "old-wall-cap-without-radius", "walls hertz/history"
    for case in ("silo", "drum", "penetration"):
        right, on, predicted = (walled(case, hertz_wall, law) for law in HERTZ_WALLS)
        cause = "half the friction at walls, as of contacts that slide"
        limit = (predicted, cause) if case == "silo" else ()
        yield Switch(name, case, words, off, right, on, *limit)


# ---- releases ----------------------------------------------------------------------------------


def viscous(
    restitution: float, modulus: float, poisson_ratio: float, radius: float, mass: float
) -> float:
    """Return gamma of a viscoelastic dashpot, gamma times mass and radius of the contact.

    That of the restitution at an overlap of :data:`SLOPE` radii; ``radius`` and ``mass`` are the
    effective ones of two bodies.
    """
    slope = linear(modulus, poisson_ratio, radius)
    return dashpot(restitution, slope, mass) / (radius * math.sqrt(SLOPE))


def without_restitution(case: str, release: str) -> Variant:
    """Return a case in a release without coeff_restitution: pairs have a viscoelastic dashpot."""
    p = default(case)
    # the value names a dashpot of that release; the lines that are replaced state their own
    old = Variant({"damping": "viscoelastic"}, release=release)
    if case == "silo":
        grain, nu = p.grain, p.poisson_ratio
        k_n, k_t = hertz(p.youngs_modulus, nu), mindlin(p.youngs_modulus, nu)
        gamma = viscous(p.restitution, p.youngs_modulus, nu, 0.5 * grain.radius, 0.5 * grain.mass)
        shear = f"tangential mindlin {number(k_t)} 0 {p.friction}"
        return old | silo_pairs(f"hertz {number(k_n)} {number(gamma)} {shear} damping viscoelastic")
    if case == "drum":
        bodies = {"of_large": (p.large, p.large), "of_small": (p.small, p.small)}
        bodies["of_both"] = (p.large, p.small)
        restitutions = [p.large_restitution, p.small_restitution, p.mixed_restitution]
    else:
        bodies = {"of_grains": (p.grain, p.grain), "of_both": (p.grain, p.steel)}
        restitutions = [p.restitution, p.steel_restitution]
    gammas = (
        viscous(e, of_both(*(b.youngs_modulus for b in two)), p.poisson_ratio, *reduced(*two))
        for e, two in zip(restitutions, bodies.values(), strict=True)
    )
    return old | Variant(
        replaced={
            rf'^(variable {name} +string "hertz/material \S+) \S+ (.*)$': (
                rf"\1 {number(gamma)} \2"
            )
            for name, gamma in zip(bodies, gammas, strict=True)
        }
    )


def reduced(first: Sphere, second: Sphere) -> tuple[float, float]:
    """Return effective radius [m] and mass [kg] of two spheres."""
    radius = 1.0 / (1.0 / first.radius + 1.0 / second.radius)
    return radius, 1.0 / (1.0 / first.mass + 1.0 / second.mass)


def moduli() -> Iterator[Switch]:
    """Yield walls of 23 Jun 2022, which take wrong moduli from a material, and k_n, k_t as told."""
    for case in ("silo", "drum"):
        old = without_restitution(case, OLDEST)
        right, on = (walled(case, hertz_wall, law) for law in (HERTZ_WALLS[0], MATERIAL))
        yield Switch(
            "wall-youngs-modulus",
            case,
            "walls by material in 23 Jun 2022",
            "walls of stated k_n, k_t in 23 Jun 2022",
            old | right,
            old | on,
        )


def coefficients() -> Iterator[Switch]:
    """Yield walls of 2 Aug 2023 without springs, whose coefficients are exchanged."""
    for case in ("silo", "drum", "penetration"):
        old = without_restitution(case, OLDER)
        off, on, predicted = (old | walled(case, linear_wall, law) for law in DASHPOT_WALLS)
        yield Switch(
            "old-wall-hooke-coefficients",
            case,
            "walls hooke in 2 Aug 2023",
            "walls granular in 2 Aug 2023, the same law",
            off,
            on,
            predicted,
            "walls without a tangential dashpot: no friction",
            exact=True,
        )


def tsuji_again() -> Iterator[Switch]:
    """Yield walls with the dashpot of Tsuji, which 23 Jun 2022 changes from run to run."""
    for case in ("silo", "drum"):
        wall = walled(case, hertz_wall, TSUJI_WALL)
        new, old = (without_restitution(case, release) | wall for release in (OLDER, OLDEST))
        yield Switch(
            "wall-tsuji-again",
            case,
            "walls damping tsuji in 23 Jun 2022",
            "the same script in 2 Aug 2023",
            new,
            old,
        )
