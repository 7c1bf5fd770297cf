"""The base classes of contact cases: what impacts and resting spheres have in common.

A contact case is a scene, the quantities of its motion and their closed forms. Its submodels,
systems and presets are tables; refinement, judgement and report are those of all contact cases.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, TypeVar

from pydantic import Field

from harness.cases.contact.motion import Array, Motion, reference_motion, scene_of
from harness.cases.contact.parameters import (
    ContactSystem,
    Duration,
    Gravity,
    counted,
    meets,
    resolved,
    rest_overlap,
    rests,
    stiffness,
)
from harness.cases.contact.submodels import (
    OLD_TANGENTIAL,
    PLAIN,
    SOURCES,
    SYSTEMS,
    TANGENTIAL,
    TANGENTIAL_BESIDE,
    TWO_MATERIALS,
    Submodel,
    Told,
    Trial,
)
from harness.cases.contract import Case, LevelName, Reference
from harness.engines.contract import Job, Output, Template
from harness.engines.cost import engine_seconds
from harness.engines.scene_jobs import SCENE, scene_job
from harness.engines.scene_tables import motion_in
from harness.engines.traits import Traits
from harness.errors import EngineNaNError, Unsupported
from harness.model.conventions import Rules
from harness.model.scene import Scene
from harness.parameters.scene import ZERO, ContactScene, Vector

P = TypeVar("P", bound=ContactSystem)

STEPS = 50
"""Steps of a contact at which engines are held against the reference."""

LONGER = ("unequal spheres", "frozen sphere", "two spheres, turned", *TWO_MATERIALS)
"""Systems that the shortest level leaves out.

In the others the submodels take turns there, but those of earlier interfaces, whose walls and pairs
share no code. Two materials are gone through by one submodel of a case (``two_materials_of``).
"""


PAIRS = [name for name in TWO_MATERIALS if name.startswith("two")]


class ContactCase(Case[P]):
    """The part that every contact case shares.

    ``submodels`` are gone through in each of ``systems``, which change the default parameters;
    ``formula``, of ``case.toml``, says in a sentence what is expected.
    """

    group: ClassVar[str] = "contacts"
    template: ClassVar[Template] = SCENE
    verified_by = "harness.cases.contact.verification:ContactVerification"
    shown_by = "harness.cases.contact.report:ContactDisplay"
    submodels: ClassVar[Sequence[Submodel]]
    other_submodels: ClassVar[Sequence[Submodel]] = ()
    """Submodels that codes compared with one another go through as well."""
    systems: ClassVar[Told] = SYSTEMS
    two_materials_of: ClassVar[str] = ""
    """The submodel that meets a sphere of another material at the shortest level, too."""
    sets: ClassVar[Told]
    """What the presets change of the default parameters, by name; the first is the default."""
    invariant: ClassVar[Sequence[Submodel]] = ()
    """Those whose variations level full runs, in all systems."""
    over_ranks: ClassVar[Sequence[str]] = ()
    """Names of those that the default level runs by variations: one of each kind of memory."""
    by_defaults: ClassVar[Sequence[str]] = ()
    """Names of those of which the shortest level runs a pair by LAMMPS's defaults."""
    formula: ClassVar[str]
    every_level: ClassVar[Sequence[str]] = ()
    """Systems in which the shortest level runs each submodel, whoever's turn it is."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        cls.formula = cls.text.get("formula", "")

    @property
    def presets(self) -> Mapping[str, P]:
        """Return the usual parameters, and sets of the literature."""
        return {name: self.parameters(**values) for name, values in self.sets.items()}  # type: ignore[misc]

    def source_of(self, preset: str) -> str:
        """Return where the values of a preset were published; empty for those of this package."""
        return next((text for name, text in SOURCES.items() if preset.startswith(name)), "")

    @abstractmethod
    def scene(self, parameters: P) -> ContactScene:
        """Return what is set up."""

    @abstractmethod
    def observed(self, parameters: P, motion: Motion) -> Mapping[str, float]:
        """Return the quantities of a motion, whoever computed it."""

    def sizes(self, parameters: P) -> Mapping[str, float]:
        """Return the size that a ratio has in a run, by name, in which its tolerance is a part.

        That of its limit, or the largest that it has; those that are left out are of the size 1.
        """
        return {}

    def closed_forms(self, parameters: P) -> Mapping[str, float]:
        """Return the quantities whose exact value is known, by name."""
        return {}

    def setup(self, parameters: P) -> Scene:
        """Return the scene that engines and the reference run."""
        return scene_of(self.scene(parameters), parameters)

    def job(self, parameters: P) -> Job:
        """Return the job of one run."""
        return scene_job(self.setup(parameters))

    def motion(self, parameters: P, output: Output) -> Motion:
        """Return the samples of a run; raise EngineOutputError where some are missing."""
        return motion_in(output, self.setup(parameters))

    def read(self, parameters: P, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return the quantities of a run; raise EngineOutputError for one that is cut."""
        return self.observed(parameters, self.motion(parameters, output))

    def references(self, parameters: P, traits: Traits) -> Mapping[str, Reference]:
        """Return the values at equal steps; closed forms where the reference cannot run."""
        exact = self.closed_forms(parameters)
        try:
            scene = self.setup(parameters)
            rules = Rules() if traits.conventions is None else traits.conventions(scene)
            values = self.observed(parameters, reference_motion(scene, rules))
        except (EngineNaNError, Unsupported):
            return {name: Reference(value, "closed form") for name, value in exact.items()}
        return {name: Reference(value, "equal steps") for name, value in values.items()}

    def seconds(self, parameters: P, rules: Traits | None, solver: str = "") -> float:
        """Return what a run is expected to take an engine of these rules [s]."""
        scene = self.scene(parameters)
        return 0.0 if rules is None else engine_seconds(scene.steps, len(scene.bodies), rules)

    def trials(
        self, level: LevelName, submodels: Sequence[Submodel] | None = None
    ) -> Iterator[Trial]:
        """Yield submodels in the systems that a level goes through, with its coarsest step.

        Those of the case unless others are given.
        """
        base, coarsest = self.default, STEPS
        names = [each.name for each in (*self.submodels, *self.other_submodels) if each.quick]
        for submodel in self.submodels if submodels is None else submodels:
            systems = {
                system: self._values(submodel, system, coarsest)
                for system, changes in self.systems.items()
                if (level != "quick" or (submodel.quick and system not in LONGER))
                and submodel.stated_in(system, changes)
            }
            if systems and level == "quick" and submodel.law.get("interface") != "old":
                others = [name for name in systems if name not in self.every_level]
                turn = others[names.index(submodel.name) % len(others)] if others else ""
                every = [name for name in systems if name == turn or name in self.every_level]
                of_two = submodel.name == self.two_materials_of
                pairs = [name for name in PAIRS if of_two and name in self.systems]
                systems = {
                    name: self._values(submodel, name, coarsest) for name in (*every, *pairs)
                }
            for system, values in systems.items():
                yield Trial(submodel.name, system, base.replace(**values))

    def _values(self, submodel: Submodel, system: str, steps: int) -> dict[str, Any]:
        """Return what a submodel in a system changes of the case's parameters."""
        return {**PLAIN, **submodel.law, **self.systems[system], "steps_per_contact": steps}


