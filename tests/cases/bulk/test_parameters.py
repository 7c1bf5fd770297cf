"""Parameters of bulk cases: refusals, steps, published systems, time limits."""

import pytest

from harness.cases.bulk import beds
from harness.engines.registry import engine_class
from harness.errors import RequestError
from tests.cases.bulk.doubles import CASES

APART = "scatter = 0.3: grains overlap at the start; must be at most spacing - 1"
WRONG = [
    ("silo", {"orifice_radius": 0.03}, "orifice_radius = 0.03 m: must be less than silo_radius ="),
    ("silo", {"radius": 0.03}, "silo_radius = 0.024 m: no grain of radius = 0.03 m finds room"),
    ("silo", {"cone_height": 0.0}, "cone_height = 0.0 m: must be greater than 0"),
    ("drum", {"large_layers": -5}, "large_layers = -5: no large grain finds room in the drum"),
    ("drum", {"large_layers": 9}, "small_layers = 4: no small grain finds room in the drum"),
    ("drum", {"speed": 0.0}, "speed = 0.0 rad/s: must be greater than 0"),
    ("penetration", {"start_height": 0.02}, "start_height = 0.02 m: the sphere overlaps the"),
    (
        "penetration",
        {"steel_radius": 0.013, "start_height": 0.1},
        "steel_radius = 0.013 m: must be at most 0.012",
    ),
    ("penetration", {"restitution": 0.0}, "restitution = 0.0: must be greater than 0.05"),
    ("penetration", {"length": 0.1}, "length = 0.1 m, width = 0 m: must be 0 without"),
    ("heap", {"dispersity": 0.5}, "grains overlap at the start"),
    ("heap", {"width": 2, "spacing": 3.0}, "width = 2: no grain finds room between the sides"),
    ("heap", {"length": 4}, "length = 4: must be greater than or equal to 8"),
    ("heap", {"rolling_friction": -0.1}, "rolling_friction = -0.1: must be greater than or equal"),
    *((name, {"scatter": 0.3}, APART) for name in CASES),
    *((name, {"step_size": 1e-4}, "step_size = 0.0001 s: must be at most") for name in CASES),
]


@pytest.mark.parametrize(("name", "changes", "words"), WRONG)
def test_what_cannot_be_simulated_is_refused_in_one_line(name, changes, words):
    with pytest.raises(RequestError) as refused:
        CASES[name].default.replace(**changes)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", CASES)
def test_no_case_runs_more_grains_than_memory_holds(name, monkeypatch):
    case = CASES[name]
    case.job(case.default)
    monkeypatch.setattr(beds, "GRAIN_BYTES", 10**12)
    for p in case.presets.values():
        with pytest.raises(RequestError, match=rf"^{p.grains} grains: would take .* must be at"):
            case.job(p)


@pytest.mark.parametrize("code", ["yade", "kratos"])
@pytest.mark.parametrize(("name", "preset"), [("drum", "slow"), ("heap", "small")])
def test_codes_that_do_not_resist_rolling_refuse_it(code, name, preset):
    engine = engine_class(code).__new__(engine_class(code))
    engine._scheme = "Velocity_Verlet"
    case = CASES[name]
    p = case.presets[preset]
    assert engine.refuses(case.job(p)).endswith(
        f"has no variable 'rolling_friction' (rolling_friction = {p.rolling_friction})"
    )
    assert not engine.refuses(case.job(p.replace(rolling_friction=0.0)))
