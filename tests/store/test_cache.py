"""The cache: outputs to the last bit, entries exact or dropped, bounded, listed and cleared."""

import fcntl
import io
import os
import time
import zipfile
from collections import Counter
from contextlib import redirect_stderr
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.engines.base import Job, Template, scene_job
from harness.engines.output import SERIES, Output, Provenance
from harness.engines.process import COMPLETE, USED, locked
from harness.errors import EngineCrashError, RequestError
from harness.store import cache
from harness.store.cache import (
    CachedEngine,
    Entries,
    clear,
    contents,
    digest_of_tree,
    keep_verification,
    kept_verification,
    key_of,
    pack_output,
    run_key,
    unpack_output,
)
from tests.workflows import doubles

# ---- entries

KEY, OTHER = key_of({"n": 1}), key_of({"n": 2})


@pytest.fixture
def entries(tmp_path):
    return Entries(tmp_path / "cache")


@given(st.binary(max_size=200), st.integers(0), st.integers(0, 7), st.booleans())
def test_a_payload_is_read_as_it_was_put_and_damage_drops_it(
    tmp_path_factory, payload, where, bit, cut
):
    entries = Entries(tmp_path_factory.mktemp("cache"))
    assert entries.get(KEY) is None
    entries.put(KEY, payload)
    assert Entries(entries.folder).get(KEY) == payload
    (path,) = entries.folder.glob("??/*")
    data = bytearray(path.read_bytes())
    data[where % len(data)] ^= 1 << bit
    path.write_bytes(data[: where % len(data)] if cut else data)
    with redirect_stderr(io.StringIO()) as printed:
        assert entries.get(KEY) is None
    assert "damaged" in printed.getvalue()
    assert not path.exists()


def test_the_least_recently_used_go_beyond_the_limit(tmp_path):
    entries = Entries(tmp_path, limit=20_000)
    names = [key_of({"n": n}) for n in range(30)]
    for age, key in enumerate(names[:20]):
        entries.put(key, bytes(800))
        os.utime(tmp_path / key[:2] / key, (time.time() - 1000 + age,) * 2)
    assert entries.get(names[0]) is not None  # read: now the youngest
    for key in names[20:]:
        entries.put(key, bytes(800))
    assert sum(path.stat().st_size for path in tmp_path.glob("??/*")) <= 1.1 * 20_000
    assert [entries.get(names[n]) is None for n in (0, 1, 29)] == [False, True, False]


@pytest.fixture
def homes(tmp_path):
    """Return three environments of releases in a cache, the oldest first."""
    folders = [tmp_path / "releases" / name for name in ("old", "used", "new")]
    for age, home in enumerate(folders):
        home.mkdir(parents=True)
        (home / "lmp").write_bytes(bytes(6000))
        (home / COMPLETE).touch()
        os.utime(home / COMPLETE, (age, age))
    return folders


def test_environments_count_and_those_in_use_stay(tmp_path, homes):
    entries = Entries(tmp_path, limit=20_000)
    entries.put(KEY, bytes(500))  # 18,600: pruned from 20,000 on
    with locked(homes[1], USED, fcntl.LOCK_SH):
        entries.put(OTHER, bytes(9000))
    assert [home.exists() for home in homes] == [False, True, False]
    assert entries.get(OTHER) == bytes(9000)


def test_contents_are_listed_by_sort_and_cleared_and_nothing_else_is(tmp_path, homes):
    foreign = tmp_path / "ab" / ("ab" * 32)  # of another program, in a folder that is no cache
    foreign.parent.mkdir()
    foreign.write_text("thesis")
    assert contents(tmp_path) == []
    foreign.unlink()
    Entries(tmp_path).put(KEY, b"x", "run", ("drop",))
    (tmp_path / "numba").mkdir()
    (tmp_path / "numba" / "a.nbi").write_text("kernel")
    items = contents(tmp_path)
    assert Counter(i.label[0] for i in items) == {"kernel": 1, "run": 1, "environment": 3}
    assert ("run", "drop") in [item.label for item in items]
    with locked(homes[1], USED, fcntl.LOCK_SH):
        assert len(clear(tmp_path, items)) == 4
    assert [item.path for item in contents(tmp_path)] == [homes[1]]


