"""Stored runs: to the last bit, only what is missing is run, and every fact is in the key."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.engines.base import Job, Template, scene_job
from harness.engines.output import SERIES, Output, Provenance
from harness.errors import EngineCrashError, RequestError
from harness.store import cache
from harness.store.cache import CachedEngine, Entries, pack_output, run_key, unpack_output
from tests.workflows import doubles

JOBS = [scene_job(doubles.scene_of(doubles.Bounce(steps=steps))) for steps in (20, 30, 40)]


@pytest.fixture
def entries(tmp_path):
    return Entries(tmp_path)


@pytest.fixture
def engine(monkeypatch):
    monkeypatch.setattr(doubles.Good, "ran", 0)
    return doubles.Good()


def test_only_what_is_missing_is_run_in_order_and_to_the_last_bit(engine, entries):
    cached = CachedEngine(engine, entries)
    (fresh,) = cached.run(JOBS[1:2])
    outputs = cached.run(JOBS)
    assert [len(output.tables[SERIES]["step"]) for output in outputs] == [21, 31, 41]
    assert (cached.ran, cached.read, doubles.Good.ran) == (3, 1, 3)
    assert outputs[1].provenance == fresh.provenance
    for name, column in fresh.tables[SERIES].items():
        assert np.array_equal(outputs[1].tables[SERIES][name], column, equal_nan=True)


def test_each_output_is_stored_as_soon_as_it_is_there_and_no_error_is(engine, entries):
    outcomes = CachedEngine(engine, entries).outcomes(JOBS)
    next(outcomes)
    outcomes.close()  # as an interrupt does
    again = CachedEngine(engine, entries)
    again.run(JOBS)
    assert again.read >= 1
    dying = CachedEngine(doubles.Dying(), entries)
    assert [type(dying.run(JOBS[:1])[0]) for _ in range(2)] == [EngineCrashError] * 2
    assert (dying.ran, dying.read) == (2, 0)


def test_fresh_reads_nothing_and_stores_all_the_same(engine, entries):
    CachedEngine(engine, entries).run(JOBS[:1])
    fresh = CachedEngine(engine, entries, fresh=True)
    fresh.run(JOBS[:2])
    assert (fresh.ran, fresh.read) == (2, 0)
    again = CachedEngine(engine, entries)
    again.run(JOBS[:2])
    assert (again.ran, again.read) == (0, 2)


def test_a_refused_job_is_refused_whatever_is_stored(entries):
    with pytest.raises(RequestError, match="no springs"):
        CachedEngine(doubles.Refusing(), entries).run(JOBS[:1])


@pytest.mark.parametrize("payload", [b"", b"PK", b"{}"])
def test_an_entry_that_is_no_run_is_dropped_and_run_again(engine, entries, payload):
    entries.put(run_key(engine, JOBS[0], engine.fingerprint()), payload)
    cached = CachedEngine(engine, entries)
    cached.run(JOBS[:1])
    assert (cached.ran, cached.read) == (1, 0)


@given(st.floats(), st.text(), st.integers(-(2**31), 2**31))
def test_any_number_and_text_is_read_as_it_was_packed(value, text, number):
    tables = {"t": {"a": np.array([value]), "b": np.array([[number, number]])}}
    output = Output((("name", text),), Provenance("x", text, ("A",)), tables, log=text)
    again = unpack_output(pack_output(output))
    assert (again.results, again.provenance) == (output.results, output.provenance)
    for name, column in tables["t"].items():
        assert np.array_equal(again.tables["t"][name], column, equal_nan=True)


SCRIPTED = Job(Template("drop", {"": {"angle": 1.0}, "soft": {"angle": 2.0}}), {"speed": 1.0})
CHANGES = [
    {"values": {"speed": np.nextafter(1.0, 2.0)}},
    {"values": {"speed": 1.0, "more": 1}},
    {"variant": "soft"},
    {"sampled": True},
    {"template": Template("drop", {"": {"angle": 1.5}})},
    {"template": replace(SCRIPTED.template, package="lib")},
    {"scene": JOBS[0].scene},
    {"scene": JOBS[1].scene},
]


def test_every_fact_of_a_job_engine_and_platform_is_in_the_key(engine, monkeypatch):
    keys = [run_key(engine, replace(SCRIPTED, **change), {}) for change in ({}, *CHANGES)]
    keys += [run_key(engine, SCRIPTED, {"files": ["a"]})]
    for name in ("machine", "versions", "source_digest"):
        with monkeypatch.context() as patch:
            patch.setattr(cache, name, lambda *_: "another")
            keys += [run_key(engine, SCRIPTED, {})]
    monkeypatch.setattr(doubles.Good, "script_digest", lambda *_: "edited")
    keys += [run_key(engine, SCRIPTED, {})]
    assert len(set(keys)) == len(keys) == 14
