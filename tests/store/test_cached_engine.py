import pytest

from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.chain import exact
from harness.engines.contract import Engine
from harness.engines.traits import Traits
from harness.errors import EngineCrashError
from harness.observables.provenance import Provenance
from harness.parameters.tower import Tower
from harness.store.cached_engine import CachedEngine
from harness.store.entries import Entries

WHO = {"engine": "synthetic", "files": ["1"]}


class Synthetic(Engine):
    """The theory's map and the exact propagator as an engine that counts what it runs."""

    name = "synthetic"
    traits = Traits(install_hint="comes with the tests", versions=("1",), integrator="")

    def __init__(self, incline, who=WHO):
        self._incline = incline
        self.who = who
        self.ran = 0
        self.broken = set()
        self.stops_after = 10**9
        self.closed = False

    def identify(self):
        return Provenance("synthetic", "1")

    def fingerprint(self):
        return self.who

    def drops(self, cases):
        raise NotImplementedError

    def inclines(self, cases, route, *, every=None):  # noqa: ARG002
        results = []
        for case in cases:
            if self.ran == self.stops_after:
                raise KeyboardInterrupt
            self.ran += 1
            (run,) = self._incline.passage([case])
            results.append(EngineCrashError("boom") if case.angle in self.broken else run)
        return results

    def towers(self, cases, duration, *, steps_per_contact=None, samples=None, profiles=False):  # noqa: ARG002
        self.ran += len(cases)
        return [
            exact.run(case, duration * case.contact_time, samples=samples, profiles=profiles)
            for case in cases
        ]

    def close(self):
        self.closed = True


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
    first = cached.inclines([Incline(angle=a) for a in (9.0, 11.0)], "passage")
    again = cached.inclines([Incline(angle=a) for a in (11.0, 10.0, 9.0)], "passage")
    assert angles(again) == [11.0, 10.0, 9.0]
    assert (again[0].margin_J, again[2].margin_J) == (first[1].margin_J, first[0].margin_J)
    assert engine.ran == 3
    assert (cached.ran, cached.read) == (3, 2)


def test_another_process_reads_what_one_has_kept(engine, entries, synthetic):
    CachedEngine(engine, entries).inclines([Incline()], "passage")
    other = Synthetic(synthetic())
    CachedEngine(other, Entries(entries.folder)).inclines([Incline()], "passage")
    assert other.ran == 0


@pytest.mark.parametrize("options", [{"every": 10}, {"route": "steady"}])
def test_another_request_is_another_run(engine, entries, options):
    cached = CachedEngine(engine, entries)
    cached.inclines([Incline()], "passage")
    cached.inclines([Incline()], **{"route": "passage", **options})
    assert engine.ran == 2


def test_another_engine_is_another_run(engine, entries):
    cached = CachedEngine(engine, entries)
    cached.inclines([Incline()], "passage")
    engine.who = WHO | {"files": ["2"]}
    cached.inclines([Incline()], "passage")
    assert engine.ran == 2


def test_errors_are_not_kept(engine, entries):
    cached = CachedEngine(engine, entries)
    engine.broken = {10.0}
    good, bad = cached.inclines([Incline(angle=9.0), Incline(angle=10.0)], "passage")
    assert isinstance(good, InclineRun)
    assert isinstance(bad, EngineCrashError)
    engine.broken = set()
    results = cached.inclines([Incline(angle=9.0), Incline(angle=10.0)], "passage")
    assert all(isinstance(run, InclineRun) for run in results)
    assert engine.ran == 3


def test_fresh_reads_nothing_and_keeps_all_the_same(engine, entries):
    CachedEngine(engine, entries).inclines([Incline()], "passage")
    CachedEngine(engine, entries, fresh=True).inclines([Incline()], "passage")
    assert engine.ran == 2
    CachedEngine(engine, entries).inclines([Incline()], "passage")
    assert engine.ran == 2


def test_an_engine_that_cannot_be_told_is_not_remembered(engine, entries):
    engine.who = None
    cached = CachedEngine(engine, entries)
    cached.inclines([Incline()], "passage")
    cached.inclines([Incline()], "passage")
    assert engine.ran == 2
    assert list(entries.folder.glob("??/*")) == []


@pytest.mark.parametrize("payload", [b"", b"no archive", b"PK\x03\x04 and nothing"])
def test_an_entry_that_is_no_run_is_dropped_and_run_again(engine, tmp_path, payload):
    said = []
    entries = Entries(tmp_path, tell=said.append)
    cached = CachedEngine(engine, entries)
    cached.inclines([Incline()], "passage")
    (path,) = tmp_path.glob("??/*")
    entries.put(path.name, payload)
    (run,) = cached.inclines([Incline()], "passage")
    assert isinstance(run, InclineRun)
    assert engine.ran == 2
    assert "not a run" in said[0]


def test_towers_with_all_their_options(engine, entries):
    cached = CachedEngine(engine, entries)
    requests = [
        {"duration": 1.0},
        {"duration": 2.0},
        {"duration": 1.0, "samples": 50},
        {"duration": 1.0, "profiles": True},
        {"duration": 1.0, "steps_per_contact": 500.0},
    ]
    for _ in range(2):
        for options in requests:
            (run,) = cached.towers([Tower(height=2)], **options)
            assert (run.profiles is not None) == options.get("profiles", False)
    assert engine.ran == len(requests)


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


def test_it_is_the_engine_in_all_else(engine, entries):
    with CachedEngine(engine, entries) as cached:
        assert cached.name == "synthetic"
        assert cached.identify() == engine.identify()
        assert cached.fingerprint() == WHO
    assert engine.closed
