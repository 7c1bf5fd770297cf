"""Impacts with friction: at an angle, in other units, of two or more moving spheres, with spin.

Two moving spheres are judged by what is relative, which must be the same whatever moves. Codes that
add the slip of half a step to a spring in the plane of a whole one were seen to trap small spheres
among large ones (Vyas et al., Comput. Phys. Commun. 310, 109524 (2025)).

Maw, Barber and Fawcett, Wear 38, 101 (1976): the contact of a real sphere sticks inside and slips
outside, where Mindlin's springs stick or slip as a whole. The normalised incidence is psi = 2 (1 -
nu) / (mu (2 - nu)) times the tangential over the normal velocity at the contact.

A contact of its own tests a law. In the box each sphere has several at once, with neighbours and
walls in all directions, and touches them again: a code must keep a history for each contact, and
forget it when the contact ends.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.checks import REASON, ROUND_OFF, with_digits
from harness.cases.contacts.contact_case import ContactCase, law_part
from harness.cases.contacts.impact import impact_scene, relative_velocity
from harness.cases.contacts.parameters import (
    AngularSpeed,
    ContactSystem,
    Duration,
    Speed,
    ratios,
)
from harness.engines.base import Engine, Job, scene_job
from harness.errors import EngineError
from harness.model.base import Vector
from harness.model.scene import Floats, Motion, Scene, Wall, sphere
from harness.report.content import Drawing, Section
from harness.results.rows import Kind, Tolerance
from harness.theory.contact import partial_slip_rebound, stiffness_ratio

if TYPE_CHECKING:
    from harness.report.figures import Figure

# impacts that are drawn with the curve of partial slip
LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
INCIDENCES = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0])
FRICTION, POISSON = 0.3, 0.3
STEPS = 400  # of a contact, of those impacts
SAME_REBOUNDS = Tolerance(absolute=ROUND_OFF * float(INCIDENCES[-1]), reason=REASON)
LEAST_ANGLE = 1e-6  # [deg]: ratios of velocities have an error of 1e-16 over its sine, 1e-8
# [m], [kg], [s]: units in which radius, mass and duration of a contact are about 1; powers of two,
# so that no bit of a ratio may differ from that in SI units
LENGTH, MASS, TIME = 2.0**-6, 2.0**-7, 2.0**-9
SPEED = LENGTH / TIME
CORNERS = tuple(product((0, 1), repeat=3))
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))  # angle between directions that fill a sphere evenly
FIRST_TURN = 1.0  # [rad] of velocities: none lies in a plane of symmetry
FIRST_SPIN = 2.0


class Oblique(ContactSystem):
    """A sphere hits a wall or a sphere at an angle: velocity ratios and spin.

    Integrated under the code's conventions. Where it slides throughout and the normal force
    never pulls, vx'/vx = 1 - mu (1 + e) vn/vx, r omega' = 5/2 mu (1 + e) vn on a wall.
    """

    quantities: ClassVar = (
        *ratios(
            normal_restitution="normal speed after over that before",
            tangential_ratio="tangential velocity of the centre, likewise",
            rim_speed_ratio="radius times spin at the end over the tangential velocity at the "
            "start",
        ),
        Quantity(
            "tangential_impulse_ratio", "1", "tangential over normal impulse: at most mu where the "
            "normal force never pulls, else mu times the integral of |F_n| over that of F_n",
            lambda p: min(p.friction or 1.0, 1.0),  # Coulomb's limit: a larger one is not reached
        ),
    )  # fmt: skip

    speed: Speed = Field(1.0, description="[m/s] of the approach")
    angle: float = Field(45.0, ge=0.0, lt=90.0, description="[deg] to the normal")

    def check(self) -> None:
        """Raise ValueError for an impact that is too deep or too shallow, or an angle that is."""
        along, _, down = self.velocity
        self.check_impact("speed", -down)
        if along:
            reason = "0, or more than the rounding of the velocity along the surface"
            self.check_range("angle", LEAST_ANGLE, 90.0, reason)

    @property
    def velocity(self) -> Vector:
        """Return the velocity of the sphere [m/s]: along x and down."""
        angle = math.radians(self.angle)
        return (self.speed * math.sin(angle), 0.0, -self.speed * math.cos(angle))

    def scene(self) -> Scene:
        """Return the impact; samples before and after it."""
        return impact_scene(self, self.velocity, sampled=False)

    def absent(self) -> Collection[str]:
        """Return the quantities over a tangential velocity where there is none."""
        return () if self.velocity[0] > 0.0 else [each.name for each in Oblique.quantities[1:]]

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return ratios of the velocities after to those before; tangential ones at an angle."""
        along, _, down = self.velocity
        before, after = relative_velocity(motion)[[0, -1]]
        quantities = {"normal_restitution": float(after[2]) / -down}
        if along > 0.0:
            spin = float(motion.angular_velocity[-1, 0, 1])
            impulses = before[0] - after[0], after[2] - before[2]
            quantities["tangential_ratio"] = float(after[0]) / along
            quantities["rim_speed_ratio"] = self.radius * spin / along
            quantities["tangential_impulse_ratio"] = float(impulses[0] / impulses[1])
        return quantities


