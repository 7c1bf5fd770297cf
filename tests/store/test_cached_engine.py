from dataclasses import replace

import numpy as np
import pytest

from harness.cases.grain import COLUMNS
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, InclineRun, Motion, case_of, job_of
from harness.cases.tower.run import run_towers
from harness.engines.contract import Engine, Output
from harness.engines.lammps.engine import Lammps
from harness.engines.traits import Traits
from harness.errors import EngineCrashError, RequestError
from harness.observables.provenance import Provenance
from harness.parameters.tower import Tower
from harness.store.cache import CachedEngine
from harness.store.entries import Entries
from tests.engine_doubles import frictionless

WHO = {"engine": "synthetic", "files": ["1"]}


class Synthetic(Engine):
    """The theory's map as an engine that counts what it runs."""

    name = "synthetic"
    traits = Traits(install_hint="comes with the tests", versions=("1",), integrator="")

    def __init__(self, incline, who=WHO):
        self._incline = incline
        self.who = who
        self.script = "one"
        self.ran = 0
        self.broken = set()
        self.stops_after = 10**9
        self.closed = False

    def identify(self):
        return Provenance("synthetic", "1", ("A", "B"))

    def fingerprint(self):
        return self.who

    def script_digest(self, job):  # noqa: ARG002
        return self.script

    def run(self, jobs):
        results = []
        for job in jobs:
            if self.ran == self.stops_after:
                raise KeyboardInterrupt
            self.ran += 1
            (run,) = self._incline.passage([case_of(job.values)])
            broken = run.case.angle in self.broken
            results.append(EngineCrashError("boom") if broken else self._output(run, job))
        return results

    def close(self):
        self.closed = True

    def _output(self, run, job):
        results = {
            "verdict": run.motion.value,
            "margin_J": repr(run.margin_J),
            "touching": "1",
            "time_s": repr(100 * run.case.step),
            "steps": "100",
        }
        if run.motion is Motion.MOVES_ON:
            results["crest"] = f"1 {100 * run.case.step!r} {run.margin_J!r} 1"
        table = {name: np.linspace(0.1, 0.3, 7) ** 0.5 for name in COLUMNS}
        table["force"] = np.arange(14.0).reshape(7, 2) / 7.0
        tables = {"series": table, "of all / things": table} if job.sampled else {}
        return Output(tuple(results.items()), self.identify(), tables, "a log: ±\n", 0.1 + 0.2, "S")


def inclines(engine, *angles):
    """Run passages at some angles, 10.2 deg unless told otherwise."""
    return run_inclines(engine, [Incline(angle=angle) for angle in angles or (10.2,)], "passage")


@pytest.fixture
def entries(tmp_path):
    return Entries(tmp_path / "cache")


@pytest.fixture
def engine(synthetic):
    return Synthetic(synthetic())


def angles(results):
    return [run.case.angle for run in results]


def test_only_what_is_missing_is_run_and_the_order_is_kept(engine, entries):
    cached = CachedEngine(engine, entries)
    first = inclines(cached, 9.0, 11.0)
    again = inclines(cached, 11.0, 10.0, 9.0)
    assert angles(again) == [11.0, 10.0, 9.0]
    assert (again[0].margin_J, again[2].margin_J) == (first[1].margin_J, first[0].margin_J)
    assert engine.ran == 3
    assert (cached.ran, cached.read) == (3, 2)


JOB = job_of(Incline(), "passage")


@pytest.mark.parametrize(
    "other",
    [
        replace(JOB, values={**JOB.values, "route": "steady"}),
        replace(JOB, values={**JOB.values, "angle": 10.2000001}),
        replace(JOB, sampled=True),
        replace(JOB, variant="plastic"),
        replace(JOB, template=replace(JOB.template, name="another")),
        replace(JOB, template=replace(JOB.template, package="another")),
        replace(JOB, template=replace(JOB.template, variants={"source": {"angle": 1.0}})),
    ],
)
def test_another_job_is_another_run(engine, entries, other):
    cached = CachedEngine(engine, entries)
    cached.run([JOB])
    cached.run([other])
    assert engine.ran == 2
    cached.run([JOB, other])
    assert engine.ran == 2


