"""A test of LAMMPS's ``unittest/granular`` and its run as a scene.

The commands are read as LAMMPS executed them, with variables filled in; bodies and groups are
those of the first dump. Every command, keyword, group and argument must be understood: else
NotUnderstoodError names the word, and the test is not compared with the reference.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate, combinations_with_replacement, pairwise
from typing import Any

import numpy as np

from harness.engines.lammps.words import DAMPINGS
from harness.errors import RequestError
from harness.model.conventions import Rules
from harness.model.law import SUBMODELS, Law
from harness.model.scene import Body, Floats, Motion, Scene, Segment, Wall
from harness.solvers import reference

State = Mapping[str, Floats]  # columns of a dump, and "period" of the box [length], NaN without
Words = Sequence[str]
Keywords = Mapping[str, int]  # keywords by the number of their arguments
Laws = dict[tuple[int, int], Law]

RECORDED = {"run_pos": ("x", "y", "z"), "run_vel": ("vx", "vy", "vz"),
            "run_torque": ("tqx", "tqy", "tqz"),
            "run_omega": ("omegax", "omegay", "omegaz")}  # fmt: skip
# recorded tables, and the columns of a dump with the same quantity
COLUMNS = ("id", "type", *(name for names in RECORDED.values() for name in names), "fx", "fy",
           "fz", "radius", "mass")  # fmt: skip
MOST_SAMPLES = 100_000  # of all spheres, more where the ends of segments have no larger divisor
MEMBER = "dem_harness_member_"  # column that is 1 for the atoms of a group


class NotUnderstoodError(RequestError):
    """A word of a test without a counterpart in a scene: the test is not tested."""


@dataclass(frozen=True)
class UpstreamTest:
    """A test: its commands, segments in steps, and its record.

    ``recorded`` maps ``run_pos`` and the like to rows (segment, atom, x, y, z), shape (M, 5).
    ``tolerance`` is that of upstream's closed form after segment ``judged_segment``; NaN without
    one.
    """

    name: str
    commands: tuple[str, ...]
    segments: tuple[int, ...]
    epsilon: float = 1e-10
    recorded: Mapping[str, Floats] = field(default_factory=dict, compare=False)
    tolerance: float = math.nan
    judged_segment: int = 0

    def script(self, newton: str = "off") -> str:
        """Return the LAMMPS input: the driver's commands, each after its number, and dumps."""
        lines = [f"newton {newton}"]
        for number, command in enumerate(self.commands):
            lines += [f'print "COMMAND {number}"', command]
        lines += ['print "COMMAND end"', 'print "TIMESTEP $(dt:%.17g)"']
        members = [name for name in self.columns if name.startswith(MEMBER)]
        lines += [f"variable {name} atom gmask({name.removeprefix(MEMBER)})" for name in members]
        columns = " ".join(self.columns).replace(MEMBER, f"v_{MEMBER}")
        for number, steps in enumerate((0, *self.segments)):
            lines += [
                f"run {steps} post no",
                f"write_dump all custom state.{number} {columns} modify sort id format float %.17g",
            ]
        return "\n".join([*lines, 'print "RESULT verdict = finished"', ""])

    @property
    def columns(self) -> list[str]:
        """Return the columns of its dumps: of the motion, and the members of each group."""
        groups = [words for words in map(str.split, self.commands) if words[:1] == ["group"]]
        names = dict.fromkeys(["all", *(w[1] for w in groups if re.fullmatch(r"\w+", w[1]))])
        deleted = {words[1] for words in groups if words[2:3] == ["delete"]}
        return [*COLUMNS, *(f"{MEMBER}{name}" for name in names if name not in deleted)]


@dataclass(frozen=True)
class Reading:
    """A scene with the rules of LAMMPS for it, the steps at which segments end, and its list.

    A neighbour list lasts ``list_steps``, in which bodies may come nearer by ``skin`` [length].
    """

    scene: Scene
    rules: Rules
    ends: tuple[int, ...]
    skin: float
    list_steps: int

    @cached_property
    def motion(self) -> Motion:
        """The motion of the reference: at the ends of segments, where it may rest, and between."""
        return reference.run(self.scene, self.rules)