class Friction:
    """What cases with friction along the surface go through; stands before ``ContactCase``."""

    submodels: ClassVar[Sequence[Submodel]] = (*TANGENTIAL, *OLD_TANGENTIAL)
    other_submodels: ClassVar[Sequence[Submodel]] = TANGENTIAL_BESIDE


REST_SAMPLES = 4


class Resting(ContactSystem):
    """A sphere at rest along z, that moves or turns along the surface; in SI units."""

    carried_by: ClassVar[tuple[str, ...]] = ("wall",)

    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(20.0, description="[-] in half periods of the contact")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, *self.carried_by)
        rests(self, -self.pull[2])

    @property
    def pull(self) -> Vector:
        """Return the acceleration of gravity [m/s2]."""
        return (0.0, 0.0, -self.gravity)

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return velocity [m/s] and angular velocity [rad/s] at the start."""
        return ZERO, ZERO

    @property
    def half_period(self) -> float:
        """Return pi sqrt(m / k) of small oscillations about rest [s]."""
        k = stiffness(self, rest_overlap(self, self.mass * -self.pull[2]))
        return math.pi * math.sqrt(self.mass / k)

    @property
    def seconds(self) -> float:
        """Return the duration [s]; raise RequestError where it has none."""
        return self.duration * self.half_period


R = TypeVar("R", bound=Resting)


class RestingCase(ContactCase[R]):
    """What the cases of a sphere at rest share: the scene, and the drawing of rolling."""

    def scene(self, parameters: R) -> ContactScene:
        """Return the sphere at rest along z under gravity.

        The duration is met to a step. Raise RequestError for too many steps, which are told of the
        parameter ``duration``, and for a step that does not resolve the law.
        """
        step = parameters.half_period / parameters.steps_per_contact
        counted(parameters, parameters.seconds / step)
        every = max(1, round(parameters.seconds / step / REST_SAMPLES))
        overlap = rest_overlap(parameters, parameters.mass * -parameters.pull[2])
        first, *others = parameters.bodies(-overlap, *parameters.start)
        scene = ContactScene(
            (first, *others),
            parameters.planes,
            parameters.law,
            # the steps fill the duration: all levels end at the same time
            step=parameters.seconds / REST_SAMPLES / every,
            steps=REST_SAMPLES * every,
            every=every,
            gravity=parameters.pull,
        )
        return resolved(parameters, scene, overlap)


def rolling(parameters: Resting, motion: Motion) -> tuple[Array, Array]:
    """Return the speed along x, and radius times the spin about y, each (M,) [m/s]."""
    return motion.velocity[:, 0, 0], parameters.radius * motion.angular_velocity[:, 0, 1]


def speed_ratios(
    halfway: str, parameters: Resting, motion: Motion, speed: float
) -> dict[str, float]:
    """Return the speed halfway, by a name, speed and spin at the end, over a speed [m/s]."""
    u, spin = rolling(parameters, motion)
    speeds = {halfway: u[len(u) // 2], "speed_ratio": u[-1], "rim_speed_ratio": spin[-1]}
    return {name: float(value) / speed for name, value in speeds.items()}
