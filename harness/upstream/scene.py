"""A run of LAMMPS as a scene: its commands from the log, bodies and groups from its first dump.

The commands are read as LAMMPS executed them, with variables filled in. Every command, keyword,
group and argument must be understood: else NotUnderstoodError names the word, and the test is not
held against the reference.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, combinations_with_replacement, pairwise
from typing import Any, NamedTuple

import numpy as np

from harness.errors import RequestError
from harness.model.conventions import Rules
from harness.model.law import Law
from harness.model.scene import Body, Scene, Segment, Wall
from harness.upstream.definition import MEMBER, RECORDED, Floats, State, UpstreamTest

Words = Sequence[str]


class NotUnderstoodError(RequestError):
    """A word of a test without a counterpart in a scene: the test is not tested."""


# ---- the commands that LAMMPS executed, and the words that are understood

Keywords = Mapping[str, int]  # keywords by the number of their arguments

FREE = frozenset((
    "boundary", "region", "create_box", "create_atoms", "lattice", "velocity", "compute",
    "displace_atoms", "delete_atoms", "change_box", "variable", "thermo", "thermo_style", "dump",
    "dump_modify", "undump", "uncompute", "print", "info", "timer", "processors", "pair_style",
    "pair_coeff", "unfix", "neighbor", "timestep",
))  # fmt: skip
# commands whose effect is in the first dump, that move nothing, or that are read below
COMMANDS: Mapping[str, Keywords] = {
    "units": {"si": 0, "cgs": 0, "lj": 0, "micro": 0, "nano": 0},
    "dimension": {"2": 0, "3": 0},
    "newton": {"on": 0, "off": 0},
    "atom_style": {"sphere": 0},
    "atom_modify": {"map": 1, "sort": 2},
    "comm_modify": {"vel": 1, "mode": 1, "cutoff": 1},
    "run_style": {"verlet": 0},
    "run": {"0": 0, "post": 1},
    "neigh_modify": {"delay": 1, "every": 1, "check": 1, "page": 1, "one": 1, "cluster": 1},
    "if": {"then": 0, "elif": 0, "else": 0},
}
SETTABLE: Keywords = {"type": 1, "diameter": 1, "density": 1, "density/disc": 1, "mass": 1,
                      "x": 1, "y": 1, "z": 1, "vx": 1, "vy": 1, "vz": 1, "omega": 3}  # fmt: skip
FIXES: Mapping[str, tuple[int, Keywords]] = {
    "nve/sphere": (0, {"disc": 0, "update": 1}),
    "nve/noforce": (0, {}),
    "freeze": (0, {}),
    "enforce2d": (0, {}),
    "gravity": (1, {"vector": 3}),
    "viscous": (1, {}),
    **dict.fromkeys(("wall/gran", "print", "ave/time"), (99, {})),
}  # leading arguments and keywords; all of those that move nothing, or are read below
QUOTED = r'"([^"]*)"'
MOTION = {"run_pos": "position", "run_vel": "velocity", "run_omega": "angular_velocity"}
ACTING = frozenset(("gravity", "viscous", "wall/gran"))
PLANES = {"xplane": 0, "yplane": 1, "zplane": 2}
WALL_TYPES = 1001  # types of walls from here on: each has its own law
SKINS = {"lj": "0.3", "si": "0.001"}  # of neighbour lists by default
DELAY = 10  # steps that a neighbour list lasts by default, in releases before 2023


def executed_commands(test: UpstreamTest, log: str) -> Iterator[Words]:
    """Yield the commands of a run as LAMMPS executed them, with variables filled in.

    The log has each as it was typed, then once more for each variable; those of ``if`` as well.
    """
    chunks = re.split(r"^COMMAND \w+\n", log, flags=re.MULTILINE)[1:]
    for number, typed in enumerate(test.commands):
        lines = chunks[number].splitlines() if len(chunks) > number else []
        if typed not in lines:
            raise NotUnderstoodError(f"{typed!r} is not in the log")
        yield from _executed(typed, lines)


def _executed(typed: str, lines: list[str]) -> Iterator[Words]:
    if typed not in lines:  # of an if, in the branch that was not taken
        return
    at = lines.index(typed)
    while "$" in (unquoted := re.sub(QUOTED, "", lines[at])) and at + 1 < len(lines):
        at += 1
    if not unquoted.startswith("if "):
        yield lines[at].split()
        return
    check_words(unquoted.split())
    for inner in re.findall(QUOTED, lines[at]):
        yield from _executed(inner, lines)


def check_words(words: Words) -> None:
    """Raise NotUnderstoodError, naming the word, for a command that is not wholly understood."""
    command, *rest = words
    if command == "set":
        _check(command, rest[2:], SETTABLE)
    elif command == "group":
        _check(command, [word for word in rest if word == "dynamic"], {})
    elif command == "fix":
        style = rest[2]
        _check(command, [style], dict.fromkeys(FIXES, 0))
        leading, keywords = FIXES[style]
        _check(f"fix {style}", rest[3 + leading :], keywords)
    elif command not in FREE:
        _check("command", [command], dict.fromkeys(COMMANDS, 0))
        _check(command, rest, COMMANDS[command])


def _check(command: str, words: Words, keywords: Keywords) -> None:
    """Raise NotUnderstoodError for a word that is no keyword and no argument of one."""
    at = 0
    while at < len(words):
        if words[at] not in keywords:
            raise NotUnderstoodError(f"{command}: {words[at]!r} is not understood")
        at += 1 + keywords[words[at]]


def _float(word: str, command: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise NotUnderstoodError(f"{command}: {word!r} is not understood") from None


# ---- the scene


@dataclass(frozen=True)
class Reading:
    """A scene with the rules of LAMMPS for it, the steps at which segments end, and its list.

    A neighbour list lasts ``list_steps``, in which bodies may come nearer by ``skin`` [length].
    ``setups`` are the forces computed before the first step.
    """

    scene: Scene
    rules: Rules
    ends: tuple[int, ...]
    skin: float
    list_steps: int
    setups: int


def read_scene(test: UpstreamTest, log: str, state: State, timestep: float) -> Reading:
    """Return the scene of a run: its log, its first dump and its step [time].

    Raise NotUnderstoodError for a word that a scene has no counterpart of, RequestError for a
    scene that the reference does not take.
    """
    commands = _read_commands(test, log)
    fixes, last = commands.fixes, commands.last
    bodies, style = _bodies(fixes, state), last["pair_style"][0]
    walls: list[Wall] = []
    laws = _pair_laws(last["pair_style"], commands.coefficients, state["type"])
    for group, _, *wall_words in _of_style(fixes, "wall/gran"):
        law, planes = _planes(wall_words, WALL_TYPES + len(walls), _members(state, group))
        walls += planes
        laws |= {(int(kind), wall.type): law for kind in state["type"] for wall in planes}
    ends = tuple(accumulate(test.segments))
    steps = max(ends[-1], 1)
    scene = Scene(
        bodies=bodies,
        walls=tuple(walls),
        laws=laws,
        gravity=_gravity(fixes),
        drag=sum(_float(words[2], "fix viscous") for words in _of_style(fixes, "viscous")),
        period=_period(state, flat=last["dimension"] == ["2"]),
        step=timestep,
        steps=steps,
        every=math.gcd(*ends) or 1,
        segments=_segments(bodies, steps),
        setups=ends[:-1],
        pairs=() if style == "none" else None,
    )
    if last["dimension"] == ["2"]:
        _check_flat(scene, state)
    rules = Rules(torque_lever="radius" if style.startswith("gran/") else "contact_point")
    skin = last.get("neighbor", [SKINS.get(last["units"][0], "0.1")])[0]
    return Reading(
        scene, rules, ends, _float(skin, "neighbor"), commands.list_steps, commands.setups
    )


class _Commands(NamedTuple):
    """The words of a run: fixes from the group on, and those of each command's last one."""

    fixes: list[Words]
    last: dict[str, Words]
    coefficients: list[Words]
    list_steps: int
    setups: int


