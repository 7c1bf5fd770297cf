"""Variations of a LAMMPS run, such as a restart, that must not change its result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate

from harness.engines.contract import Job, Value, Variation, Vector

ONE_SUM = "no force is a sum of more than two parts, whatever their order: not one bit may change"
SAME_LIST = "the pairs in contact are the same, and what they remember: not one bit may change"
NO_SETUP = "nothing happens between two runs without setup: not one bit may change"
SET_UP = "the setup of a run repeats forces that are there already: not one bit may change"
CUT_BACK = "a spring that Coulomb's limit cut back gives its force again to a rounding"
IN_FULL = "a restart file holds all numbers in full, and what contacts remember: not one bit"
STIFFNESSES = "hertz and mindlin are the law of hertz/material and NULL, k_n = 4/3 E*, k_t = 8 G*"
WRAPPED = "coordinates that go round the box are rounded as those of its size are"

OTHER_ORDER = "either of a pair may hold it: sums of their velocities are rounded in another order"

AXES = ("x", "y", "z")
DEFAULTS = "with LAMMPS's defaults"
SORTED = "particles sorted"


def variations(job: Job, ends: Sequence[Vector]) -> Iterator[Variation]:
    """Yield the variations that a script has variables for; ``ends`` [m] as the engine says."""
    values = job.values
    yield Variation("newton on", {"newton": "on"}, ONE_SUM)
    yield Variation("thin neighbour skin", {"skin": 0.01}, SAME_LIST)
    yield Variation("neighbours at every step", {"rebuild": "no"}, SAME_LIST)
    yield Variation("neighbours from bins", {"neighbours": "bin"}, SAME_LIST)
    of_one = values["interface"] == "current" and "partner_youngs_modulus" not in values
    if values["normal"] == "hertz" and of_one:
        yield Variation("told its stiffnesses", {"told_by": "stiffness"}, STIFFNESSES, exact=False)
    yield from _in_another_order(values, ends)
    yield from _stopped(values)
    if values.get("walls_as") == "region":
        return
    # a plane must not cross a periodic boundary, nor need it cross that of ranks
    across = AXES[:2] if values["planes"] else AXES
    room = float(values["room"])
    start, end = (dict(zip(AXES, one, strict=True)) for one in ends)
    middle = {axis: 0.5 * (start[axis] + end[axis]) for axis in across}
    periodic = " ".join("p" if axis in across else "f" for axis in AXES)
    # what begins in the box leaves it halfway
    leaves = {
        f"low_{axis}": x - (2.0 * room if end[axis] > start[axis] else 0.0)
        for axis, x in middle.items()
    }
    reach = 2.0 * room + max(map(abs, middle.values()))
    told: dict[str, Value] = {"boundary": periodic, **leaves}
    yield Variation("over a periodic boundary", told, WRAPPED, exact=False, reach=reach)
    centred = {f"low_{axis}": x - room for axis, x in middle.items()}
    for ranks, grid in ((2, "2 1 1"), (4, "2 2 1")):
        yield Variation(f"{ranks} ranks", {"grid": grid, **centred}, ONE_SUM, ranks=ranks)


def _in_another_order(values: Mapping[str, Value], ends: Sequence[Vector]) -> Iterator[Variation]:
    """Yield the runs without commands that only a careful script has, and with sorted particles.

    LAMMPS's defaults are newton on, neighbours from bins of half the cutoff, and particles sorted
    by their places every 1000 steps. Under either a contact is held by one of its particles, then
    by the other, as both go through the bins. The box is as small as it may be, for they fill it.
    """
    if values["normal"] == "mdr":  # newton = off is among what it needs
        return
    radii = [float(values[name]) for name in ("radius_1", "radius_2") if name in values]
    room = 0.5 * max(abs(b - a) for a, b in zip(*ends, strict=True)) + 6.0 * max(radii)
    lows = (0.5 * (a + b) - room for a, b in zip(*ends, strict=True))
    box = {f"low_{axis}": low for axis, low in zip(AXES, lows, strict=True)}
    for name, told in ((DEFAULTS, {"defaults": "yes"}), (SORTED, {"sort": "1 0"})):
        if name == DEFAULTS or len(radii) > 1:
            told = {**told, "room": room, **box}
            yield Variation(name, told, OTHER_ORDER, exact=False, carried=True)


def _stopped(values: Mapping[str, Value]) -> Iterator[Variation]:
    """Yield the runs that are stopped halfway, between two samples, or two pieces of a motion."""
    pieces = [int(v) for name, v in values.items() if name.startswith("steps_in_") and v]
    if pieces:
        stop = {"stop_after": list(accumulate(pieces))[-2]}
        yield Variation("restarted", {**stop, "go_on": "restart"}, IN_FULL)
        return
    every = int(values["series_every"])
    stop = {"stop_after": int(values["steps"]) // every // 2 * every + every // 2}
    yield Variation("run on", {**stop, "go_on": "continue"}, NO_SETUP)
    # of the other laws a dashpot shows there, a known defect
    cut = values["normal"] == "mdr" and values["tangential"] not in ("none", "linear_nohistory")
    why = CUT_BACK if cut else SET_UP
    yield Variation("run again", stop, why, exact=not cut, everywhere=False)
    yield Variation("restarted", {**stop, "go_on": "restart"}, IN_FULL, against="run again")
