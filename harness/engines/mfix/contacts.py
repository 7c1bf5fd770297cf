"""MFiX's keywords for a contact law with friction: which laws it has, by which rules, and a run.

As the source of 21.3.2 has it: ``check_solids_dem.f``, ``calc_force_dem.f``,
``calc_collision_wall_mod.f`` and ``cfrelvel.f``; the rules are confirmed by recorded runs. The
plane of a scene, x and z, is that of MFiX, x and y.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from harness.engines.mfix.system import (
    FIRST_STEP,
    LEAST_FACTOR,
    Frame,
    Scheme,
    nominal_restitution,
    particle,
    row_of,
)
from harness.engines.output import Table
from harness.engines.traits import (
    DASHPOTS,
    FRICTIONLESS,
    ContactModel,
    ContactValues,
    States,
    Traits,
    takes,
)
from harness.errors import EngineNaNError, EngineOutputError, RequestError
from harness.parameters.law import Contact

COLUMNS = (
    *("x_m", "y_m", "z_m", "vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    *("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
)

SPHERE = ("radius", "mass", "x", "z", "vx", "vz")


@dataclass(frozen=True)
class Ball:
    """A sphere in the plane of a scene; SI."""

    radius: float
    mass: float
    x: float
    z: float
    vx: float
    vz: float
    held: bool

    @property
    def kind(self) -> tuple[float, float]:
        """Return diameter and density, which make a phase."""
        return 2.0 * self.radius, self.mass * 0.75 / math.pi / self.radius**3


@dataclass(frozen=True)
class Couple:
    """What two phases, or a phase and a wall, have as they meet: m* [kg] and R* [m]."""

    mass: float
    radius: float
    meets: bool


def contact_table(contact: ContactInput, frames: Sequence[Frame]) -> Table:
    """Return the samples; raise EngineOutputError where some are missing.

    MFiX writes no forces. A held sphere is not written: it rests.
    """
    numbers = range(0, contact.steps + 1, contact.every)
    clock = {round(frame.time / contact.step): frame for frame in frames}
    if missing := [number for number in numbers if number not in clock]:
        raise EngineOutputError(f"MFiX wrote no particles at step {missing[0]}")
    table = {"step": np.array(numbers, dtype=np.float64)}
    states = np.array([_state(contact, clock[number]) for number in numbers])
    if not np.isfinite(states).all():
        raise EngineNaNError("MFiX wrote values that are not numbers")
    for column, name in enumerate(COLUMNS):
        table[name] = states[:, :, column]
    return table


def _state(contact: ContactInput, frame: Frame) -> list[list[float]]:
    x0, y0 = contact.origin
    rows = []
    for number, ball in enumerate(contact.balls, 1):
        if ball.held:
            rows.append([ball.x, 0.0, ball.z, *[0.0] * 6])
            continue
        x, y, vx, vy = particle(frame, number)
        # x, y, z of MFiX are x, z, -y of the scene
        spin = -frame.arrays["Angular_velocity"][row_of(frame, number)][2]
        rows.append([x - x0, 0.0, y - y0, vx, 0.0, vy, 0.0, spin, 0.0])
    return rows


UNUSED = 1e-20
"""Restitution of pairs that never meet: it keeps them from setting the step."""

MOST_FRAMES = 20_000


@dataclass(frozen=True)
class ContactInput:
    """A job of a contact in MFiX's keywords; raise RequestError for what it does not take."""

    values: ContactValues
    scheme: Scheme = "EULER"

    def __post_init__(self) -> None:
        if "walls_as" in self.values:
            raise RequestError("has horizontal walls at rest")
        wanted = {
            "tangential_stiffness / normal_stiffness": self.tangential_factor,
            "tangential_damping": self._number("tangential_damping") if self.linear else 0.0,
            "friction": self._number("friction"),
        }
        for name, value in wanted.items():
            if value > 1.0:
                raise RequestError(f"takes {name} up to 1, not {value:g}")
        for couple in (*self.pairs, *self.walls):
            self.restitutions(couple)
        if self.factor < LEAST_FACTOR:
            raise RequestError(
                f"takes DTSOLID_FACTOR from {LEAST_FACTOR:g} on: this step is {self.factor:.3g}"
            )
        if self.steps // self.every > MOST_FRAMES:
            raise RequestError(f"writes a file a sample: up to {MOST_FRAMES}")

    def _number(self, name: str) -> float:
        return float(self.values[name])

    @property
    def linear(self) -> bool:
        """Return whether springs are linear."""
        return self.values["normal"] == "hooke"

    @property
    def step(self) -> float:
        """Return the step [s]."""
        return self._number("step_size")

    @property
    def steps(self) -> int:
        """Return the steps of the run."""
        return int(self.values["steps"])

    @property
    def every(self) -> int:
        """Return the steps between samples."""
        return int(self.values["series_every"])

    @cached_property
    def balls(self) -> tuple[Ball, ...]:
        """Return the spheres; MFiX starts them without spin."""
        balls = []
        for i in (1, 2):
            if f"radius_{i}" not in self.values:
                continue
            if any(self._number(f"{name}_{i}") for name in ("wx", "wy", "wz")):
                raise RequestError("starts spheres without spin")
            if self._number(f"y_{i}") or self._number(f"vy_{i}") or self._number("gravity_y"):
                raise RequestError("takes motions in one plane")
            held = self.values[f"motion_{i}"] == "frozen"
            values = {name: self._number(f"{name}_{i}") for name in SPHERE}
            balls.append(Ball(held=held, **values))
        return tuple(balls)

    @cached_property
    def phases(self) -> tuple[tuple[float, float], ...]:
        """Return diameter [m] and density [kg/m3] of the phases, which MFiX knows spheres by."""
        return tuple(dict.fromkeys(ball.kind for ball in self.balls))

    @property
    def tangential_factor(self) -> float:
        """Return k_t / k_n of linear springs; without friction any, but MFiX divides by k_t."""
        if self.values["tangential"] != "linear_history":
            return 2.0 / 7.0
        return self._number("tangential_stiffness") / self._number("normal_stiffness")

    @cached_property
    def pairs(self) -> tuple[Couple, ...]:
        """Return the pairs of phases in MFiX's order."""
        meeting = {tuple(sorted(map(self.phases.index, (ball.kind for ball in self.balls))))}
        couples = []
        for m, n in combinations_with_replacement(range(len(self.phases)), 2):
            first, second = self._mass_radius(m), self._mass_radius(n)
            mass, radius = (a * b / (a + b) for a, b in zip(first, second, strict=True))
            couples.append(Couple(mass, radius, len(self.balls) == 2 and (m, n) in meeting))
        return tuple(couples)

    @cached_property
    def walls(self) -> tuple[Couple, ...]:
        """Return each phase with a wall."""
        there = bool(self.values["planes"])
        return tuple(Couple(*self._mass_radius(m), there) for m in range(len(self.phases)))

    def _mass_radius(self, phase: int) -> tuple[float, float]:
        diameter, density = self.phases[phase]
        return math.pi / 6.0 * diameter**3 * density, 0.5 * diameter

    def stiffnesses(self, couple: Couple) -> tuple[float, float]:
        """Return k_n and k_t, or those of Hertz's spring by the square root of the overlap."""
        if self.linear:
            k = self._number("normal_stiffness")
            return k, self.tangential_factor * k
        young, poisson = self._number("youngs_modulus"), self._number("poisson_ratio")
        root = math.sqrt(couple.radius)
        shear = young / (2.0 * (1.0 + poisson)) / (2.0 * (2.0 - poisson))
        return 4.0 / 3.0 * root * young / (2.0 * (1.0 - poisson**2)), 8.0 * root * shear

    def damping_ratio(self, couple: Couple) -> float:
        """Return the normal zeta; raise RequestError for one that is not less than 1."""
        if not couple.meets:
            return Contact(restitution=UNUSED).zeta
        damping, coefficient = self.values["damping"], self._number("damping_coefficient")
        if damping == "none":
            return 0.0
        if damping == "coeff_restitution":
            return Contact(restitution=self._number("restitution")).zeta
        eta = coefficient * couple.mass if damping == "mass_velocity" else coefficient
        zeta = eta / 2.0 / math.sqrt(self.stiffnesses(couple)[0] * couple.mass)
        if zeta >= 1.0:
            raise RequestError(f"has a damping ratio of less than 1, not {zeta:.4g}")
        return zeta

    def restitutions(self, couple: Couple) -> dict[str, float]:
        """Return the nominal restitutions that state both dashpots of a couple."""
        zeta = self.damping_ratio(couple)
        stiff, shear = self.stiffnesses(couple)
        # HERTZIAN's tangential dashpot is 2 zeta sqrt(k_t 2/7 m*)
        along = self._number("tangential_damping") * zeta * math.sqrt(3.5 * stiff / shear)
        if not self.linear and couple.meets and along >= 1.0:
            raise RequestError(f"has a tangential damping ratio of less than 1, not {along:.4g}")
        return {
            "normal": nominal_restitution(zeta),
            "tangential": nominal_restitution(min(along, 0.99)),
        }

    @cached_property
    def factor(self) -> float:
        """Return ``DTSOLID_FACTOR``, from MFiX's shortest contact time of two spheres."""
        times = []
        for couple in self.pairs:
            k, zeta = self.stiffnesses(couple)[0], self.damping_ratio(couple)
            times.append(math.pi / math.sqrt(k / couple.mass * (1.0 - zeta * zeta)))
        return min(times) / self.step

    @cached_property
    def reach(self) -> float:
        """Return how far a sphere goes at most [m], and some room."""
        time = self.step * self.steps
        g = math.hypot(self._number("gravity_x"), self._number("gravity_z"))
        fastest = max(math.hypot(ball.vx, ball.vz) for ball in self.balls)
        return fastest * time + 0.5 * g * time * time + 2.0 * max(b.radius for b in self.balls)

    @cached_property
    def origin(self) -> tuple[float, float]:
        """Return where the scene's origin is in the box [m]: the floor, if any, is its own."""
        x = self.reach - min(ball.x for ball in self.balls)
        if self.values["planes"]:
            return x, -self._number("floor")
        for ball in self.balls:
            if ball.held:
                return x, ball.radius - ball.z
        return x, self.reach - min(ball.z for ball in self.balls)

    @cached_property
    def box(self) -> tuple[float, float]:
        """Return width and height of the box [m]."""
        x, y = self.origin
        width = max(ball.x for ball in self.balls) + x + self.reach
        if self.values["planes"] == 2:
            return width, self._number("ceiling") + y
        return width, max(ball.z for ball in self.balls) + y + self.reach

    def particles(self) -> Iterator[tuple[float, ...]]:
        """Yield x, y, radius, density, vx, vy of spheres; a held one loses what it has at once."""
        x, y = self.origin
        g = self._number("gravity_x"), self._number("gravity_z")
        for ball in self.balls:
            if ball.held:
                part = FIRST_STEP[self.scheme] * self.step
                taken = (-part * g[0], -part * g[1])
                ball = replace(ball, vx=taken[0], vz=taken[1])
            yield ball.x + x, ball.z + y, ball.radius, ball.kind[1], ball.vx, ball.vz

    def context(self) -> dict[str, Any]:
        """Return the values of the template, numbers as numbers."""
        width, height = self.box
        young = (
            {} if self.linear else {n: self._number(n) for n in ("youngs_modulus", "poisson_ratio")}
        )
        return {
            **young,
            "phases": [
                dict(zip(("diameter", "density"), phase, strict=True)) for phase in self.phases
            ],
            "pairs": [self.restitutions(couple) for couple in self.pairs],
            "walls": [self.restitutions(couple) for couple in self.walls],
            "model": "LSD" if self.linear else "HERTZIAN",
            "stiffness": self._number("normal_stiffness"),
            "tangential_factor": self.tangential_factor,
            "damping_factor": self._number("tangential_damping"),
            "friction": self._number("friction"),
            "held": any(ball.held for ball in self.balls),
            "ceiling": self.values["planes"] == 2,
            "gravity_x": self._number("gravity_x"),
            "gravity_z": self._number("gravity_z"),
            "width": width,
            "height": height,
            "depth": max(diameter for diameter, _ in self.phases),
            "factor": self.factor,
            "scheme": self.scheme,
            "stop": (self.steps - 0.5) * self.step,
            "interval": self.every * self.step,
            # MFiX stops at once where a tenth of DT is more than TSTOP, else takes its own step
            "first": min(1e-4, self.steps * self.step),
        }