def _read_commands(test: UpstreamTest, log: str) -> _Commands:
    by_name: dict[str, Words] = {}
    last: dict[str, Words] = {"dimension": ["3"], "units": ["lj"]}
    coefficients: list[Words] = []
    listing, setups = {"delay": DELAY, "every": DELAY}, 1
    for executed in executed_commands(test, log):
        check_words(executed)
        command, words = executed[0], list(executed[1:])
        last[command] = words
        setups += command == "run"
        if command == "fix":
            by_name[words[0]] = words[1:]
        elif command == "unfix":
            by_name.pop(words[0], None)
        elif command == "pair_style":
            coefficients.clear()
        elif command == "pair_coeff":
            coefficients.append(words)
        elif command == "neigh_modify":
            named = [(name, word) for name, word in pairwise(words) if name in listing]
            listing |= {name: int(_float(word, command)) for name, word in named}
    steps = max(listing.values())
    return _Commands(list(by_name.values()), last, coefficients, steps, setups)


def _period(state: State, *, flat: bool) -> tuple[float | None, float | None, float | None]:
    x, y, z = (None if math.isnan(length) else float(length) for length in state["period"])
    return x, y, None if flat else z


def _segments(bodies: Sequence[Body], steps: int) -> tuple[Segment, ...]:
    """Return the prescribed motion of bodies of which forces move none."""
    if any(body.motion == "free" for body in bodies):
        return ()
    velocities = tuple(body.velocity for body in bodies)
    spins = tuple(body.angular_velocity for body in bodies)
    return (Segment(steps=steps, velocities=velocities, angular_velocities=spins),)


