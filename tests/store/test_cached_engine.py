"""Kept runs: to the last bit, only what is missing is run, and every fact is in the key."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.engines.base import Job, Template, scene_job
from harness.engines.output import SERIES, Output
from harness.engines.provenance import Provenance
from harness.errors import EngineCrashError, RequestError
from harness.store import cache as cache_module
from harness.store.cache import CachedEngine, pack_output, run_key, unpack_output
from harness.store.entries import Entries
from tests.workflows import doubles

JOBS = [scene_job(doubles.scene_of(doubles.Bounce(steps=steps))) for steps in (20, 30, 40)]


@pytest.fixture
def entries(tmp_path):
    return Entries(tmp_path, notify=lambda _: None)


@pytest.fixture
def engine(monkeypatch):
    monkeypatch.setattr(doubles.Good, "ran", 0)
    return doubles.Good()


def test_only_what_is_missing_is_run_and_the_order_is_kept(engine, entries):
    cached = CachedEngine(engine, entries)
    cached.run(JOBS[1:2])
    outputs = cached.run(JOBS)
    assert [len(output.tables[SERIES]["step"]) for output in outputs] == [21, 31, 41]
    assert (cached.ran, cached.read, doubles.Good.ran) == (3, 1, 3)


def test_a_kept_output_is_the_fresh_one_to_the_last_bit(engine, entries):
    (fresh,) = CachedEngine(engine, entries).run(JOBS[:1])
    (kept,) = CachedEngine(engine, entries).run(JOBS[:1])
    assert kept.provenance == fresh.provenance
    for name, column in fresh.tables[SERIES].items():
        assert np.array_equal(kept.tables[SERIES][name], column, equal_nan=True)


def test_errors_are_not_kept(entries):
    cached = CachedEngine(doubles.Dying(), entries)
    for _ in range(2):
        (error,) = cached.run(JOBS[:1])
        assert isinstance(error, EngineCrashError)
    assert (cached.ran, cached.read) == (2, 0)


def test_each_output_is_kept_as_soon_as_it_is_there(engine, entries):
    outcomes = CachedEngine(engine, entries).outcomes(JOBS)
    next(outcomes)
    outcomes.close()  # as an interrupt does
    again = CachedEngine(engine, entries)
    again.run(JOBS)
    assert again.read >= 1


def test_fresh_reads_nothing_and_keeps_all_the_same(engine, entries):
    CachedEngine(engine, entries).run(JOBS[:1])
    fresh = CachedEngine(engine, entries, fresh=True)
    fresh.run(JOBS[:2])
    assert (fresh.ran, fresh.read) == (2, 0)
    assert CachedEngine(engine, entries).run(JOBS[:2])


def test_a_job_that_is_refused_is_refused_whatever_is_kept(entries):
    with pytest.raises(RequestError, match="no springs"):
        CachedEngine(doubles.Refusing(), entries).run(JOBS[:1])


@pytest.mark.parametrize("payload", [b"", b"PK", b"{}"])
def test_an_entry_that_is_no_run_is_dropped_and_run_again(engine, entries, payload):
    entries.put(run_key(engine, JOBS[0], engine.fingerprint()), payload)
    cached = CachedEngine(engine, entries)
    cached.run(JOBS[:1])
    assert (cached.ran, cached.read) == (1, 0)


@given(st.floats(), st.text(), st.integers(-(2**31), 2**31))
def test_any_number_and_text_comes_back(value, text, number):
    table = {"a": np.array([value]), "b": np.array([[number, number]])}
    output = Output((("name", text),), Provenance("x", text, ("A",)), {"t": table}, log=text)
    back = unpack_output(pack_output(output))
    assert back.results == output.results
    assert back.provenance == output.provenance
    assert np.array_equal(back.tables["t"]["a"], table["a"], equal_nan=True)
    assert np.array_equal(back.tables["t"]["b"], table["b"])


SCRIPTED = Job(Template("drop", {"": {"angle": 1.0}, "soft": {"angle": 2.0}}), {"speed": 1.0})


@pytest.mark.parametrize(
    "other",
    [
        replace(SCRIPTED, values={"speed": np.nextafter(1.0, 2.0)}),
        replace(SCRIPTED, values={"speed": 1.0, "more": 1}),
        replace(SCRIPTED, variant="soft"),
        replace(SCRIPTED, sampled=True),
        replace(SCRIPTED, template=Template("drop", {"": {"angle": 1.5}})),
        replace(SCRIPTED, template=replace(SCRIPTED.template, package="lib")),
        replace(SCRIPTED, scene=JOBS[0].scene),
        replace(SCRIPTED, scene=JOBS[1].scene),
    ],
)
def test_another_job_has_another_key(engine, other):
    assert run_key(engine, other, {}) != run_key(engine, SCRIPTED, {})


@pytest.mark.parametrize("fact", ["machine", "versions", "source_digest"])
def test_engine_platform_packages_and_source_are_in_the_key(engine, monkeypatch, fact):
    before = run_key(engine, SCRIPTED, {"files": ["a"]})
    assert run_key(engine, SCRIPTED, {"files": ["b"]}) != before
    monkeypatch.setattr(cache_module, fact, lambda *_: "another")
    assert run_key(engine, SCRIPTED, {"files": ["a"]}) != before


def test_a_script_is_in_the_key(engine, monkeypatch):
    before = run_key(engine, SCRIPTED, {})
    monkeypatch.setattr(doubles.Good, "script_digest", lambda *_: "edited")
    assert run_key(engine, SCRIPTED, {}) != before