class LjUnits(Oblique):
    """An oblique impact in units lj: velocity ratios and spin are those in SI units.

    As an oblique impact, all numbers times powers of the units.
    """

    allowed: ClassVar = {
        **Oblique.allowed, "normal": ("hooke", "hertz", "dmt", "jkr"), "materials_as": ("stated",),
    }  # fmt: skip

    def scene(self) -> Scene:
        """Return the impact in other units."""
        scene = super().scene()
        units = {"radius": LENGTH, "mass": MASS, "position": LENGTH, "velocity": SPEED}
        bodies = []
        for body in scene.bodies:  # without spin
            parts = {n: np.divide(getattr(body, n), unit).tolist() for n, unit in units.items()}
            bodies.append(body.replace(**parts))
        law = scene.law.in_units(LENGTH, MASS, TIME)
        return scene.replace(bodies=tuple(bodies), law=law, step=scene.step / TIME)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the ratios of an oblique impact."""
        velocity, spin = motion.velocity * SPEED, motion.angular_velocity / TIME
        return super().observe(replace(motion, velocity=velocity, angular_velocity=spin))


class Collision(Oblique):
    """Two moving spheres collide at an angle, of other densities and sizes.

    As an oblique impact, whatever moves, with m* and R* of both spheres. Where it slides
    throughout, vx'/vx = 1 - mu (1 + e) vn/vx of the relative velocity. The momentum of both
    stays.
    """

    quantities: ClassVar = (
        *Oblique.quantities,
        *ratios(
            momentum_change_ratio="along the normal, of both, after less before, over m* times the "
            "speed",
        ),
    )

    allowed: ClassVar = {**Oblique.allowed, "partner": ("sphere",)}

    partner_share: float = Field(
        0.5, ge=-10.0, le=10.0, description="[-] of the speed that the second sphere has"
    )

    def scene(self) -> Scene:
        """Return the impact seen where the second sphere moves towards the first."""
        x, _, z = (-self.partner_share * v for v in self.velocity)
        scene = super().scene()
        bodies = tuple(
            body.replace(velocity=(body.velocity[0] + x, body.velocity[1], body.velocity[2] + z))
            for body in scene.bodies
        )
        return scene.replace(bodies=bodies)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return ratios of relative velocities, and the change of the momentum of both."""
        momentum = np.array([self.mass, self.second_mass]) @ motion.velocity[:, :, 2].T
        change = float(momentum[-1] - momentum[0]) / (self.effective_mass * self.speed)
        return {**super().observe(motion), "momentum_change_ratio": change}

    def exact(self) -> Mapping[str, float]:
        """Return that no momentum is lost."""
        return {"momentum_change_ratio": 0.0}