def _check_flat(scene: Scene, state: State) -> None:
    leaves = any(state[name].any() for name in ("vz", "omegax", "omegay")) or scene.gravity[2]
    if leaves or np.ptp(state["z"]):
        raise NotUnderstoodError("dimension 2: a sphere that leaves the plane is not understood")


def _of_style(fixes: Sequence[Words], style: str) -> list[Words]:
    """Return the fixes of a style, as words from the group on."""
    return [words for words in fixes if words[1] == style]


def _members(state: State, group: str) -> Floats:
    if MEMBER + group not in state:
        raise NotUnderstoodError(f"group {group}: its atoms are not known")
    return state[MEMBER + group]


def _bodies(fixes: Sequence[Words], state: State) -> tuple[Body, ...]:
    def count(style: str, word: str = "") -> Floats:
        """Return how many fixes of a style, and with a word, have each body."""
        chosen = (words for words in _of_style(fixes, style) if not word or word in words[2:])
        return sum((_members(state, words[0]) for words in chosen), np.zeros(len(state["id"])))

    if not len(state["id"]):
        raise NotUnderstoodError("it has no sphere at the start")
    moved, carried, frozen = map(count, ("nve/sphere", "nve/noforce", "freeze"))
    if (moved + carried).max() > 1.0:
        raise NotUnderstoodError("fix nve/sphere: a sphere is moved twice")
    styles = [words[1] for words in fixes]
    late = set(styles[styles.index("freeze") :]) & ACTING if frozen.any() else set()
    if late:
        raise NotUnderstoodError(f"fix {min(late)}: after fix freeze it is not understood")
    if frozen.any() and not np.any(moved > frozen):
        raise NotUnderstoodError("fix freeze: no sphere is left to move")
    for words in _of_style(fixes, "gravity") + _of_style(fixes, "viscous"):
        if np.any(moved > _members(state, words[0])):
            raise NotUnderstoodError(f"fix {words[1]}: group {words[0]!r} is not all that moves")
    bodies = []
    for i, disc in enumerate(count("nve/sphere", "disc")):
        radius, mass = float(state["radius"][i]), float(state["mass"][i])
        places = [tuple(float(state[name][i]) for name in RECORDED[table]) for table in MOTION]
        if not moved[i] and not carried[i] and any(places[1] + places[2]):
            raise NotUnderstoodError(f"sphere {i + 1}: has a velocity, and no fix moves it")
        values: dict[str, Any] = dict(zip(MOTION.values(), places, strict=True))
        values["motion"] = "frozen" if frozen[i] else "free" if moved[i] else "held"
        inertia = 0.5 * mass * radius**2 if disc else None
        kind = int(state["type"][i])
        bodies.append(Body(radius=radius, mass=mass, inertia=inertia, type=kind, **values))
    return tuple(bodies)


