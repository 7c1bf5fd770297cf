"""What the cause of a known defect predicts of a row: the law as the defect makes it, integrated.

A failure is excused by a known defect only where it has this size.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from harness.cases.contact.limits import RECORDED, width_of
from harness.cases.contact.motion import Followed, Motion, followed, jumps_at_the_end
from harness.cases.contact.parameters import one_material
from harness.cases.contact.transformations import ROUNDINGS, TransformedRun
from harness.comparison.known_defects import Formula, Prediction
from harness.comparison.verdicts import Check, PredictedSize
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import ContactScene
from harness.parameters.submodels import COEFFICIENTS
from harness.solvers.pair.normal import SWELLING, dashpot, grown, pressed
from harness.solvers.pair.stepping import Departures, NotSteppedError, advance
from harness.solvers.pair.system import effective_moduli, system_of

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase
    from harness.comparison.convergence import Limit

    Limits = Callable[[Sequence[Mapping[str, float]]], Mapping[str, Limit]]


KICK = "rolling_in_setup"
"""The departure that nobody's memory decides: any share of the limit, of either sign."""


@dataclass(frozen=True)
class PredictedValue:
    """Computes the limit of a quantity that known defects predict for a trial in an engine.

    ``levels`` are the parameters of the ladder, ``limits`` extrapolates what its runs leave,
    ``rules`` are those of the engine, and ``row`` is the check of the quantity: its value is as
    uncertain against what a defect predicts.
    """

    case: ContactCase[Any]
    levels: Sequence[Any]
    limits: Limits
    rules: Rules
    quantity: str
    unit: str
    row: Check

    def __call__(self, prediction: Prediction, _: Prediction | None = None) -> PredictedSize:
        """Return the value under the law, the rules and the scheme as the defect makes them."""
        stepped = bool(prediction.scheme)
        value, half = self._by_steps(prediction) if stepped else self._integrated(prediction)
        if not math.isfinite(value):
            return PredictedSize((), "it is not there in the time of the run")
        half = max(half, self.row.tolerance)
        if not stepped:
            # the scheme leaves the same series as the engine, the integration its limit
            half += self.row.uncertainty
        return PredictedSize(((value - half, value + half),))

    def moved(
        self, here: Prediction | None, there: Prediction | None, width: float
    ) -> PredictedSize:
        """Return how far defects of one release move the run of the baseline from that of another.

        By the steps of both, whose tolerance together is ``width``.
        """
        apart = [a - b for a in self._recorded(here) for b in self._recorded(there)]
        return PredictedSize(((min(apart) - width, max(apart) + width),))

    def _recorded(self, prediction: Prediction | None) -> list[float]:
        """Return the value of the run that the baseline records, step by step.

        Of memory that nobody set, which a limit alone bounds, the values at both ends of it.
        """
        recorded = self.levels[0].replace(steps_per_contact=RECORDED)
        predictions = [prediction]
        if prediction is not None and prediction.scheme.get(KICK):
            schemes = [{**prediction.scheme, KICK: share} for share in (-1.0, 1.0)]
            predictions = [prediction.replace(scheme=scheme) for scheme in schemes]
        motions = [self._stepped(recorded, each) for each in predictions]
        return [self.case.observed(recorded, motion)[self.quantity] for motion in motions]

    def _scene_of(self, level: Any, prediction: Prediction | None) -> tuple[ContactScene, Rules]:
        """Return the scene of a level, and the rules in it, as the defect makes them."""
        scene, rules = self.case.scene(level), self.rules
        if prediction is not None:
            scene, rules = as_the_defect_makes_it(scene, rules, prediction)
        return scene, self.case.rules_in_scene(level, rules)

    def _stepped(self, level: Any, prediction: Prediction | None) -> Motion:
        scene, rules = self._scene_of(level, prediction)
        scheme: Mapping[str, Any] = prediction.scheme if prediction else {}
        departures = Departures(**scheme)
        return _advanced(scene, rules, departures)

    def _by_steps(self, prediction: Prediction) -> tuple[float, float]:
        """Return the limit that the scheme leaves on the same ladder: nothing else differs."""
        values = [
            self.case.observed(level, self._stepped(level, prediction)) for level in self.levels
        ]
        reached = self.limits(values).get(self.quantity)
        return (reached.value if reached else math.nan), 0.0

    def _integrated(self, prediction: Prediction) -> tuple[float, float]:
        """Return the value by the integration, and the width that its own kinks and jumps need."""
        finest = self.levels[-1]
        scene, rules = self._scene_of(finest, prediction)
        reached = followed(scene, rules)
        value = self.case.observed(finest, reached.motion)[self.quantity]
        over = math.isfinite(followed(*self._scene_of(finest, None)).ended)
        if over and not math.isfinite(reached.ended):
            value = self._cut_short(prediction)
        kinked = reached.kinked or reached.jumps or jumps_at_the_end(scene, rules)
        # a contact that ends, as that of the law does not, ends at another phase on every level
        kinked = kinked or (math.isfinite(reached.ended) and not over)
        round_off = width_of(
            self.unit,
            kinked=kinked,
            size=self.case.sizes(finest).get(self.quantity, 1.0),
            along_path=bool(scene.segments) and not reached.jumps,
        )
        return value, round_off.width(value)

    def _cut_short(self, prediction: Prediction) -> float:
        """Return the limit where a run ends before the contact, at another time on each level."""
        values = []
        for level in self.levels:
            scene, rules = self._scene_of(level, prediction)
            values.append(self.case.observed(level, followed(scene, rules).motion))
        reached = self.limits(values).get(self.quantity)
        return reached.value if reached else math.nan