def read_scene(test: UpstreamTest, log: str, state: State, timestep: float) -> Reading:
    """Return the scene of a run: its log, its first dump and its step [time].

    Raise NotUnderstoodError for a word that a scene has no counterpart of, RequestError for a
    scene that the reference does not take.
    """
    commands = _Commands(test, log)
    bodies, gravity = _bodies(commands, state), _gravity(commands.fixes_of("gravity"))
    walls, at_walls = _walls(commands, bodies, state)
    laws = {**_pair_laws(commands, state["type"]), **at_walls}
    if commands.moved and any(law.normal == "jkr" for law in laws.values()):  # necks remain
        raise NotUnderstoodError(f"jkr: {commands.moved!r} after a run is not understood")
    starts = (0, *accumulate(test.segments))
    steps, ends = max(starts[-1], 1), starts[1:]
    if any(start and start == end for start, end in pairwise(starts)):
        raise NotUnderstoodError("run_segments: '0' after a step is not understood")
    divisor = math.gcd(*ends) or 1
    every = min(divisor, max(1, steps * len(bodies) // MOST_SAMPLES))
    while divisor % every:  # each end is a sample
        every -= 1
    at_start = Segment(
        steps=steps,
        velocities=tuple(body.velocity for body in bodies),
        angular_velocities=tuple(body.angular_velocity for body in bodies),
    )
    flat = commands.last["dimension"] == ["2"]
    out_of_plane = any(state[name].any() for name in ("vz", "omegax", "omegay"))
    if flat and (out_of_plane or gravity[2] or np.ptp(state["z"])):
        raise NotUnderstoodError("dimension 2: a sphere that leaves the plane is not understood")
    x, y, z = (None if math.isnan(length) else float(length) for length in state["period"])
    style = commands.last["pair_style"][0]
    scene = Scene(
        bodies=bodies,
        walls=walls,
        law=next(iter(laws.values()), Law()),
        laws=laws,
        gravity=gravity,
        drag=sum(_float(words[2], "fix viscous") for words in commands.fixes_of("viscous")),
        period=(x, y, None if flat else z),
        step=timestep,
        steps=steps,
        every=every,
        segments=() if any(body.motion == "free" for body in bodies) else (at_start,),
        setups=(*[0] * commands.runs, *starts[:-1]),
        pairs=() if style == "none" else None,
    )
    rules = Rules(torque_lever="radius" if style.startswith("gran/") else "contact_point")
    default = SKINS.get(commands.last["units"][0], "0.1")
    skin = _float(commands.last.get("neighbor", [default])[0], "neighbor")
    return Reading(scene, rules, ends, skin, commands.list_steps(steps))


# ---- commands

COMMANDS: Mapping[str, tuple[int, Keywords] | None] = {
    # their effect is in the first dump, they move nothing, or they are read below
    **dict.fromkeys((
        "boundary", "region", "create_box", "create_atoms", "lattice", "velocity", "compute",
        "displace_atoms", "delete_atoms", "change_box", "variable", "thermo", "thermo_style",
        "dump", "dump_modify", "undump", "uncompute", "print", "info", "processors",
        "pair_style", "pair_coeff", "unfix", "neighbor", "timestep", "group", "fix wall/gran",
        "fix print", "fix ave/time",
    )),
    # leading arguments, and the keywords that are understood
    "units": (0, dict.fromkeys(("si", "cgs", "lj", "micro", "nano"), 0)),
    "dimension": (0, {"2": 0, "3": 0}),
    "newton": (0, {"on": 0, "off": 0}),
    "atom_style": (0, {"sphere": 0}),
    "atom_modify": (0, {"map": 1, "sort": 2}),
    "comm_modify": (0, {"vel": 1, "mode": 1, "cutoff": 1}),
    "run_style": (0, {"verlet": 0}),
    "run": (0, {"0": 0, "post": 1}),
    "neigh_modify": (0, dict.fromkeys(("delay", "every", "check", "page", "one", "cluster"), 1)),
    "set": (2, {**dict.fromkeys(("type", "diameter", "density", "density/disc", "mass", "x", "y",
                                 "z", "vx", "vy", "vz"), 1), "omega": 3}),
    "fix nve/sphere": (0, {"disc": 0, "update": 1}),
    "fix nve/noforce": (0, {}),
    "if": (0, {"then": 0, "elif": 0, "else": 0}),
    "fix enforce2d": (0, {}),
    "fix gravity": (1, {"vector": 3}),
    "fix viscous": (1, {}),
    "timer": (0, dict.fromkeys(("off", "loop", "normal", "full", "sync", "nosync"), 0)),
}  # fmt: skip
QUOTED = re.compile(r'"([^"]*)"')
LIST = {"delay": "10", "every": "1", "check": "yes"}  # by default; delay 0 from 2023 on
CHANGES = {"set", "create_atoms", "displace_atoms", "delete_atoms", "change_box"}  # of places
SKINS = {"lj": "0.3", "si": "0.001"}  # of neighbour lists by default, 0.1 in other units


class _Commands:
    """The words of a run: those of each command's last one, of fixes from the group on."""

    def __init__(self, test: UpstreamTest, log: str) -> None:
        self.last: dict[str, Words] = {"dimension": ["3"], "units": ["lj"]}
        self.fixes: dict[str, Words] = {}  # by name
        self.coefficients: list[Words] = []
        self._list = dict(LIST)
        self.runs, self.moved = 0, ""
        for command, *words in executed_commands(test, log):
            check_words([command, *words])
            if self.runs and command in CHANGES:
                self.moved = command
            self.last[command] = words
            if command == "run":
                self.runs += 1
            elif command == "fix":
                self.fixes[words[0]] = words[1:]
            elif command == "unfix":
                self.fixes.pop(words[0], None)
            elif command == "pair_style":
                self.coefficients.clear()
            elif command == "pair_coeff":
                self.coefficients.append(words)
            elif command == "neigh_modify":
                self._list.update(zip(words[::2], words[1::2], strict=True))

    def fixes_of(self, style: str) -> list[Words]:
        """Return the fixes of a style, as words from the group on."""
        return [words for words in self.fixes.values() if words[1] == style]

    def list_steps(self, steps: int) -> int:
        """Return how many of so many steps a neighbour list may last without a look at it.

        Where bodies are looked at only each ``every`` steps, one may have moved nearly half of the
        skin at a look, and no list is safe.
        """
        delay, every = (int(_float(self._list[word], word)) for word in ("delay", "every"))
        if every > 1 and self._list["check"] not in ("no", "off", "false"):
            return steps
        return every * max(1, math.ceil(delay / every))


def executed_commands(test: UpstreamTest, log: str) -> Iterator[Words]:
    """Yield the commands of a run as LAMMPS executed them, with variables filled in.

    The log has each as it was typed, then once more for each variable; those of ``if`` as well.
    """
    chunks = re.split(r"^COMMAND \w+\n", log, flags=re.MULTILINE)[1:]
    for number, typed in enumerate(test.commands):
        lines = chunks[number].splitlines() if len(chunks) > number else []
        if typed not in lines:
            raise NotUnderstoodError(f"{typed!r} is not in the log")
        if not typed.startswith("if "):
            yield _executed(typed, lines)
            continue
        check_words(QUOTED.sub("", " ".join(_executed(typed, lines))).split())
        branches = [branch for branch in QUOTED.findall(typed) if branch in lines]
        yield from (_executed(branch, lines) for branch in branches)


def _executed(typed: str, lines: list[str]) -> Words:
    at = lines.index(typed)
    while "$" in QUOTED.sub("", lines[at]) and at + 1 < len(lines):
        at += 1
    return lines[at].split()


def check_words(words: Words) -> None:
    """Raise NotUnderstoodError, naming the word, for a command that is not wholly understood."""
    name, rest = words[0], words[1:]
    if name == "fix":
        name, rest = f"fix {words[3]}", words[4:]
    if name not in COMMANDS:
        raise NotUnderstoodError(f"{name!r} is not understood")
    if name == "group" and "dynamic" in rest:
        raise NotUnderstoodError("group: 'dynamic' is not understood")
    if (row := COMMANDS[name]) is not None:
        leading, keywords = row
        _check_keywords(name, rest[leading:], keywords)


def _check_keywords(command: str, words: Words, keywords: Keywords) -> None:
    at = 0
    while at < len(words):
        _check_word(command, words[at], keywords)
        at += 1 + keywords[words[at]]


def _check_word(command: str, word: str, allowed: Container[str]) -> None:
    if word not in allowed:
        raise NotUnderstoodError(f"{command}: {word!r} is not understood")


def _float(word: str, command: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise NotUnderstoodError(f"{command}: {word!r} is not understood") from None


# ---- bodies, gravity, walls

START = {"position": "run_pos", "velocity": "run_vel", "angular_velocity": "run_omega"}
PLANES = {"xplane": 0, "yplane": 1, "zplane": 2}
WALL_TYPES = 1001  # types of walls from here on: each has its own law


def _members(state: State, group: str) -> Floats:
    if MEMBER + group not in state:
        raise NotUnderstoodError(f"group {group}: its atoms are not known")
    return state[MEMBER + group]


def _bodies(commands: _Commands, state: State) -> tuple[Body, ...]:
    def fixes_on(style: str, word: str = "") -> Floats:
        """Return how many fixes of a style, and with a word, act on each body."""
        fixes = [words for words in commands.fixes_of(style) if not word or word in words[2:]]
        return sum((_members(state, fix[0]) for fix in fixes), np.zeros(len(state["id"])))

    if not len(state["id"]):
        raise NotUnderstoodError("it has no sphere at the start")
    free, carried = fixes_on("nve/sphere"), fixes_on("nve/noforce")
    discs = fixes_on("nve/sphere", "disc")
    if (free + carried).max() > 1.0:
        raise NotUnderstoodError("fix nve/sphere: a sphere is moved twice")
    for group, style, *_ in commands.fixes_of("gravity") + commands.fixes_of("viscous"):
        members = _members(state, group)
        if np.any(free > members):
            raise NotUnderstoodError(f"fix {style}: group {group!r} is not all that moves")
        if not free.any() and members.any():  # the dumped forces have it, the reference's do not
            raise NotUnderstoodError(f"fix {style}: no sphere is free")
    bodies = []
    for i, (radius, mass) in enumerate(zip(state["radius"], state["mass"], strict=True)):
        start: dict[str, Any] = {
            name: tuple(float(state[column][i]) for column in RECORDED[table])
            for name, table in START.items()
        }
        if not free[i] and not carried[i] and any(start["velocity"] + start["angular_velocity"]):
            raise NotUnderstoodError(f"sphere {i + 1}: has a velocity, and no fix moves it")
        inertia = 0.5 * mass * radius**2 if discs[i] else None
        bodies.append(Body(radius=radius, mass=mass, type=int(state["type"][i]), inertia=inertia,
                           motion="free" if free[i] else "held", **start))  # fmt: skip
    return tuple(bodies)


def _gravity(fixes: Sequence[Words]) -> tuple[float, float, float]:
    total = np.zeros(3)
    for words in fixes:
        size, *direction = (_float(word, "fix gravity") for word in (words[2], *words[4:]))
        if len(direction) != 3:
            raise NotUnderstoodError("fix gravity: without a vector it is not understood")
        total += size * np.array(direction) / math.hypot(*direction)
    x, y, z = total.tolist()
    return x, y, z


def _walls(
    commands: _Commands, bodies: Sequence[Body], state: State
) -> tuple[tuple[Wall, ...], Laws]:
    """Return the planes of flat ``fix wall/gran``, and their laws by the types of body and wall."""
    walls: list[Wall] = []
    laws: Laws = {}
    for group, _, style, *words in commands.fixes_of("wall/gran"):
        place = next((at for at, word in enumerate(words) if word in PLANES), len(words))
        _check_keywords("fix wall/gran", words[place + 3 :], {})
        law = granular_law(words[:place]) if style == "granular" else old_law(style, words[:place])
        axis = np.eye(3)[PLANES[words[place]]]
        members = tuple(np.flatnonzero(_members(state, group)).tolist())
        kind = WALL_TYPES + len(walls)
        ends = zip(words[place + 1 :], (-math.inf, math.inf), strict=True)
        low, high = (end if word == "NULL" else _float(word, "fix wall/gran") for word, end in ends)
        if high - low < 2.0 * max((bodies[member].radius for member in members), default=0.0):
            raise NotUnderstoodError("fix wall/gran: of two planes the nearer one alone acts")
        for height, sign in ((low, 1.0), (high, -1.0)):
            if math.isfinite(height):
                point, direction = tuple(height * axis), tuple(sign * axis)
                walls.append(Wall(point=point, direction=direction, type=kind, bodies=members))
        laws |= {(body.type, kind): law for body in bodies}
    return tuple(walls), laws


# ---- laws

ETA = "damping_coefficient"
MATERIAL = ("youngs_modulus", ETA, "poisson_ratio")
NORMAL = {"hooke": ("normal_stiffness", ETA), "hertz": ("normal_modulus", ETA),
          "hertz/material": MATERIAL,
          **dict.fromkeys(("dmt", "jkr"), (*MATERIAL, "surface_energy"))}  # fmt: skip
# coefficients of submodels in the order of LAMMPS
MODELS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "normal": NORMAL,
    "damping": dict.fromkeys(("none", *DAMPINGS), ()),
    "tangential": {
        name: (*(("tangential_modulus",) if name.startswith("mindlin") else ()), *model.needs)
        for name, model in SUBMODELS["tangential"].items()
    },
    "rolling": {"none": (), "sds": SUBMODELS["rolling"]["sds"].needs},
    "twisting": {"none": (), **{n: model.needs for n, model in SUBMODELS["twisting"].items()}},
    "heat": {"none": ()},
}
TANGENTIAL = {"tangential", *(name for names in MODELS["tangential"].values() for name in names)}
OLD_STYLES = {  # in the words of pair_style granular
    "hooke": "hooke {k} {eta} damping mass_velocity tangential linear_nohistory {x} {mu}",
    "hooke/history":
        "hooke {k} {eta} damping mass_velocity tangential linear_history_classic {kt} {x} {mu}",
    "hertz/history":
        "hertz {k} {eta} damping viscoelastic tangential mindlin_classic {kt} {x} {mu}",
}  # fmt: skip


def granular_law(words: Words) -> Law:
    """Return the law of the words of ``pair_style granular``; raise NotUnderstoodError."""
    values: dict[str, Any] = {"damping": "viscoelastic"}
    rest = ["normal", *words]
    while rest:
        part = rest.pop(0)
        if part == "limit_damping":
            values["clipped"] = True
            continue
        _check_word("granular", part, MODELS)
        model = rest.pop(0) if rest else ""
        _check_word(part, model, MODELS[part])
        values[part] = model.removesuffix("/material")
        for name in MODELS[part][model]:
            word = rest.pop(0) if rest else ""
            null = word == "NULL" and name == "tangential_modulus"
            values[name] = None if null else _float(word, f"{part} {model}")
    return _acting_law(values)


def old_law(style: str, words: Words) -> Law:
    """Return the law of ``hooke``, ``hooke/history`` or ``hertz/history`` and its numbers.

    Raise NotUnderstoodError for another style, or a word that does not belong to it.
    """
    _check_word("wall or gran", style, OLD_STYLES)
    k, eta, mu = (_float(words[at], style) for at in (0, 2, 4))
    kt = k * 2.0 / 7.0 if words[1] == "NULL" else _float(words[1], style)
    along = 0.5 * eta if words[3] == "NULL" else _float(words[3], style)
    along = 0.0 if words[5] == "0" else along
    if along and not eta:
        raise NotUnderstoodError(f"{style}: gamma_t = {along} without gamma_n is not understood")
    _check_keywords(style, words[6:], {"limit_damping": 0})
    text = OLD_STYLES[style].format(k=k, kt=kt, eta=eta, x=along / eta if eta else 0.0, mu=mu)
    return granular_law([*text.split(), *words[6:]]).replace(interface="old")


def _acting_law(values: dict[str, Any]) -> Law:
    """Return a law without the parts that do nothing, as their coefficients are zero."""
    eta = values.pop(ETA)
    if values["damping"] in ("tsuji", "coeff_restitution"):
        values["restitution"] = eta
    elif eta and values["damping"] != "none":
        values[ETA] = eta
    else:
        values["damping"] = "none"
    dashpot = values["damping"] != "none" and values.get("tangential_damping")
    acts = values.get("friction") or values.get("twisting") == "marshall"
    if not acts or (values.get("tangential") == "linear_nohistory" and not dashpot):
        values = {name: value for name, value in values.items() if name not in TANGENTIAL}
    try:
        return Law(**values)
    except RequestError as error:
        raise NotUnderstoodError(f"its law is not one of the reference: {error}") from None


def _pair_laws(commands: _Commands, types: Floats) -> Laws:
    """Return the laws of all pairs of types of the bodies."""
    kinds = sorted({int(kind) for kind in types})
    pairs = list(combinations_with_replacement(kinds, 2)) if len(types) > 1 else []
    style, *numbers = commands.last["pair_style"]
    if style.startswith("gran/"):
        return dict.fromkeys(pairs, old_law(style.removeprefix("gran/"), numbers))
    _check_keywords("pair_style", [style, *numbers], {"granular": 0, "none": 0})
    explicit: Laws = {}
    for first, second, *words in commands.coefficients:
        if first.isdecimal() and second.isdecimal():  # LAMMPS sets pairs i <= j, and turns these
            first, second = sorted((first, second), key=int)
        for i, j in pairs:
            if _covers(first, i) and _covers(second, j):
                explicit[i, j] = granular_law(words)
    if not explicit:
        return {}
    return {
        (i, j): explicit.get((i, j)) or mixed_law(explicit[i, i], explicit[j, j]) for i, j in pairs
    }


def _covers(word: str, kind: int) -> bool:
    if not word.isdecimal():
        _check_word("pair_coeff", word, ("*",))
    return word in ("*", str(kind))


def mixed_law(first: Law, second: Law) -> Law:
    """Return the law of two types that LAMMPS mixes; their materials alone may differ."""
    moduli = {name: getattr(second, name) for name in ("youngs_modulus", "poisson_ratio")}
    if first.replace(**moduli) != second:
        raise NotUnderstoodError("pair_coeff: types of other coefficients are not mixed here")
    return first.replace(**{f"partner_{name}": value for name, value in moduli.items()})