def _needs(values: ContactValues) -> str:
    """Return why an input cannot state a contact, or nothing where it can."""
    try:
        ContactInput(values)
    except RequestError as error:
        return str(error)
    return ""


_RULES = {
    "damping_in_cap": "until_sliding",
    "torque_lever": "circle",
    "velocity_lever": "circle",
    "wall_lever": "height",
    "spring_frame": "room",
    "frozen_mass": "own",
}
_STATES: States = {"clipped": ("no",), "motion_1": ("free",), "motion_2": ("free", "frozen")}

CONTACTS = (
    ContactModel("LSD", takes("hooke", DASHPOTS, "none linear_history") | _STATES, _RULES, _needs),
    ContactModel(
        "HERTZIAN",
        takes("hertz", "none coeff_restitution", "none mindlin") | _STATES,
        {**_RULES, "hertz_restitution": "linear"},
        _needs,
    ),
)
"""Its contact models; frictional torques act where the spheres' surfaces cut, springs keep their
direction in space, and a sliding spring is set to the limit without the dashpot."""


CONTACT = Contact(
    name="MFiX", restitution=1e-20, damping_ratio=None, tail="attractive", effective_mass="half"
)
"""The source's contact as MFiX has it: m_eff = m/2 also against a fixed sphere, not clipped."""