@pytest.mark.parametrize(("fact", "value"), [("script", "two"), ("who", WHO | {"files": ["2"]})])
def test_another_script_or_engine_is_another_run(engine, entries, fact, value):
    cached = CachedEngine(engine, entries)
    inclines(cached)
    setattr(engine, fact, value)
    inclines(cached)
    assert engine.ran == 2


def test_a_kept_output_is_the_fresh_one_to_the_last_bit(engine, entries):
    job = replace(JOB, sampled=True)
    (fresh,) = CachedEngine(engine, entries).run([job])
    (kept,) = CachedEngine(engine, entries).run([job])
    assert engine.ran == 1
    assert kept.results == fresh.results
    assert (kept.provenance, kept.log, kept.title) == (fresh.provenance, fresh.log, "S")
    assert kept.seconds == fresh.seconds == 0.1 + 0.2
    assert list(kept.tables) == list(fresh.tables)
    for name, table in fresh.tables.items():
        assert list(kept.tables[name]) == list(table)
        for column, values in table.items():
            assert kept.tables[name][column].dtype == values.dtype
            np.testing.assert_array_equal(kept.tables[name][column], values)


def test_errors_are_not_kept(engine, entries):
    cached = CachedEngine(engine, entries)
    engine.broken = {10.0}
    good, bad = inclines(cached, 9.0, 10.0)
    assert isinstance(good, InclineRun)
    assert isinstance(bad, EngineCrashError)
    engine.broken = set()
    results = inclines(cached, 9.0, 10.0)
    assert all(isinstance(run, InclineRun) for run in results)
    assert engine.ran == 3


def test_fresh_reads_nothing_and_keeps_all_the_same(engine, entries):
    inclines(CachedEngine(engine, entries))
    inclines(CachedEngine(engine, entries, fresh=True))
    assert engine.ran == 2
    inclines(CachedEngine(engine, entries))
    assert engine.ran == 2


def test_an_engine_that_cannot_be_told_is_not_remembered(engine, entries):
    engine.who = None
    cached = CachedEngine(engine, entries)
    inclines(cached)
    inclines(cached)
    assert engine.ran == 2
    assert list(entries.folder.glob("??/*")) == []


@pytest.mark.parametrize("payload", [b"", b"no archive", b"PK\x03\x04 and nothing"])
def test_an_entry_that_is_no_run_is_dropped_and_run_again(engine, tmp_path, payload):
    said = []
    entries = Entries(tmp_path, tell=said.append)
    cached = CachedEngine(engine, entries)
    inclines(cached)
    (path,) = tmp_path.glob("??/*")
    entries.put(path.name, payload)
    (run,) = inclines(cached)
    assert isinstance(run, InclineRun)
    assert engine.ran == 2
    assert "not a run" in said[0]


def test_a_job_that_is_refused_is_refused_whatever_is_kept(engine, entries):
    cached = CachedEngine(engine, entries)
    inclines(cached)
    engine.traits = replace(engine.traits, frictionless=frictionless(tail="clipped"))
    with pytest.raises(RequestError, match="takes tail = clipped, not attractive"):
        inclines(cached)


def test_a_search_that_was_interrupted_goes_on_where_it_stopped(engine, entries, synthetic):
    case = Incline()
    whole = Synthetic(synthetic())
    expected = critical_angle(case, engine=whole)
    engine.stops_after = 2
    with pytest.raises(KeyboardInterrupt):
        critical_angle(case, engine=CachedEngine(engine, entries))
    resumed = Synthetic(synthetic())
    found = critical_angle(case, engine=CachedEngine(resumed, Entries(entries.folder)))
    assert resumed.ran == whole.ran - 2
    assert found.value_deg == expected.value_deg
    assert found.samples == expected.samples


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_runs_of_lammps_come_back_to_the_last_bit_without_starting_it(entries):
    cases = [Tower(height=2, law=law) for law in ("overlap", "deformable")]
    made, kept = [], []
    for runs in (made, kept):
        with CachedEngine(Lammps(workers=1), entries) as engine:
            runs += run_towers(engine, cases, 1.0)
            runs += run_inclines(engine, [Incline(angle=10.5)], "passage")
            counts = engine.ran, engine.read
        assert counts == ((3, 0) if runs is made else (0, 3))
    for fresh, back in zip(made[:2], kept[:2], strict=True):
        np.testing.assert_array_equal(back.grain_force, fresh.grain_force)
        assert back.provenance == fresh.provenance
    assert kept[2].margin_J == made[2].margin_J