ALIKE = 1e-6
"""[size] by which two runs of one scheme differ for their round-off, where they differ at all."""


@dataclass(frozen=True)
class PredictedDifference:
    """Computes the largest difference of two runs that known defects predict.

    ``run`` is the run, ``other`` what it is held against; ``sizes`` are what differences are
    measured in, ``width`` is the row's tolerance, and the forces of the first ``touch`` samples
    are left out.
    """

    run: TransformedRun
    other: TransformedRun
    rules: Rules
    sizes: Mapping[str, float]
    width: float
    touch: int
    difference: Callable[..., Mapping[str, float]]

    def __call__(self, prediction: Prediction, beneath: Prediction | None = None) -> PredictedSize:
        """Return the difference of the runs as the defect makes them, step by step.

        ``beneath`` makes the values of both wrong, whatever is compared.
        """
        half = self.width + ALIKE
        if prediction.bound:
            most, why = BOUNDS[prediction.bound](self)
            return PredictedSize(((0.0, most + half),), why)
        try:
            differences = [
                self._apart(prediction, beneath, at) for at in self._exchanges(prediction)
            ]
        except NotSteppedError:
            if prediction.scheme.get("setup") != "full_step_velocity":
                raise
            most, why = _of_full_step(self)
            return PredictedSize(((0.0, most + half),), why)
        return PredictedSize(
            tuple((max(0.0, low - half), high + half) for low, high in _ranges(differences))
        )

    def _apart(
        self, prediction: Prediction, beneath: Prediction | None, exchanges: tuple[int, ...]
    ) -> float:
        both = prediction if beneath is None else prediction | beneath
        motions = []
        for run, name in ((self.run, "run"), (self.other, "other run")):
            of_run = both if prediction.of in ("both", name) else beneath
            turned = exchanges if run is self.run else ()
            motions.append(run.back(_motion_of_run(run, self.rules, of_run, turned)))
        apart = self.difference(*motions, self.sizes, self.touch)
        return max(apart.values())

    def _exchanges(self, prediction: Prediction) -> Iterator[tuple[int, ...]]:
        """Yield when a contact may be handed over: from each step on of the run's middle.

        The bodies cross a boundary there, one before the other; that of the contact is noticed as
        the neighbours are looked up again.
        """
        if "exchange" not in prediction.scheme:
            yield ()
            return
        steps = self.run.scene.steps
        for at in range(steps // 4, steps - steps // 8):
            yield (at,)


def _ranges(values: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return one number as a range, and several as what lies between the least and the largest."""
    return ((min(values), max(values)),)


def _motion_of_run(
    run: TransformedRun, rules: Rules, prediction: Prediction | None, exchanges: tuple[int, ...]
) -> Motion:
    """Return the motion of a run, step by step, stopped and restarted where it is."""
    values = run.job.values
    stop, go_on = int(values.get("stop_after", 0)), values.get("go_on", "run")

    def departures(**changes: Any) -> Departures:
        if go_on != "restart":
            changes.pop("restart", None)
        if go_on == "restart":
            changes.pop("again", None)
        return Departures(**changes)

    stops = (stop,) if stop and go_on != "continue" else ()
    return _stepped(run.scene, rules, prediction, departures, stops=stops, exchanges=exchanges)


def _stepped(
    scene: ContactScene,
    rules: Rules,
    prediction: Prediction | None,
    departures: Callable[..., Departures],
    **more: Any,
) -> Motion:
    changes = prediction.scheme if prediction else {}
    if prediction is not None:
        scene, rules = as_the_defect_makes_it(scene, rules, prediction)
    return _advanced(scene, rules, departures(**changes), **more)


@lru_cache(maxsize=256)
def _advanced(
    scene: ContactScene,
    rules: Rules,
    departures: Departures,
    stops: tuple[int, ...] = (),
    exchanges: tuple[int, ...] = (),
) -> Motion:
    """Return the motion step by step: one for all quantities of a run, and all held against it."""
    return Motion(*advance(scene, rules, departures, stops=stops, exchanges=exchanges))


def as_the_defect_makes_it(
    scene: ContactScene, rules: Rules, prediction: Prediction
) -> tuple[ContactScene, Rules]:
    """Return a scene and rules with what a defect changes; raise RequestError for a bad formula."""
    names = _names(scene)
    law = {name: _value(formula, names) for name, formula in prediction.law.items()}
    # the words of a rule are no formulas, though one may be spelled as a coefficient or a fraction
    more = {
        name: formula
        if formula in get_args(Rules.model_fields[name].annotation)
        else _value(formula, names)
        for name, formula in prediction.rules.items()
    }
    return (
        replace(scene, law=scene.law.replace(**law)) if law else scene,
        rules.replace(**more) if more else rules,
    )


def _names(scene: ContactScene) -> dict[str, float]:
    """Return the numbers that a formula may name: the coefficients of the law."""
    law = scene.law.model_dump(include=set(COEFFICIENTS), exclude_none=True)
    both = {"poisson_ratio_of_both": one_material(scene.law)[1]} if scene.law.materials else {}
    return {**law, **both}


OPERATORS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


def _value(formula: Formula, names: Mapping[str, float]) -> Any:
    """Return a number, a word as it is, or the value of a formula of names."""
    if not isinstance(formula, str) or (
        formula.replace("_", "").isalnum() and formula not in names
    ):
        return formula
    try:
        tree = ast.parse(formula, mode="eval").body
    except SyntaxError:
        return formula
    try:
        return _evaluated(tree, names)
    except KeyError as error:
        raise RequestError(
            f"{formula!r}: the law has no {error.args[0]} (it has {', '.join(names)})"
        ) from None


def _evaluated(node: ast.expr, names: Mapping[str, float]) -> float:
    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return float(names[name])
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return OPERATORS[type(op)](_evaluated(left, names), _evaluated(right, names))
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_evaluated(operand, names)
    raise RequestError(f"{ast.unparse(node)!r}: must be +, -, *, / and ** of numbers and names")


# ---- bounds, where the cause fixes no number


def _of_full_step(difference: PredictedDifference) -> tuple[float, str]:
    """Return how far a setup with full-step velocities moves a run, to the first order in the step.

    Along the normal a dashpot eta takes the velocity of half a step later, F/m h/2 of it: the force
    is off by eta h / (2 m*) of itself, which kicks for half a step. Friction passes on mu of it.
    """
    scene = difference.run.scene
    path = followed(scene, difference.rules)
    eta = _largest_dashpot(scene, difference.rules, path)
    share = 0.5 * eta * scene.step / float(system_of(scene, difference.rules).contacts[0]["mass"])
    return 2.0 * share * _spread(scene.law), "a force at the velocity half a step later"


def _largest_dashpot(scene: ContactScene, rules: Rules, reached: Followed) -> float:
    """Return the largest normal dashpot of the first contact [kg/s]."""
    system = system_of(scene, rules)
    law, contact = system.law, system.contacts[0]
    radii = sum(body.radius for body in scene.bodies[:2])
    if contact["second"] < 0:
        point, normal = np.array(scene.planes[0].point), np.array(scene.planes[0].direction)
        overlaps = scene.bodies[0].radius - (reached.motion.position[:, 0] - point) @ normal
    else:
        apart = reached.motion.position[:, 0] - reached.motion.position[:, 1]
        overlaps = radii - np.linalg.norm(apart, axis=1)
    deep = float(overlaps.max())
    modulus = law["stiffness"] * (2.0 if contact["second"] < 0 else 1.0)
    elastic = pressed(law, contact, deep)
    kind, factor, mass = law["damping"], law["damping_coefficient"], contact["mass"]
    return float(dashpot(kind, factor, mass, deep, elastic, modulus)[0])


def _spread(law: ContactLaw) -> float:
    """Return what a push along the normal becomes with what friction makes of it: mu, in a spin."""
    return 1.0 + 3.5 * (law.friction or 0.0)


def _uninitialised_rolling(difference: PredictedDifference) -> tuple[float, str]:
    """Return what any torque up to the limit of rolling leaves in the setup, for half a step.

    mu_r R* F_n is the torque of the first sample; of 2/5 m r^2 it makes a spin, and the spring
    of rolling what this turns in the rest of the run at most. Each of the two runs has its own.
    """
    scene, law = difference.run.scene, difference.run.scene.law
    body, mu = scene.bodies[0], law.rolling_friction or 0.0
    torque = mu * body.radius * difference.sizes["force"]
    spin = 0.5 * scene.step * torque / body.inertia
    turned = (law.rolling_stiffness or 0.0) * body.radius**2 * spin * scene.duration
    most = max(
        (torque + min(turned, torque)) / difference.sizes["torque"],
        spin / difference.sizes["omega"],
        spin * body.radius / difference.sizes["velocity"],
        spin * body.radius * scene.duration / difference.sizes["position"],
    )
    return 2.0 * most, "any torque up to the limit of rolling, for half a step"


def _radius_of_the_step_before(difference: PredictedDifference) -> tuple[float, str]:
    """Return what a radius that is late by a step leaves: its growth times the slope of the force.

    In a step the force is off by that; summed up over the contact, the velocity by the slope times
    the whole growth for a step. Where it springs back the slope is that of the elastic dent.
    """
    scene = difference.run.scene
    system = system_of(scene, difference.rules)
    law, contact = system.law, system.contacts[0]
    path = followed(replace(scene, every=1), difference.rules).motion
    apart = path.position[:, 0] - path.position[:, 1]
    radius = float(contact["first_radius"])
    overlaps = 2.0 * radius - np.linalg.norm(apart, axis=1)
    deepest = int(np.argmax(overlaps))
    contact["stage"] = SWELLING
    radii = [grown(law, contact, float(x))[0] for x in overlaps[: deepest + 1] if x > 0.0]
    growth, total = float(np.max(np.diff(radii), initial=0.0)), max(radii, default=0.0)
    contact["largest"] = overlaps[deepest]
    slope = pressed(law, contact, float(overlaps[deepest]) * (1.0 - 1e-6)).slope
    push = slope * total * scene.step / float(contact["mass"])
    most = max(
        slope * growth / difference.sizes["force"],
        push / difference.sizes["velocity"],
        push * scene.duration / difference.sizes["position"],
    )
    return most * _spread(scene.law), "the growth of the radius in a step"


def _round_off_turned(difference: PredictedDifference) -> tuple[float, str]:
    """Return what turning round a spring leaves that has twisted by round-off alone.

    A step rounds the spin along the normal by eps of the spin.
    """
    scene, law = difference.run.scene, difference.run.scene.law
    fastest = max(math.hypot(*w) for piece in scene.segments for w in piece.omegas)
    turned = float(np.finfo(float).eps) * fastest * scene.duration
    stiffness = law.twisting_stiffness or 0.0
    if law.twisting == "marshall":
        contact = (law.tangential_stiffness or 0.0) or effective_moduli(law)[1] * 8.0
        stiffness = contact * scene.bodies[0].radius ** 2
    dashpots = (law.twisting_damping or 0.0) * float(np.finfo(float).eps) * fastest
    most = ROUNDINGS * (stiffness * turned + dashpots) / difference.sizes["torque"]
    return 2.0 * most, "round-off of the spin along the normal, turned round"


def _turning_springs_turned(difference: PredictedDifference) -> tuple[float, str]:
    """Return twice what springs of rolling and twisting hold at most: turned round, then and again.

    Their limits are mu_r R* F_n and mu_w F_n, or 2/3 a mu F_n; below it, what the whole turn
    strains a spring by, and its dashpot.
    """
    if not difference.run.scene.segments:
        return _turned_round_while_free(difference)
    scene, law, force = difference.run.scene, difference.run.scene.law, difference.sizes["force"]
    first, second = (body.radius for body in scene.bodies)
    curvature = first * second / (first + second)
    spins = [math.dist(*piece.omegas[:2]) for piece in scene.segments]
    turned = sum(w * p.steps for w, p in zip(spins, scene.segments, strict=True)) * scene.step
    rolls = (law.rolling_stiffness or 0.0) * turned + (law.rolling_damping or 0.0) * max(spins)
    twists = (law.twisting_stiffness or 0.0) * turned + (law.twisting_damping or 0.0) * max(spins)
    rolling = min(curvature**2 * rolls, (law.rolling_friction or 0.0) * curvature * force)
    twisting = min(twists, (law.twisting_friction or 0.0) * force)
    if law.twisting == "marshall":
        area = math.sqrt(curvature * difference.sizes["position"])
        twisting = 2.0 / 3.0 * area * (law.friction or 0.0) * force
    return 2.0 * (rolling + twisting) / difference.sizes["torque"], "springs that hold all they can"


def _turned_round_while_free(difference: PredictedDifference) -> tuple[float, str]:
    """Return what torques at their limits do to the spin of a free sphere, twice, all the time."""
    scene, law = difference.run.scene, difference.run.scene.law
    first, second = (body.radius for body in scene.bodies)
    curvature = first * second / (first + second)
    arm = (law.rolling_friction or 0.0) * curvature + (law.twisting_friction or 0.0)
    if law.twisting == "marshall":
        arm += (
            2.0 / 3.0 * math.sqrt(curvature * difference.sizes["position"]) * (law.friction or 0.0)
        )
    moment = 2.0 * arm * difference.sizes["force"]
    free = [body.inertia for body in scene.bodies if not body.frozen]
    spun = moment / min(free) * scene.duration
    most = max(moment / difference.sizes["torque"], spun / difference.sizes["omega"])
    return most, "torques at their limits, turned round all the time"


def _no_contact(difference: PredictedDifference) -> tuple[float, str]:
    """Return how far bodies that pass through one another are from those that rebound."""
    scene = difference.run.scene
    speed = max(math.hypot(*body.velocity) for body in scene.bodies)
    path = 2.0 * speed * scene.duration / difference.sizes["position"]
    return max(path, 2.0 * speed / difference.sizes["velocity"], 1.0), "the way of both"


BOUNDS: Mapping[str, Callable[[PredictedDifference], tuple[float, str]]] = {
    "rolling limit in setup": _uninitialised_rolling,
    "radius of the step before": _radius_of_the_step_before,
    "round-off turned": _round_off_turned,
    "turning springs turned": _turning_springs_turned,
    "no contact": _no_contact,
}
