"""Bad input of each command: a line with option, value and what is allowed; nothing is written."""

import pytest

BAD = {
    "theory": [
        ("--shock 2", "shock = 2.0", "from 0 to 1"),
        ("--shock a", "--shock", '"a"'),
        ("--shock 0.1 --restitution 0.2", "--shock and --restitution", "one of them"),
        ("--shape cube", "--shape", '"sphere", "disc"'),
        ("--grain-diameter 0.01", "grain-diameter = 0.01", "at least 0.81797 m"),
    ],
    "critical-angle": [
        ("--tolerance 5", "--tolerance", "Must be <= 1.0"),
        ("--wells 3", "--wells 3", "--method steady only"),
        ("--extrapolate --method steady", "--extrapolate", "--method passage only"),
        ("--extrapolate --steps-per-contact 9", "--extrapolate", "--steps-per-contact"),
    ],
    "tower": [
        ("--height 1.5", "--height '1.5'", "whole number"),
        ("--height 0", "height = 0", "greater than or equal to 1"),
        ("--solver nix", "--solver 'nix'", "or a solver of this package: rk4, exact"),
        ("--lmp x", "--lmp 'x'", "goes with --solver lammps only"),
        ("--series .", "--series .", "is a folder"),
        ("--series no/file", "--series no/file", "no folder no"),
    ],
    "impulse": [
        ("--heights 5-1", "--heights '5-1'", "as 1-19, within 1 to 10000"),
        ("--stiffness a", "--stiffness 'a'", "must be a number"),
        ("--figure f.xyz", "--figure f.xyz", ".svg, .png, .pdf"),
        ("--reference no.csv", "--reference no.csv", "goes with --figure"),
        ("--reference no.csv --figure f.svg", "--reference no.csv", "No such file"),
        ("--figure f.svg --csv f.svg", "--figure and --csv f.svg", "two files"),
    ],
    "cases": [("nix", "case 'nix'", "incline"), ("tower more", "'more'", "takes")],
    "engines": [("--program nix=/x", "--program nix", "must be one of lammps")],
    "inputs": [
        ("--engine yade", "--engine yade", "needs --output"),
        ("--check --engine yade", "--engine yade", "goes without --check"),
    ],
    "diff": [
        ("", "RUNS", "--help"),
        ("a", "diff", "two runs"),
        (". .", "is not a run", "run.json"),
    ],
    "accept": [("nowhere", "nowhere", "is not a run")],
    "releases": [
        ("1.2.3", "'1.2.3'", "as 2025.7.22.4.0"),
        ("2025.7.22.4.0 --level nix", "--level", '"quick", "default", "full"'),
        ("2025.7.22.4.0 --output /proc/x", "--output /proc/x", "cannot be written"),
    ],
    "defect": [("nix", "defect 'nix'", "`dem-harness defect` lists all")],
    "upstream": [("nowhere", "nowhere", "demNN-*.yaml")],
    "site": [("nowhere", "nowhere", "is not a run"), ("--output /dev/null", "/dev/null", "file")],
    "cache": [
        ("--older-than -1", "--older-than -1", "0 days or more"),
        ("--case nix", "case 'nix'", "incline"),
        ("--cache /dev/null", "--cache /dev/null", "is a file"),
    ],
}


@pytest.mark.parametrize(
    ("name", "words", "parts"),
    [(name, words, parts) for name, many in BAD.items() for words, *parts in many],
)
def test_bad_input_is_status_2_and_names_option_value_and_allowed(
    command, tmp_path, name, words, parts
):
    text = command(name, *words.split(), status=2).err
    assert len(text.splitlines()) <= 2
    assert text.count(parts[0]) == 1
    for part in parts:
        assert part in text
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("data", [b"\xff\xfe\x00", b"a: [", b"units: si\n"])
def test_a_test_of_lammps_that_is_none_is_named(command, tmp_path, data):
    (tmp_path / "test.yaml").write_bytes(data)
    text = command("upstream", "test.yaml", status=2).err
    assert text.startswith("dem-harness: test.yaml: ")
    assert len(text.splitlines()) == 1


def test_an_error_is_an_object_too_where_json_is_requested(answer):
    found = answer("theory", "--shock", "2", status=2)
    assert found["status"] == 2
    assert "shock = 2.0" in found["error"]