def test_a_folder_that_fails_is_reported_once_and_ends_nothing(entries, capsys):
    (entries.folder / KEY[:2]).touch()  # a file in the place of a folder
    entries.put(KEY, b"x")
    entries.put(OTHER, b"x")
    assert entries.get(KEY) is None
    assert capsys.readouterr().err.count("nothing more is kept") == 1


def test_a_cache_that_all_may_write_or_of_another_user_or_a_file_is_refused(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        Entries(tmp_path / "file")
    owner = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: owner or 4321)
    tmp_path.chmod(0o777)
    with pytest.raises(PermissionError, match=r"others may write it \(mode 777\); make it"):
        Entries(tmp_path)
    if owner == 0:
        os.chown(tmp_path, 1234, -1)
    monkeypatch.setattr(os, "geteuid", lambda: 4321)
    with pytest.raises(PermissionError, match=r"it belongs to user \d+; make it yours alone"):
        Entries(tmp_path)


def test_the_digest_of_a_folder_sees_contents_and_names_and_no_byte_code(tmp_path):
    (tmp_path / "a").write_text("1")
    first = digest_of_tree(tmp_path)
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__" / "a.pyc").write_text("x")
    assert digest_of_tree(tmp_path) == first
    (tmp_path / "a").rename(tmp_path / "b")
    assert digest_of_tree(tmp_path) != first


def test_a_verification_is_read_as_it_was_put_and_no_name_leaves_its_folder(entries, tmp_path):
    (tmp_path / "report" / "figures").mkdir(parents=True)
    (tmp_path / "report" / "figures" / "a.svg").write_text("<svg/>")
    keep_verification(entries, KEY, tmp_path / "report", {"status": 1})
    assert kept_verification(entries, KEY, tmp_path / "again") == {"status": 1}
    assert (tmp_path / "again" / "figures" / "a.svg").read_text() == "<svg/>"
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("../../out", "x")
    entries.put(KEY, b"{}\n" + stream.getvalue())
    kept_verification(entries, KEY, tmp_path / "a" / "hostile")
    assert [path.name for path in (tmp_path / "a" / "hostile").rglob("*")] == ["out"]
    entries.put(OTHER, b"{}\nPK")
    for _ in range(2):  # damaged, then dropped
        assert kept_verification(entries, OTHER, tmp_path / "none") is None
    assert entries.get(OTHER) is None
    assert not (tmp_path / "none").exists()


# ---- engines whose outputs are kept

JOBS = [scene_job(doubles.scene_of(doubles.Bounce(steps=steps))) for steps in (20, 30, 40)]


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
    outcomes = CachedEngine(engine, entries, fresh=True).outcomes(JOBS)
    next(outcomes)
    outcomes.close()  # as an interrupt does
    again = CachedEngine(engine, entries)
    again.run(JOBS)
    assert again.read >= 1
    fresh = CachedEngine(engine, entries, fresh=True)
    fresh.run(JOBS)
    assert (fresh.ran, fresh.read) == (3, 0)
    dying = CachedEngine(doubles.Dying(), entries)
    assert [type(dying.run(JOBS[:1])[0]) for _ in range(2)] == [EngineCrashError] * 2
    assert (dying.ran, dying.read) == (2, 0)
    with pytest.raises(RequestError, match="no springs"):
        CachedEngine(doubles.Refusing(), entries).run(JOBS[:1])


@pytest.mark.parametrize("payload", [b"", b"PK"])
def test_an_entry_that_is_no_run_is_dropped_and_run_again(engine, entries, payload):
    entries.put(run_key(engine, JOBS[0], engine.fingerprint()), payload)
    cached = CachedEngine(engine, entries)
    cached.run(JOBS[:1])
    assert (cached.ran, cached.read) == (1, 0)


@settings(max_examples=20)
@given(st.lists(st.floats(), min_size=5), st.text(), st.integers(-(2**31), 2**31))
def test_any_number_and_text_is_read_as_it_was_packed(values, text, number):
    tables = {"t": {"a": np.array(values), "b": np.full((len(values), 2), number)}}
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
