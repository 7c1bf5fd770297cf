"""Results of a run: each name says one thing, and the settings that were requested."""

import pytest

from harness.engines.output import Output
from harness.engines.provenance import Provenance
from harness.errors import EngineNaNError, EngineOutputError

WHO = Provenance("it", "1")


def output(*pairs):
    return Output(tuple(pairs), WHO)


def test_a_name_that_comes_again_with_another_value_is_an_error():
    assert output(("margin_J", "1"), ("margin_J", "1")).number("margin_J") == 1.0
    with pytest.raises(EngineOutputError, match=r"^it left two results 'margin_J': 1 and -1$"):
        output(("margin_J", "1"), ("margin_J", "-1")).number("margin_J")


@pytest.mark.parametrize("text", ["2", "1.00000001", "-1"])
def test_a_run_with_another_setting_than_was_requested_is_an_error(text):
    with pytest.raises(EngineOutputError, match=rf"^it says .* mass_kg = {text}, where 1 was req"):
        output(("mass_kg", text)).check_numbers({"mass_kg": 1.0})


def test_what_printing_leaves_and_what_is_not_said_are_no_errors():
    output(("mass_kg", "0.333333333333333")).check_numbers({"mass_kg": 1.0 / 3.0, "step_s": 1.0})
    with pytest.raises(EngineNaNError, match="mass_kg = nan"):
        output(("mass_kg", "nan")).check_numbers({"mass_kg": 1.0})