def _weakly_damped(values: ContactValues) -> str:
    """Return why a dashpot cannot be stated, or nothing where it can."""
    if values.get("damping") == "restitution" and float(values["restitution"]) < 1e-20:
        return "takes a restitution of at least 1e-20"
    if values.get("damping") == "ratio" and float(values["damping_ratio"]) > CONTACT.zeta:
        return f"takes a damping ratio of at most {CONTACT.zeta:g}"
    return ""


OBTAIN = (
    "build it (mfix.netl.doe.gov, MFiX 21.3.2, batch solver, cmake -DVERSION=21.3.2) "
    "and give --program mfix=PATH"
)

TRAITS = Traits(
    install_hint=OBTAIN,
    versions=("21.3.2",),
    integrator="mfix-euler",
    microseconds_per_step=32.0,
    frictionless=ContactModel(
        "contact",
        FRICTIONLESS | {"tail": ("attractive",), "effective_mass": ("half",)},
        needs=_weakly_damped,
    ),
    digits=7,
    contact_models=CONTACTS,
    # velocities first, by the forces at the start of a step
    contact_powers=(1.0,),
    title="MFiX",
    caveats=(
        "The effective mass against a fixed sphere is m/2: a nominal restitution of 1e-20 "
        "is really about 0.044.",
        "DTSOLID_FACTOR divides the damped contact time: at e = 1e-20 its default of 50 is "
        "4.8 steps per pi sqrt(m/k).",
        "A restitution of 0 divides by zero.",
        "No keyword holds a particle: the fixed spheres hang at a mass outflow of no velocity.",
        "A restart file left in the folder makes a new run stop.",
        "A particle's place in the arrays changes as it crosses a boundary: its global id "
        "does not.",
        "The search for neighbours loses contacts where its cells are less than two diameters "
        "wide: the inputs set DESGRIDSEARCH_IMAX and _JMAX.",
        "Paths are written in single precision.",
    ),
)