class Spin(ContactSystem):
    """A spinning sphere hits a wall or a sphere: final spin, velocity gained.

    Integrated under the code's conventions. Where it slides throughout and the normal force
    never pulls, vx' = -mu (1 + e) vn against the surface's motion, omega' = omega - 5/2 mu (1 +
    e) vn / r on a wall.
    """

    quantities: ClassVar = ratios(
        normal_restitution="normal speed after over that before",
        spin_ratio="spin at the end over that at the start",
        gained_speed_ratio="tangential velocity gained over radius times spin at the start",
    )

    # fmt: off
    speed: Speed = Field(1.0, description="[m/s] of the approach")
    spin: AngularSpeed = Field(100.0, description="[rad/s] of the sphere, about y")
    partner_spin: float = Field(
        0.0, ge=-1e9, le=1e9, description="[rad/s] of the other sphere, about y")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for a spin without a sphere, and an impact too deep or too shallow."""
        if self.partner_spin and self.partner != "sphere":
            raise self.invalid("partner_spin", f"partner = {self.partner!r} has none (sphere does)")
        self.check_impact("speed", self.speed)

    def scene(self) -> Scene:
        """Return the impact; samples before and after it."""
        spins = (0.0, self.spin, 0.0), (0.0, self.partner_spin, 0.0)
        return impact_scene(self, (0.0, 0.0, -self.speed), *spins, sampled=False)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return ratios of velocities and spin after the impact to those before."""
        after = relative_velocity(motion)[-1]
        return {
            "normal_restitution": float(after[2]) / self.speed,
            "spin_ratio": float(motion.angular_velocity[-1, 0, 1]) / self.spin,
            "gained_speed_ratio": float(after[0]) / self.radius / self.spin,
        }


class Box(ContactSystem):
    """Eight spheres in a box, with velocities and spins in all directions: the energy that remains.

    Integrated under the code's conventions. Without dissipation the energy stays, but for the
    springs of contacts that last at the end.
    """

    quantities: ClassVar = ratios(
        energy_ratio="kinetic energy at the end over that at the start, of all spheres",
        spin_energy_ratio="that of the spins alone, likewise",
    )

    allowed: ClassVar = {
        **ContactSystem.allowed, "partner": ("sphere",), "materials_as": ("stated",),
    }  # fmt: skip

    # fmt: off
    speed: Speed = Field(1.0, description="[m/s] of each sphere, and of its rim")
    gap: float = Field(
        0.02, ge=1e-6, le=1.0, description="[-] between the largest spheres, in their diameters")
    duration: Duration = Field(12.0, description="[-] in contact times, without a dashpot")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for impacts that are too deep or too shallow."""
        if self.partner_density is not None:
            raise self.invalid("partner_density", "must not be given: all are of one material")
        self.check_impact("speed", 2.0 * self.speed)

    @property
    def radii(self) -> Floats:
        """Return the radii of the spheres (8,) [m], from the first to the second radius."""
        return np.linspace(self.radius, self.second_radius, len(CORNERS))

    def scene(self) -> Scene:
        """Return the spheres in the corners of the box, each on its way."""
        cell = 2.0 * max(self.radius, self.second_radius) * (1.0 + self.gap)
        steps = math.ceil(self.duration * self.steps_per_contact)
        bodies = []
        for i, (corner, radius) in enumerate(zip(CORNERS, self.radii.tolist(), strict=True)):
            spin = (component / radius for component in self._direction(i, FIRST_SPIN))
            bodies.append(
                sphere(
                    radius,
                    self.density,
                    position=tuple((place + 0.5) * cell for place in corner),
                    velocity=self._direction(i, FIRST_TURN),
                    angular_velocity=tuple(spin),
                )
            )
        return Scene(
            bodies=tuple(bodies),
            walls=tuple(_walls(2.0 * cell)),
            law=self.stated_law,
            step=math.pi * self.elastic_overlap(self.speed) / self.speed / self.steps_per_contact,
            steps=steps,
            every=steps,
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the kinetic energies at the end over those at the start."""
        radii = self.radii
        moving = (motion.velocity**2).sum(axis=2) @ radii**3  # masses, but for a factor
        turning = 0.4 * (motion.angular_velocity**2).sum(axis=2) @ radii**5
        energy = moving + turning
        return {
            "energy_ratio": float(energy[-1] / energy[0]),
            "spin_energy_ratio": float(turning[-1] / turning[0]),
        }

    def _direction(self, index: int, turn: float) -> Vector:
        """Return the speed in one of eight directions, spread evenly (Fibonacci's lattice)."""
        z = (2.0 * index + 1.0) / len(CORNERS) - 1.0
        across = math.sqrt(1.0 - z * z)
        angle = turn + GOLDEN * index
        x, y = across * math.cos(angle), across * math.sin(angle)
        return (self.speed * x, self.speed * y, self.speed * z)


