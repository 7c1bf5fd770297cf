import pytest


@pytest.mark.live
def test_lammps_is_found_both_ways(answer):
    ways = {row["how"]: row for row in answer("engines")["engines"]}
    assert ways.keys() == {"in-process", "executable", "compiled"}
    del ways["compiled"]  # the reference DEM
    for row in ways.values():
        assert row["available"], row["reason"]
        assert "GRANULAR" in row["packages"]
    assert ways["in-process"]["engine_version"] == ways["executable"]["engine_version"]


def test_a_missing_executable_is_said_and_is_no_error(answer):
    ways = {row["how"]: row for row in answer("engines", "--lmp", "/nowhere/lmp")["engines"]}
    assert not ways["executable"]["available"]
    assert "/nowhere/lmp" in ways["executable"]["reason"]
