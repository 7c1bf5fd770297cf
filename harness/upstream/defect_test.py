"""A known defect of LAMMPS as a test for its ``unittest/granular``, to be added with the fix.

The commands are those of the script that shows the defect. What is recorded is not what LAMMPS
does, but what it will do once it is mended: its own scheme, step by step, with the law as it
should be. So the test fails in a release with the defect, and passes where it is gone.
"""

from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches
from itertools import accumulate

import numpy as np

from harness.comparison.known_defects import KnownDefect
from harness.engines.process import Limits
from harness.engines.programs import fresh_folder
from harness.errors import RequestError
from harness.parameters.rules import Rules
from harness.solvers.pair.stepping import advance
from harness.store.baseline import known_defects, script_of
from harness.upstream.definition import UpstreamTest
from harness.upstream.runs import run_script, run_test
from harness.upstream.scene import scene_of

EPSILON = 1e-8
"""Relative, of a component: the scheme follows LAMMPS to some 1e-12."""

NOISE = 1e-13
"""Of the largest component: what is smaller is 0, and the round-off of LAMMPS there."""

NOT_IN_A_TEST = frozenset(
    ("jump", "label", "clear", "read_restart", "write_restart", "reset_timestep", "delete_atoms")
)
DRIVER = frozenset(("newton", "run", "print", "log", "thermo", "thermo_style", "thermo_modify"))
"""Commands that the driver gives itself, or that only print."""


def defect_named(name: str) -> KnownDefect:
    """Return a known defect; raise RequestError for a name that is not known."""
    defects = {defect.name: defect for defect in known_defects()}
    if name not in defects:
        near = get_close_matches(name, defects, n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        raise RequestError(
            f"defect {name!r} is not known: {hint}`dem-harness defect` lists all {len(defects)}"
        )
    return defects[name]


def defect_as_test(name: str, lmp: str) -> UpstreamTest:
    """Return the test of a known defect; ``lmp`` runs its script for the system.

    Raise RequestError for a defect of another code, and for one whose script is more than one run
    of a few spheres and flat walls.
    """
    defect = defect_named(name)
    if defect.engine != "lammps":
        raise RequestError(f"defect {name!r}: is one of {defect.engine}, and not of LAMMPS")
    script = script_of(defect)
    test = test_of_script(name, script, runs_of(script, lmp))
    run = run_test(test, lmp)
    scene = scene_of(run.log, run.states[0], sum(test.segments), run.timestep)
    recorded: dict[str, list[list[float]]] = {}
    for segment, steps in enumerate(accumulate(test.segments)):
        stops = tuple(accumulate(test.segments[:segment]))
        held = tuple(replace(part, steps=steps) for part in scene.segments)
        until = replace(scene, steps=steps, every=steps, segments=held)
        path = advance(until, Rules(), stops=stops)
        tables = {
            "run_pos": path.positions[-1],
            "run_vel": path.velocities[-1],
            "run_torque": path.torques[-1],
            "run_omega": path.omegas[-1],
        }
        for table, values in tables.items():
            kept = np.where(np.abs(values) <= NOISE * np.abs(values).max(), 0.0, values)
            rows = recorded.setdefault(table, [])
            rows += [[segment, atom, *row] for atom, row in enumerate(kept.tolist(), 1)]
    if scene.segments and not np.any([row[2:] for row in recorded["run_torque"]]):
        raise RequestError(
            f"defect {name!r}: its spheres are held and feel no torque, and forces are not recorded"
        )
    release = defect.until or "the release of the fix"
    return replace(
        test,
        recorded={table: np.array(rows) for table, rows in recorded.items()},
        version=release,
    )


def runs_of(script: str, lmp: str) -> tuple[int, ...]:
    """Return how many steps each ``run`` of a script takes, as LAMMPS computes them."""
    with fresh_folder() as folder:
        log = run_script(script, lmp, folder, Limits())
    runs = [line.split() for line in log.splitlines() if line.startswith("run ")]
    # as typed, then filled in
    steps = tuple(int(words[1]) for words in runs if words[1].isdigit())
    return tuple(filter(None, steps)) or (1,)


def test_of_script(name: str, script: str, steps: tuple[int, ...]) -> UpstreamTest:
    """Return the test with the commands of a script whose runs take ``steps``.

    Raise RequestError where something but variables and output stands between its runs.
    """
    lines = [line.split("#")[0].strip() for line in script.replace("&\n", " ").splitlines()]
    commands = [line for line in lines if line]
    runs = [n for n, line in enumerate(commands) if line.split()[0] == "run"]
    for number, line in enumerate(commands):
        word = line.split()[0]
        between = runs and runs[0] < number < runs[-1] and word not in (*DRIVER, "variable")
        if word in NOT_IN_A_TEST or between:
            raise RequestError(
                f"defect {name!r}: its script has {line!r}: a test has one system, and runs it on"
            )
    style = [n for n, line in enumerate(commands) if line.split()[0] == "pair_style"]
    if len(style) != 1 or not steps:
        raise RequestError(f"defect {name!r}: its script has {len(style)} pair styles: must be one")
    first, variables = [], []
    pairs = [n for n, line in enumerate(commands) if line.split()[0] == "pair_coeff"]
    rest = []
    for number, line in enumerate(commands):
        words = line.split()
        if words[0] == "variable" and words[2] == "index":
            variables.append((words[1], " ".join(words[3:])))
        elif number < style[0] or (words[0] == "variable" and number < pairs[-1]):
            first += [line] if words[0] not in DRIVER else []
        elif number not in (*style, *pairs) and words[0] not in DRIVER:
            rest.append(line)
    return UpstreamTest(
        name=name,
        variables=tuple(variables),
        before_pair=tuple(first),
        pair_style=commands[style[0]].split(maxsplit=1)[1],
        pair_coeff=tuple(commands[n].split(maxsplit=1)[1] for n in pairs),
        after_pair=tuple(rest),
        segments=steps if len(steps) > 1 else (steps[0] // 2, steps[0] - steps[0] // 2),
        epsilon=EPSILON,
    )