def _walls(side: float) -> Iterator[Wall]:
    """Yield the faces of a cube [m], a corner of which is the origin."""
    for normal in np.eye(3):
        yield Wall(direction=tuple(normal.tolist()))
        yield Wall(point=tuple((side * normal).tolist()), direction=tuple((-normal).tolist()))


class PartialSlipCase(ContactCase[Any]):
    """Impacts at an angle, some of which are drawn with the curve of partial slip."""

    def checks_up_to(self, engine: Engine, level: Level) -> Iterator[Check]:
        """Yield the checks of trials, and the impacts of the first of the laws that is stated."""
        yield from super().checks_up_to(engine, level)
        laws = (law for law in LAWS if not any(map(engine.refuses, self._jobs(law))))
        law = next(laws, None) if level != "quick" else None
        if law is not None:
            yield Check(
                setup=f"{law}, wall, partial slip",
                quantity="rebound_difference",
                unit="1",
                measure=partial(self._difference, law),
                expected=0.0,
                tolerance=partial(with_digits, SAME_REBOUNDS, float(INCIDENCES[-1])),
                level="default",
                jobs=[*self._jobs(law)],
                note="largest difference from the reference of 12 impacts, drawn in the report",
            )

    def own_checks(self) -> Iterator[Check]:
        """Yield a finding for each law: its rebound where it is farthest from partial slip."""
        for law in LAWS:
            yield Check(
                setup=f"{law}, wall, partial slip",
                quantity="normalised_rebound",
                unit="1",
                measure=lambda bench, law=law: self._farthest(law, bench)[0],  # type: ignore[misc]
                expected=lambda bench, law=law: self._farthest(law, bench)[1],  # type: ignore[misc]
                kind=Kind.FINDING,
                level="default",
            )

    def rebounds(self, law: str, bench: Bench, *, measured: bool) -> Floats:
        """Return the rebounds (M,) of a law at :data:`INCIDENCES`, by engine or reference."""
        rebounds = []
        for psi, p in zip(INCIDENCES, self._impacts(law), strict=True):
            scene = p.scene()
            motion = bench.motion(scene_job(scene)) if measured else bench.reference(scene)
            ratios = p.observe(motion)
            slip = ratios["tangential_ratio"] - ratios["rim_speed_ratio"]
            rebounds.append(psi * slip / ratios["normal_restitution"])
        return np.array(rebounds)

    def sections(self, benches: Mapping[str, Bench]) -> list[Section]:
        """Return the matrix, with the curve of partial slip where a code has run the impacts."""
        *before, matrix = super().sections(benches)
        return [*before, replace(matrix, drawings=self.drawings(benches))]

    def drawings(self, benches: Mapping[str, Bench]) -> tuple[Drawing, ...]:
        """Return Maw's curve with the laws by the reference and all codes that have run them."""
        from harness.cases.contacts.report import codes_by_title

        marks: dict[str, Floats] = {}
        for (code, bench), law in product(codes_by_title(benches).items(), LAWS):
            if bench.has_run(self._jobs(law)):
                with suppress(EngineError):  # of a run that failed, which its row reports
                    marks[f"{code}, {law}"] = self.rebounds(law, bench, measured=True)
        if not marks:
            return ()
        solver = benches.get(OWN) or Bench(None)
        lines = {law: solver.once(self.rebounds, law, solver, measured=False) for law in LAWS}
        text = (
            "Velocity at the contact after over that before, both over mu times the normal one and "
            "times 2 (1 - nu) / (2 - nu), elastic sphere on a wall of its material, nu = 0.3. "
            "Lines: the laws by the reference under LAMMPS's conventions; marks: codes under their "
            f"own, each within {ROUND_OFF:g} of the reference under these. {STEPS} steps a contact."
        )
        title = "Laws that stick as a whole, and partial slip"
        return (Drawing("oblique-partial-slip", title, text, lambda: figure(lines, marks)),)

    def _impacts(self, law: str) -> Iterator[Any]:
        """Yield the impacts of an elastic sphere on a wall, at 1 m/s along the normal."""
        base = self.default.replace(
            **law_part("hertz"), damping="none", tangential=law, tangential_damping=0.0,
            friction=FRICTION, steps_per_contact=STEPS,
        )  # fmt: skip
        angles = np.arctan(INCIDENCES * FRICTION / stiffness_ratio(POISSON))
        return (base.replace(angle=math.degrees(a), speed=1.0 / math.cos(a)) for a in angles)

    def _jobs(self, law: str) -> Iterator[Job]:
        return (scene_job(p.scene()) for p in self._impacts(law))

    def _difference(self, law: str, bench: Bench) -> float:
        measured, expected = (self.rebounds(law, bench, measured=each) for each in (True, False))
        return float(np.abs(measured - expected).max())

    def _farthest(self, law: str, bench: Bench) -> tuple[Value, float]:
        """Return the rebound where it differs most from partial slip, and that of partial slip."""
        rebounds = bench.once(self.rebounds, law, bench, measured=False)
        curve = partial_slip_rebound(INCIDENCES, POISSON)
        at = int(np.abs(rebounds - curve).argmax())
        note = f"farthest from partial slip at psi = {INCIDENCES[at]:g} of 0.25 to 6, elastic"
        return Value(float(rebounds[at]), note=note), float(curve[at])


