import pytest


@pytest.mark.live
def test_lammps_is_found_both_ways(answer):
    rows = answer("engines")["engines"]
    ways = {row["how"]: row for row in rows if row["engine"] == "lammps"}
    assert ways.keys() == {"in-process", "executable"}
    for row in ways.values():
        assert row["available"], row["reason"]
        assert "GRANULAR" in row["packages"]
    assert ways["in-process"]["engine_version"] == ways["executable"]["engine_version"]


def test_a_missing_executable_is_said_and_is_no_error(answer):
    rows = answer("engines", "--lmp", "/nowhere/lmp")["engines"]
    ways = {row["how"]: row for row in rows if row["engine"] == "lammps"}
    assert not ways["executable"]["available"]
    assert "/nowhere/lmp" in ways["executable"]["reason"]
