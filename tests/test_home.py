from pathlib import Path

import pytest

from harness.home import VARIABLE, cache_place, history_place


def test_the_option_wins_for_the_cache_and_leaves_the_history(monkeypatch):
    monkeypatch.setenv(VARIABLE, "/named")
    assert cache_place(Path("/mine")).path == Path("/mine")
    assert cache_place(Path("/mine")).named_by == "--cache"
    assert history_place().path == Path("/named/history.sqlite")


def test_the_variable_names_both(monkeypatch):
    monkeypatch.setenv(VARIABLE, "/named")
    assert cache_place().path == Path("/named/cache")
    assert {cache_place().named_by, history_place().named_by} == {VARIABLE}


@pytest.mark.parametrize(
    ("values", "cache", "data"),
    [
        ({}, "/home/me/.cache", "/home/me/.local/share"),
        ({"XDG_CACHE_HOME": "/c", "XDG_DATA_HOME": "/d"}, "/c", "/d"),
        ({"XDG_CACHE_HOME": "relative"}, "/home/me/.cache", "/home/me/.local/share"),
    ],
)
def test_the_defaults_are_those_of_the_xdg_specification(monkeypatch, values, cache, data):
    for name in (VARIABLE, "XDG_CACHE_HOME", "XDG_DATA_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "/home/me")
    for name, value in values.items():
        monkeypatch.setenv(name, value)
    assert cache_place().path == Path(cache) / "dem-harness"
    assert history_place().path == Path(data) / "dem-harness" / "history.sqlite"
    assert not cache_place().named_by


def test_a_refused_place_names_what_named_it():
    refused = cache_place(Path("/mine")).refused("Read-only file system")
    assert str(refused) == "--cache /mine: cannot be used (Read-only file system)"
    assert refused.exit_status == 2