def figure(laws: Mapping[str, Floats], codes: Mapping[str, Floats]) -> Figure:
    """Draw Maw's curve, the rebounds of laws as lines and of codes as marks, each (M,)."""
    from harness.report.figures import BLACK, COLOURS, MARKERS, STYLES, legend_below, panels

    drawn = panels(1, 1, width=8.0, height=4.4)
    axes = drawn.axes[0]
    psi = np.linspace(0.0, INCIDENCES[-1], 121)
    name = "partial slip: Maw, Barber and Fawcett 1976"
    axes.plot(psi, partial_slip_rebound(psi, POISSON), color=BLACK, lw=2.0, label=name)
    for number, (law, rebounds) in enumerate(laws.items(), 1):
        axes.plot(INCIDENCES, rebounds, color=COLOURS[number], ls=STYLES[number], label=law)
    for number, (code, rebounds) in enumerate(codes.items()):
        marker, size = MARKERS[number % len(MARKERS)], 4.0 + 1.5 * number
        axes.plot(INCIDENCES, rebounds, marker, color="0.25", mfc="none", ms=size, label=code)
    axes.set(xlabel="normalised incidence", ylabel="normalised rebound")
    legend_below(drawn)
    return drawn


OBLIQUE = PartialSlipCase("oblique", Oblique)
LJ_UNITS = ContactCase("lj-units", LjUnits, units="lj")
COLLISION = ContactCase("collision", Collision)
SPIN = ContactCase("spin", Spin)
BOX = ContactCase("box", Box)
