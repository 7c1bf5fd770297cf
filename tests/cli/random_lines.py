"""Random command lines: every command and option of the app, with values good and bad."""

import random
from functools import cache
from typing import Any, Literal, get_args, get_origin

from cyclopts.argument import Argument

from harness.cases.contract import Case
from harness.cases.registry import all_cases
from harness.cli.command import app

NUMBERS = (
    *("nan", "inf", "-inf", "-0", "0", "1", "2", "3.5", "-1", "1e308", "-1e308", "1e-308"),
    *("5e-324", "1e15", "123456789012345678901234567890", "0.1", "50", "1e5", "1e6", "x"),
)
TEXTS = (
    *(
        "",
        " ",
        "a" * 5000,
        "Ω≈ç√",
        "日本語",
        "אבג",
        "\U0001f4a9",
        "a\nb",
        "\x1b[31m",
        "--",
        "-",
        "%s",
    ),
    *("'", '"', "a=b", "=", "x=", "a.b=c", "1-", "1-3", "1,2", "9-1", "1e5,1e6", "*", "[", "?"),
    *("2025-01-01", "0001-01-01", "9999-12-31T23:59:59-14:00", "all", "none", "pass", "fail"),
    *("incline", "tower", "drop", "lammps", "reference", "yade", "exact", "rk4", "os:path", ":"),
    *("yade=/bin/true", "reference.seconds=1", "height=2", "stiffness=1e308", "angle=nan"),
    *("lammps.workers=-1", "lammps.limits=1e308", "yade.limits=nan", "10000", "1-10000"),
    *("preset=source", "contact.tail=clipped", "speed=-0", "velocity-verlet", "adaptive", "\udcff"),
)
PATHS = (
    *("nowhere/at/all", ".", "", "endless", "a" * 300, "file.csv", "file.svg", "file.png"),
    *("folder", "new", "new/below", "Ω.csv", "-", "~", "\udcff", "folder/results.json", "link"),
)
"""All within the test's folder: a line may write, replace or remove what it names. ``file.*``,
``folder``, ``link`` and ``endless``, a link to a device, are made by the test."""

NEVER = ("--force", "--help", "--version")
"""What takes the limit of the cost away, or asks for nothing."""


@cache
def commands() -> dict[str, list[Argument]]:
    """Return the arguments and options of every command by its words, as the app has them."""
    found = {}
    groups = {"": app, "baseline ": app["baseline"]}
    for prefix, group in groups.items():
        for name, command in group.resolved_commands().items():
            if name not in ("baseline", *NEVER) and not name.startswith("-"):
                arguments = command.assemble_argument_collection(
                    default_parameter=app.default_parameter
                )
                found[prefix + name] = [one for one in arguments if one.parse and one.show]
    return found


def line(dice: random.Random) -> list[str]:
    """Return a random command line."""
    every = commands()
    words = dice.choice(list(every))
    # many options contradict one another: most lines have few
    many = dice.choice((0, 1, 1, 2, 2, 3, 5, 9))
    options, arguments, given = [], [], []
    case = dice.choice([*all_cases().values()])
    for one in every[words]:
        kind, names = one.hint, [name for name in one.names if name.startswith("--")]
        if one.name in ("CASE", "TARGET") and dice.random() < 0.8:
            arguments.append(case.name)
        elif one.name in ("--set", "--over"):
            given += [
                w for _ in range(dice.choice((0, 1, 1, 2))) for w in _option(dice, names, case)
            ]
        elif not names:
            repeats = dice.choice((1, 1, 2)) if get_origin(kind) is list else 1
            arguments += [_value(dice, kind) for _ in range(repeats)]
        elif names[0] not in NEVER:
            options.append((names, kind))
    chosen = dice.sample(options, min(many, len(options)))
    given += [word for names, kind in chosen for word in _option(dice, names, kind)]
    if dice.random() < 0.05:
        arguments = arguments[1:] if dice.random() < 0.5 else [*arguments, dice.choice(TEXTS)]
    return [*words.split(), *given, *arguments]


def _option(dice: random.Random, names: list[str], kind: Any) -> list[str]:
    name = dice.choice(names)
    if bool in (kind, *get_args(kind)):
        return [name]
    value = _setting(dice, kind) if isinstance(kind, Case) else _value(dice, kind)
    return [f"{name}={value}"] if dice.random() < 0.3 else [name, value]


def _setting(dice: random.Random, case: Case[Any]) -> str:
    """Return a parameter of a case with one value or several, now and then something else."""
    if dice.random() < 0.1:
        return dice.choice(TEXTS)
    values = [dice.choice(NUMBERS) for _ in range(dice.choice((1, 1, 2)))]
    return f"{dice.choice([*case.parameters.model_fields])}={','.join(values)}"


def _value(dice: random.Random, kind: Any) -> str:
    """Return a value of a type, now and then one of another."""
    if dice.random() < 0.05:
        return dice.choice((*NUMBERS, *TEXTS, *PATHS))
    inner = get_args(kind)
    if get_origin(kind) is Literal:
        return dice.choice(inner)
    kinds = {kind, *inner, *(one for part in inner for one in get_args(part))}
    if kinds & {int, float}:
        return dice.choice(NUMBERS)
    if str in kinds:
        return dice.choice((*TEXTS, *NUMBERS))
    literal = [one for one in kinds if isinstance(one, str)]
    return dice.choice(literal) if literal else dice.choice(PATHS)
