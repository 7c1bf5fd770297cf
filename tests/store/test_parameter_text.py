import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.store.baseline import parameter_text, parameters_of

NAMES = st.from_regex(r"[a-z_][a-z0-9_]{0,8}", fullmatch=True)
VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=12),
    st.sampled_from(["true", "null", "a; b", "1e6", "source, clipped", "x = y", "NaN", "", "a "]),
    st.lists(st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.text(max_size=5))),
)
PARAMETERS = st.dictionaries(NAMES, st.one_of(VALUES, st.dictionaries(NAMES, VALUES)), max_size=6)


def types(value):
    if isinstance(value, dict):
        return {key: types(item) for key, item in value.items()}
    return [types(item) for item in value] if isinstance(value, list) else type(value)


@given(PARAMETERS)
def test_parameters_are_read_back_as_they_are(parameters):
    text = parameter_text(parameters)
    assert "\n" not in text.replace("\\n", "")
    back = parameters_of(text)
    assert back == parameters
    assert types(back) == types(parameters)


@pytest.mark.parametrize("parameters", [{"a.b": 1}, {"": 1}, {"a": float("nan")}])
def test_what_cannot_be_stated_is_refused(parameters):
    with pytest.raises(ValueError, match=r"name|range|NaN|JSON"):
        parameter_text(parameters)


@pytest.mark.parametrize("text", ["a", "a = ", "a = 1; a = 2", "a = 'x'", "a = 1; a.b = 2"])
def test_a_damaged_text_is_refused(text):
    with pytest.raises(ValueError, match=r"parameter|Expecting|is set a"):
        parameters_of(text)