def _gravity(fixes: Sequence[Words]) -> tuple[float, float, float]:
    total = np.zeros(3)
    for words in _of_style(fixes, "gravity"):
        size, *direction = (_float(word, "fix gravity") for word in (words[2], *words[4:]))
        if len(direction) != 3:
            raise NotUnderstoodError("fix gravity: without a vector it is not understood")
        total += size * np.array(direction) / math.hypot(*direction)
    x, y, z = total.tolist()
    return x, y, z


def _planes(words: Words, kind: int, members: Floats) -> tuple[Law, list[Wall]]:
    """Return the law and the planes of the words of a flat ``fix wall/gran``, of type ``kind``."""
    place = next((at for at, word in enumerate(words) if word in PLANES), len(words))
    _check("fix wall/gran", words[place + 3 :], {})
    style, *numbers = words[:place]
    law = granular_law(numbers) if style == "granular" else old_law(style, numbers)
    axis, bodies = np.eye(3)[PLANES[words[place]]], tuple(np.flatnonzero(members).tolist())
    walls = []
    for word, sign in zip(words[place + 1 :], (1.0, -1.0), strict=True):
        if word != "NULL":
            point, normal = _float(word, "fix wall/gran") * axis, sign * axis
            walls.append(Wall(point=tuple(point), direction=tuple(normal), type=kind,
                              bodies=bodies))  # fmt: skip
    return law, walls


# ---- laws

ETA, SLIDER = "damping_coefficient", ("tangential_damping", "friction")
MATERIAL = ("youngs_modulus", ETA, "poisson_ratio")
LINEAR, MINDLIN = ("tangential_stiffness", *SLIDER), ("tangential_modulus", *SLIDER)
SDS = ("stiffness", "damping", "friction")
PARTS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "normal": {"hooke": ("normal_stiffness", ETA), "hertz": ("normal_modulus", ETA),
               "hertz/material": MATERIAL,
               **dict.fromkeys(("dmt", "jkr"), (*MATERIAL, "surface_energy"))},
    "damping": dict.fromkeys(("none", "velocity", "mass_velocity", "viscoelastic", "tsuji",
                              "coeff_restitution"), ()),
    "tangential": {"linear_nohistory": SLIDER,
                   **dict.fromkeys(("linear_history", "linear_history_classic"), LINEAR),
                   **dict.fromkeys(("mindlin", "mindlin/force", "mindlin_rescale",
                                    "mindlin_rescale/force", "mindlin_classic"), MINDLIN)},
    "rolling": {"none": (), "sds": tuple(f"rolling_{name}" for name in SDS)},
    "twisting": {"none": (), "marshall": (), "sds": tuple(f"twisting_{name}" for name in SDS)},
    "heat": {"none": ()},
}  # fmt: skip
# submodels of pair_style granular, and their coefficients in the order of LAMMPS


def granular_law(words: Words) -> Law:
    """Return the law of the words of ``pair_style granular``; raise NotUnderstoodError."""
    values: dict[str, Any] = {"damping": "viscoelastic"}
    rest = ["normal", *words]
    while rest:
        part = rest.pop(0)
        if part == "limit_damping":
            values["clipped"] = True
            continue
        _check("granular", [part], dict.fromkeys(PARTS, 0))
        _check(part, rest[:1] or [""], dict.fromkeys(PARTS[part], 0))
        model = rest.pop(0)
        values[part] = model.removesuffix("/material")
        for name in PARTS[part][model]:
            word = rest.pop(0) if rest else ""
            null = word == "NULL" and name == "tangential_modulus"
            values[name] = None if null else _float(word, f"{part} {model}")
    return _law(values)


