import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion
from harness.chain import exact
from harness.observables.provenance import Provenance
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import CONTACTS
from harness.parameters.tower import Tower
from harness.store.runs import DECODE_ERRORS, pack_incline, pack_tower, unpack_incline, unpack_tower

doubles = st.floats(width=64)


def same(one, other):
    """Return whether two results are the same to the last bit, types and NaN included."""
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and one.tobytes() == other.tobytes()
        )
    if isinstance(one, (InclineRun, Crests, Trajectory)) or hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and same(vars(one), vars(other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return type(one) is type(other) and (one == other or (one != one and other != other))


texts = st.text(st.characters(exclude_categories=("Cs",)), max_size=20)
provenances = st.builds(
    Provenance, texts, texts, st.lists(texts, max_size=3).map(tuple), texts, texts, texts, texts
)


@st.composite
def incline_runs(draw):
    rows, crests = draw(st.integers(0, 5)), draw(st.integers(0, 5))
    column = arrays(np.float64, rows, elements=doubles)
    of_crests = arrays(np.float64, crests, elements=doubles)
    case = Incline(
        contact=draw(st.sampled_from(list(CONTACTS.values()))), angle=draw(st.floats(0, 30))
    )
    return InclineRun(
        case=case,
        motion=draw(st.sampled_from(list(Motion))),
        margin_J=draw(doubles),
        touching=draw(st.booleans()),
        crests=Crests(draw(of_crests), draw(of_crests)),
        time_s=draw(doubles),
        steps=draw(st.integers(0, 2**60)),
        seconds=draw(doubles),
        provenance=draw(provenances),
        trajectory=draw(st.none() | st.builds(Trajectory, *[column] * 5)),
    )


@settings(max_examples=50)
@given(incline_runs())
def test_a_run_of_the_incline_comes_back_bit_by_bit(run):
    assert same(run, unpack_incline(pack_incline(run), run.case))


@pytest.mark.parametrize("profiles", [False, True])
@pytest.mark.parametrize("case", [Tower(height=2), Tower(height=1, mass=(1.0, 3.0), law="overlap")])
def test_a_run_of_the_tower_comes_back_bit_by_bit(case, profiles):
    run = exact.run(case, 0.01, samples=50, profiles=profiles)
    assert same(run, unpack_tower(pack_tower(run), case))


def test_the_comparison_of_this_test_sees_a_changed_bit():
    run = exact.run(Tower(height=2), 0.01, samples=50)
    other = exact.run(Tower(height=2), 0.01, samples=50)
    other.grain_force[7] = np.nextafter(other.grain_force[7], 1e9)
    assert not same(run, other)


@pytest.mark.parametrize("data", [b"", b"no archive", b"\x80\x04\x95pickle"])
def test_what_is_no_run_is_refused(data):
    with pytest.raises(DECODE_ERRORS):
        unpack_incline(data, Incline())


def test_objects_are_never_unpickled(tmp_path):
    path = tmp_path / "objects.npz"
    np.savez(path, facts=np.array([{"motion": "trapped"}], dtype=object))
    with pytest.raises(ValueError, match="pickle"):
        unpack_incline(path.read_bytes(), Incline())
