"""Faults of an engine's outputs, each by its name, for the standing test of the judges.

A mutation changes the output of a job; which jobs it is planted in is said apart, by a target.
Outputs are recorded once and replayed under each mutation. :data:`SHOWN_BY` names what each must
turn: a row by its name, or by the words of its note where the output is refused when it is read.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from harness.cases.grain import path_in
from harness.cases.incline.system import Motion, case_of, judge
from harness.engines.contract import Engine
from harness.engines.lammps.engine import Lammps
from harness.errors import EngineError

PATH = ("time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
TOLD = ("verdict", "margin_J", "touching", "time_s", "steps")


class Mutant(Engine):
    """An engine with the traits of LAMMPS that replays another's outputs, with one fault."""

    name = "mutant"
    title = "Mutant"

    def __init__(self, inner, kept, values=None, output=None):
        """Take the engine to record, where outputs are kept, and changes of values and output."""
        self.inner, self.kept, self.acted = inner, kept, False
        self.traits = replace(Lammps.traits, frictionless=inner.traits.frictionless)
        self.change_values = values or (lambda job: job.values)
        self.change_output = output or (lambda _, output: output)

    def identify(self):
        return replace(self.inner.identify(), engine=self.name)

    def run(self, jobs):
        self.check(jobs)
        changed = [replace(job, values=self.change_values(job)) for job in jobs]
        keys = [key_of(job) for job in changed]
        new = {key: job for key, job in zip(keys, changed, strict=True) if key not in self.kept}
        made = self.inner.run(list(new.values())) if new else []
        for (key, job), output in zip(new.items(), made, strict=True):
            self.kept[key] = as_told(job, output)
        outputs = [self._mutated(job, self.kept[k]) for job, k in zip(jobs, keys, strict=True)]
        pairs = zip(jobs, changed, strict=True)
        if any(job.values != other.values for job, other in pairs):
            self.acted = True  # set only: parts of a case run in several threads
        return outputs

    def _mutated(self, job, output):
        if isinstance(output, EngineError):
            return output
        changed = self.change_output(job, output)
        if changed is not output:
            self.acted = True
        return changed


def key_of(job):
    return job.template.name, job.variant, job.sampled, tuple(sorted(job.values.items()))


def as_told(job, output):
    """Return an output of the reference DEM as LAMMPS's script leaves it, which judges itself."""
    if job.template.name != "incline" or isinstance(output, EngineError) or output.results:
        return output
    case, route = case_of(job.values), job.values["route"]
    looks = output.tables["stages"]
    found = judge(case, route, path_in(looks))
    crests = zip(found.crests.time_s, found.crests.margin_J, strict=True)
    results = [
        ("crest", f"{number} {time!r} {margin!r} 1")
        for number, (time, margin) in enumerate(np.array(list(crests)).reshape(-1, 2).tolist(), 1)
    ]
    numbers = {
        "margin_J": found.margin_J,
        "touching": int(found.touching),
        "time_s": found.time_s,
        "steps": round(looks["step"][found.row]),
        "verdict": found.motion.value,
    }
    results = [("route", route), *results, *((name, f"{told}") for name, told in numbers.items())]
    tables = {}
    if job.sampled:
        series = output.tables["series"]
        ended = series["time_s"] <= found.time_s + 0.5 * case.step
        tables = {"series": {name: column[ended] for name, column in series.items()}}
    return replace(output, results=tuple(results), tables=tables)


def on_table(change):
    """Return a mutation of the series; it leaves outputs without one alone."""

    def mutation(_, output):
        if not output.tables:
            return output
        return replace(output, tables={"series": change(dict(output.tables["series"]))})

    return mutation


def kept_rows(rows):
    """Return a mutation that keeps some rows: ``rows(count)``."""
    return on_table(
        lambda table: {name: column[rows(len(column))] for name, column in table.items()}
    )


def without_rows(rows):
    return kept_rows(lambda count: np.delete(np.arange(count), rows(count)))