def _law(values: dict[str, Any]) -> Law:
    """Return a law without the parts whose coefficients are zero."""
    eta = values.pop(ETA, 0.0)
    if values["damping"] in ("tsuji", "coeff_restitution"):
        values["restitution"] = eta
    elif eta and values["damping"] != "none":
        values[ETA] = eta
    else:
        values["damping"] = "none"
    dashpot = values["damping"] != "none" and values.get("tangential_damping")
    acts = values.get("friction") or values.get("twisting") == "marshall"
    if not acts or (values.get("tangential") == "linear_nohistory" and not dashpot):
        for name in ("tangential", *LINEAR, *MINDLIN):
            values.pop(name, None)
    try:
        return Law(**values)
    except RequestError as error:
        raise NotUnderstoodError(f"its law is not one of the reference: {error}") from None


def old_law(style: str, words: Words) -> Law:
    """Return the law of ``hooke``, ``hooke/history`` or ``hertz/history`` and its numbers.

    Raise NotUnderstoodError for another style, or a word that does not belong to it.
    """
    _check("wall or gran", [style], {"hooke": 0, "hooke/history": 0, "hertz/history": 0})
    _check(style, words[6:], {"limit_damping": 0})
    k_n, eta, mu = (_float(words[at], style) for at in (0, 2, 4))
    k_t = k_n * 2.0 / 7.0 if words[1] == "NULL" else _float(words[1], style)
    along = 0.5 * eta if words[3] == "NULL" else _float(words[3], style)
    along = 0.0 if words[5] == "0" else along
    if along and not eta:
        raise NotUnderstoodError(f"{style}: gamma_t = {along} without gamma_n is not understood")
    values: dict[str, Any] = {"interface": "old", "clipped": "limit_damping" in words, ETA: eta,
                              "tangential_damping": along / eta if eta else 0.0,
                              "friction": mu}  # fmt: skip
    if style == "hertz/history":
        values |= {"normal": "hertz", "normal_modulus": k_n, "damping": "viscoelastic"}
        values |= {"tangential": "mindlin_classic", "tangential_modulus": k_t}
    else:
        values |= {"normal": "hooke", "normal_stiffness": k_n, "damping": "mass_velocity"}
        values |= {"tangential": "linear_nohistory"}
        if style == "hooke/history":
            values |= {"tangential": "linear_history_classic", "tangential_stiffness": k_t}
    return _law(values)


def _pair_laws(
    style: Words, coefficients: Sequence[Words], types: Floats
) -> dict[tuple[int, int], Law]:
    """Return the laws of all pairs of types that are there."""
    kinds = sorted({int(kind) for kind in types})
    pairs = list(combinations_with_replacement(kinds, 2)) if len(types) > 1 else []
    if style[0].startswith("gran/"):
        return dict.fromkeys(pairs, old_law(style[0].removeprefix("gran/"), style[1:]))
    _check("pair_style", style, {"granular": 0, "none": 0})
    stated: dict[tuple[int, int], Law] = {}
    for first, second, *words in coefficients:
        for i, j in pairs:
            if any(_covers(first, a) and _covers(second, b) for a, b in ((i, j), (j, i))):
                stated[i, j] = granular_law(words)
    pairs = pairs if stated else []
    return {(i, j): stated.get((i, j)) or mixed_law(stated[i, i], stated[j, j]) for i, j in pairs}


def _covers(span: str, kind: int) -> bool:
    """Return whether a type is in ``2``, ``*``, ``2*``, ``*3`` or ``2*3``."""
    if not re.fullmatch(r"\d+|\d*\*\d*", span):
        raise NotUnderstoodError(f"pair_coeff: {span!r} is not understood")
    low, star, high = span.partition("*")
    return int(low or 1) <= kind <= (int(high or kind) if star else int(low))


def mixed_law(first: Law, second: Law) -> Law:
    """Return the law that LAMMPS's manual has for two types: two materials, geometric means."""
    values: dict[str, Any] = {}
    for name, value in first:
        other = getattr(second, name)
        if name in ("youngs_modulus", "poisson_ratio"):
            values |= {name: value, f"partner_{name}": other}
        elif isinstance(value, float) and isinstance(other, float):
            values[name] = math.sqrt(value * other)
        elif value != other:
            raise NotUnderstoodError(f"pair_coeff: types of other {name} are not mixed here")
        elif not name.startswith("partner_"):
            values[name] = value
    return Law(**values)