ROWS = {
    "first row lost": without_rows(lambda _: 0),
    "last row lost": without_rows(lambda _: -1),
    "a hole of 20 % of the rows": without_rows(
        lambda count: slice(count * 4 // 10, count * 6 // 10)
    ),
    "rows in reverse": kept_rows(lambda _: slice(None, None, -1)),
    "a row twice": kept_rows(lambda count: np.sort(np.r_[0:count, count // 2])),
    "no rows": kept_rows(lambda _: slice(0, 0)),
}


def _digits(values, digits=6):
    """Return numbers as an output with six significant digits has them."""
    return np.vectorize(lambda value: float(f"{value:.{digits}g}"))(values)


def _with(table, name, change):
    return {**table, name: change(table[name])}


def _swapped(one, other):
    return on_table(lambda table: {**table, one: table[other], other: table[one]})


FORCE = "the force"
"""Whatever column of forces an engine writes."""


def columns(names):
    """Return each column lost, doubled, negated, or NaN in one row, by name."""
    changes = {
        "doubled": lambda column: 2.0 * column,
        "negated": lambda column: -column,
        "not a number in one row": _with_nan,
        "lost": None,
    }
    return {
        f"{name} {told}": _of_column(name, change)
        for name in names
        for told, change in changes.items()
    }


def _of_column(name, change):
    def mutation(table):
        there = next(key for key in table if key == name or (name == FORCE and key.endswith("_N")))
        if change is None:
            return {key: column for key, column in table.items() if key != there}
        return _with(table, there, change)

    return on_table(mutation)


def _with_nan(column):
    changed = np.array(column, dtype=float)
    changed[len(changed) // 2] = np.nan
    return changed


def one_sample(name, where, by=0.01):
    """Return a mutation of one sample of a column, by a part of its largest value.

    ``where`` is a part of the rows; of a tower it is the second particle's.
    """

    def change(table):
        there = next(key for key in table if key == name or (name == FORCE and key.endswith("_N")))
        column = np.array(table[there], dtype=float)
        row = round(where * (len(column) - 1))
        place = row if column.ndim == 1 else (row, min(1, column.shape[1] - 1))
        column[place] += by * np.abs(column).max()
        return {**table, there: column}

    return on_table(change)


def single_samples(names):
    """Return one wrong sample of each column: the last, and one in between."""
    return {
        f"one {name} off at {where:.0%}": one_sample(name, where)
        for name in names
        for where in (0.35, 1.0)
    }


TABLE = {
    **ROWS,
    "no table": lambda _, output: replace(output, tables={}) if output.tables else output,
    "six digits of the table": on_table(
        lambda table: {name: _digits(column) for name, column in table.items()}
    ),
}

PATHS = {
    **TABLE,
    **columns(PATH),
    "x_m and y_m swapped": _swapped("x_m", "y_m"),
    "velocities swapped": _swapped("vx_m_per_s", "vy_m_per_s"),
}


def _late_breaks(table):
    """Return a table whose contacts open most of a sample early, by forces near 0.

    The force of a closed contact is lowered over its last three samples by 0.8 of what it changes
    from one to the next. No other sample is touched.
    """
    name = next(key for key in table if key.endswith("_N"))
    force = np.array(table[name], dtype=float)
    assert name == "contact_force_N"
    for contact in force.T:
        for row in np.flatnonzero((contact[:-1] > 0.0) & (contact[1:] <= 0.0)):
            if row > 3 and (contact[row - 3 : row + 1] > 0.0).all():
                lower = 0.8 * (contact[row - 1] - contact[row])
                contact[row - 2 : row + 1] -= min(lower, 0.9 * contact[row])
    return {**table, name: force}


def _late_clock(table):
    """Return a table with one sample half a step late."""
    step = np.array(table["step"], dtype=float)
    step[len(step) // 2] += 0.5
    return {**table, "step": step}


TOWERS = {
    **TABLE,
    "one sample half a step late": on_table(_late_clock),
    **columns(("step", "x_m", "vx_m_per_s", FORCE)),
    "the last particle lost": on_table(
        lambda table: {n: c if c.ndim == 1 else c[:, :-1] for n, c in table.items()}
    ),
    "the first two particles swapped": on_table(
        lambda t: _with(t, "x_m", lambda x: x[:, [1, 0, *range(2, x.shape[1])]])
    ),
}

PATH_SAMPLES = single_samples(PATH[1:])
TOWER_SAMPLES = single_samples(("x_m", "vx_m_per_s", FORCE))

CONTACT_CHANGES = {"contacts open early": on_table(_late_breaks)}
"""Of towers whose table holds the force of each contact."""


def on_results(change):
    """Return a mutation of the result lines: ``change(name, text)`` is a text, None to drop it."""

    def mutation(_, output):
        told = [(name, change(name, text)) for name, text in output.results]
        kept = tuple((name, text) for name, text in told if text is not None)
        return output if kept == output.results else replace(output, results=kept)

    return mutation


def _number(change, *names):
    """Return a mutation of the numbers of these names, written as they are read."""

    def one(name, text):
        if name not in names:
            return text
        value = change(float(text))
        return str(round(value)) if name == "steps" else repr(value)

    return on_results(one)


def _of_crests(change):
    """Return a mutation of the lines of crests, shape (K, 4)."""

    def mutation(job, output):
        lines = [text.split() for name, text in output.results if name == "crest"]
        if not lines:
            return output
        rows = change(np.array(lines, dtype=float), case_of(job.values))
        told = [("crest", f"{int(n)} {t!r} {m!r} {int(c)}") for n, t, m, c in rows.tolist()]
        rest = [pair for pair in output.results if pair[0] != "crest"]
        return replace(output, results=(*told, *rest))

    return mutation


def _verdicts(one, other):
    return on_results(
        lambda name, text: other if name == "verdict" and text == one else text,
    )


RESULTS = {
    **{
        f"result {lost} left out": on_results(
            lambda name, text, lost=lost: None if name == lost else text
        )
        for lost in TOLD
    },
    "time_s doubled": _number(lambda value: 2.0 * value, "time_s"),
    "time_s and steps doubled": _number(lambda value: 2.0 * value, "time_s", "steps"),
    "margin_J 1e-6 J off": _number(lambda value: value + 1e-6, "margin_J"),
    "moves on said to be trapped": _verdicts(Motion.MOVES_ON.value, Motion.TRAPPED.value),
    "trapped said to move on": _verdicts(Motion.TRAPPED.value, Motion.MOVES_ON.value),
}


def _late_crest(rows, case):
    """Return crests, the second one two steps late: far less than the time between two."""
    late = np.zeros_like(rows)
    late[1:2, 1] = 2.0 * case.step
    return rows + late if len(rows) > 2 else rows


CRESTS = {
    "first crest lost": _of_crests(lambda rows, _: rows[1:]),
    "middle crest lost, renumbered": _of_crests(
        lambda rows, _: np.column_stack(
            [rows[:-1, 0], np.delete(rows, len(rows) // 2, axis=0)[:, 1:]]
        )
    ),
    "a crest twice": _of_crests(lambda rows, _: np.vstack([rows, rows[-1:]])),
    "energy at the crests doubled": _of_crests(lambda rows, _: rows * [1.0, 1.0, 2.0, 1.0]),
    "second crest two steps late": _of_crests(_late_crest),
    "time and energy at the crests swapped": _of_crests(lambda rows, _: rows[:, [0, 2, 1, 3]]),
}


def displaced(job, output, by=1e-4):
    """Mutate as a second sphere that stands ``by`` diameters ahead: path and energy beyond it."""
    case = case_of(job.values)

    def moved(table):
        beyond = table["x_m"] > 1.5 * case.diameter
        return _with(table, "x_m", lambda x: x + by * case.diameter * beyond)

    def lower(rows, case):
        height = by * case.weight_energy * np.sin(np.radians(case.angle))
        return rows + np.outer(rows[:, 0] > 1.0, [0.0, 0.0, height, 0.0])

    return _of_crests(lower)(job, on_table(moved)(job, output))


CRESTS["second sphere displaced by 1e-4 d"] = displaced


def scaled(**factors):
    """Return a change of the values of a job: each times a factor."""
    return lambda job: {
        name: value * factors[name] if name in factors else value
        for name, value in job.values.items()
    }


def shifted(**steps):
    """Return a change of the values of a job: each plus a difference."""
    return lambda job: {
        name: value + steps[name] if name in steps else value for name, value in job.values.items()
    }


VALUES = {
    "angle 1e-5 deg off": shifted(angle=1e-5),
    "gravity 1e-9 off": scaled(gravity=1.0 + 1e-9),
    "stiffness 1e-6 off": scaled(stiffness=1.0 + 1e-6),
    "diameter 1e-6 off": scaled(diameter=1.0 + 1e-6),
    "twice the steps": scaled(steps_per_contact=2.0),
}
"""Other values than were asked for, in a run of the incline."""

DAMPING = {"damping 1e-6 off": scaled(damping_ratio=1.0 + 1e-6)}

OF_A_TOWER = {
    "gravity 1e-3 off": scaled(gravity=1.0 + 1e-3),
    "speed 1e-4 off": scaled(speed=1.0 + 1e-4),
    "stiffness 1e-4 off": scaled(stiffness=1.0 + 1e-4),
    "mass 1e-4 off": scaled(mass=1.0 + 1e-4),
}

OF_A_DROP = {
    "gravity 1 % off": scaled(gravity=1.01),
    "stiffness 1 % off": scaled(stiffness=1.01),
    "half the restitution": scaled(restitution=0.5),
}


LOST_ROWS, ORDER = r"left \d+ rows of a series of \d+", "a series that is out of order"
NO_TABLE, NOT_NUMBERS = "left no table with", "values that are not numbers"
CLOCK, SAMPLE_TIMES = r"took \d+ steps of \S+ s and tells of", "at other times than were asked for"
LAST_CREST, CREST_COUNT = "another time or energy than at its last crest", r"after \d+ crests of"
CONTRADICTION = "that contradict each other: particle"
FALL = r"free fall|angular momentum|restitution head-on|static contact"
CREST_ENERGY, CREST_TIME = "energy, the worst of", "time, the worst of"

SHOWN_BY = {
    **dict.fromkeys(ROWS, LOST_ROWS),
    "rows in reverse": ORDER,
    "a row twice": rf"{ORDER}|{LOST_ROWS}",
    "no rows": rf"left an incomplete series|{LOST_ROWS}",
    "no table": NO_TABLE,
    **{f"{name} lost": NO_TABLE for name in (*PATH, "step", FORCE)},
    **{f"{name} not a number in one row": NOT_NUMBERS for name in (*PATH, "step", FORCE)},
    **{f"{name} negated": ORDER for name in ("time_s", "step")},
    "step doubled": SAMPLE_TIMES,
    "one sample half a step late": SAMPLE_TIMES,
    "the last particle lost": r"left x_m of \d+, not \d+",
    **{f"result {lost} left out": rf"left an incomplete result \('{lost}'\)" for lost in TOLD},
    "time_s doubled": CLOCK,
    "time_s and steps doubled": rf"{LAST_CREST}|{LOST_ROWS}",
    "margin_J 1e-6 J off": rf"{LAST_CREST}|energy told and of its path",
    "moves on said to be trapped": CREST_COUNT,
    "trapped said to move on": CREST_COUNT,
    **{name: CREST_COUNT for name in CRESTS if " lost" in name or " twice" in name},
    "energy at the crests doubled": rf"{CREST_ENERGY}|{LAST_CREST}",
    "second crest two steps late": CREST_TIME,
    "time and energy at the crests swapped": CREST_COUNT,
    "second sphere displaced by 1e-4 d": rf"{CREST_ENERGY}|{LAST_CREST}",
    "contacts open early": "contact changes, largest time difference",
}
"""What a fault turns, in every case and target unless :data:`SHOWN_THERE` says otherwise."""

_PLACES = ("x_m", "y_m", "x_m and y_m")
_SPEEDS = ("vx_m_per_s", "vy_m_per_s", "velocities")
_CHANGES = ("doubled", "negated", "swapped")
_WHOLE = {f"{name} {change}" for name in (*_PLACES, *_SPEEDS, FORCE) for change in _CHANGES}

SHOWN_THERE = {
    "tower": {
        **dict.fromkeys(_WHOLE, CONTRADICTION),
        **dict.fromkeys(TOWER_SAMPLES, CONTRADICTION),
        "six digits of the table": CONTRADICTION,
        "the first two particles swapped": CONTRADICTION,
        "gravity 1e-3 off": CONTRADICTION,
        "speed 1e-4 off": "force, largest difference over the peak",
        "stiffness 1e-4 off": CONTRADICTION,  # it has another step
        "mass 1e-4 off": CONTRADICTION,
    },
    "incline": {
        **{f"{name} {change}": "largest distance" for name in _PLACES for change in _CHANGES},
        **{f"{name} {change}": "largest velocity apart" for name in _SPEEDS for change in _CHANGES},
        **dict.fromkeys(single_samples(PATH[1:3]), "largest distance|energy told|rise of energy"),
        **dict.fromkeys(single_samples(PATH[3:]), "velocity apart|energy told|rise of energy"),
        "six digits of the table": "samples missing in between",
        **dict.fromkeys(VALUES, rf"{CREST_ENERGY}|{CLOCK}"),
        **dict.fromkeys(DAMPING, "largest velocity apart"),
    },
    "drop": {
        **dict.fromkeys(_WHOLE, FALL),
        "time_s doubled": "free fall",
        "six digits of the table": "free fall",
        "gravity 1 % off": "free fall",
        "stiffness 1 % off": "static contact",
        "half the restitution": "restitution head-on",
    },
}
"""What a fault turns in a case of its own."""


def shown_by(case, fault):
    """Return the pattern of the row, or of its note, that a fault of a case must turn."""
    return SHOWN_THERE[case].get(fault) or SHOWN_BY[fault]
