"""Bad input of each command: a line with option, value and what is allowed; nothing is written."""

import pytest

from harness.cli.options import ProgramOptions
from harness.errors import RequestError

BAD = {
    "": [("verfy", "verfy", "verify")],
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
        ("--extrapolate --method steady", "--extrapolate", "--method steady"),
        ("--extrapolate --wells 3", "--extrapolate", "--wells"),
        ("--extrapolate --steps-per-contact 9", "--extrapolate", "--steps-per-contact"),
        ("--extrapolate --tolerance 0.1", "--extrapolate", "--tolerance"),
    ],
    "tower": [
        ("--height 1.5", "--height '1.5'", "whole number"),
        ("--height 0", "height = 0", "greater than or equal to 1"),
        ("--duration 1e308", "duration = 1e+308 t0", "2e9 steps"),
        ("--steps-per-contact 1e308", "1e+308 steps per contact", "2e9 steps"),
        ("--solver nix", "--solver 'nix'", "or a solver of this package: rk4, exact"),
        ("--lmp x", "--lmp 'x'", "goes with --solver lammps only"),
        ("--dask nowhere", "--dask nowhere", "goes with engines; solver 'rk4'"),
        ("--series=", "--series ''", "must be a path"),
        ("--series .", "--series .", "is a folder"),
        ("--series no/file", "--series no/file", "no folder no"),
    ],
    "impulse": [
        ("--solver exact --dask nowhere", "--dask nowhere", "solver 'exact'"),
        ("--heights 5-1", "--heights '5-1'", "as 1-19, within 1 to 10000"),
        ("--heights 1-2-9", "--heights '1-2-9'", "as 1-19"),
        ("--heights 1 --heights 0", "--heights '1,0'", "as 1-19"),
        ("--heights 1-9000", "--force", "minutes on one core"),
        ("--figure f.xyz", "--figure f.xyz", ".svg, .png, .pdf"),
        ("--reference no.csv", "--reference no.csv", "goes with --figure"),
        ("--reference no.csv --figure f.svg", "--reference no.csv", "No such file"),
        ("--figure f.svg --csv f.svg", "--figure f.svg", "another option"),
        ("--figure f.svg --reference f.svg", "--figure f.svg", "another option"),
        ("--law nix", "--law", '"overlap", "deformable", "both"'),
    ],
    "cases": [("nix", "case 'nix'", "incline"), ("tower more", "'more'", "takes")],
    "engines": [("--program nix=/x", "--program nix", "must be one of lammps")],
    "inputs": [
        ("--engine yade", "--engine yade", "needs --output"),
        ("--check --engine yade", "--engine yade", "without --check"),
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
    "reproduce": [("--check --output nowhere", "nowhere", "is not a run")],
    "site": [("nowhere", "nowhere", "is not a run"), ("--output /dev/null", "/dev/null", "file")],
    "cache": [
        ("--older-than -1", "--older-than -1", "0 days or more"),
        ("--case nix", "case 'nix'", "incline"),
        ("--cache=", "--cache ''", "must be a path"),
        ("--cache /dev/null", "--cache /dev/null", "is a file"),
        # as a folder into which the user may not look, but also for root
        (f"--cache {'x' * 300}", "--cache x", "cannot be read"),
    ],
}
OF_DOUBLES = {
    "run": [
        ("", "CASE", "see dem-harness run --help"),
        ("bounce --set stiffness=-1", "--set stiffness = '-1' N/m", "greater than 0"),
        ("bounce --set stiffness", "--set 'stiffness'", "NAME=VALUE"),
        ("bounce --set steps=20 --set steps=30", "--set", "steps is given twice"),
        ("bounce --engine nix", "--engine 'nix'", "must be one of lammps", "exact"),
        ("bounce --engine refusing", "'refusing'", "cannot run", "no springs"),
        ("bounce --quantity mass", "--quantity 'mass'", "restitution, time_s"),
        ("bounce --frames 5", "--frames 5", "goes with --film only"),
        ("bounce --film f.avi", "--film f.avi", ".gif, .mp4, .png"),
        ("bounce --profile p.txt", "--profile p.txt", ".csv"),
        ("bounce --profile p.csv --script p.csv", "--script p.csv", "another option"),
        ("bounce --film p.gif --script p.gif", "--script p.gif", "another option"),
        ("bounce --engine exact --film f.png", "--film", "a solver"),
        ("bounce --engine exact --script s", "--script", "a solver"),
        ("bounce --cache /proc/x", "--cache /proc/x", "cannot be used"),
        ("bounce --dask nowhere", "--dask"),
        ("bounce --engine exact --dask nowhere", "--dask nowhere", "solver 'exact'"),
    ],
    "sweep": [
        ("bounce", "--over", "must be given"),
        ("bounce --over steps=a", "--over steps=a", "'a'"),
        ("bounce --over steps=1:2", "--over steps=1:2", "ranges as"),
        ("bounce --over steps=20 --set steps=30", "--over steps", "set by --set"),
        ("bounce --over steps=20 --set restitution=2", "--set restitution = '2'", "less than"),
        ("bounce --over steps=20 --engines nix", "--engines 'nix'", "exact"),
        ("bounce --over steps=20 --reference no.csv", "--reference no.csv", "No such file"),
        ("bounce --over steps=20 --output bad.toml", "--output bad.toml", "file"),
        ("bounce --over steps=1:1000:1000 --over restitution=0:1:500", "--over", "500000 points"),
        ("no.toml", "no.toml", "No such file"),
        ("bad.toml", "bad.toml", "--over colour=1", "no such parameter"),
    ],
    "verify": [
        ("--quick --full", "--quick and --full", "one of them"),
        ("--cases nix", "--cases 'nix'", "all, a group (balls, others)"),
        ("--cases ,", "--cases ','", "names no case"),
        ("--engines nix", "--engines 'nix'", "all, or one or more of lammps"),
        ("--engines ,", "--engines ','", "names no engine"),
        ("--only bounc/*", "--only 'bounc/*'", "matches no case/setup/quantity"),
        ("--known-defects no.toml", "--known-defects no.toml", "no such file"),
        ("--engines off --known-defects bad.toml", "bad.toml", "[defect.NAME]"),
        ("--program good", "--program 'good'", "NAME=VALUE"),
        ("--program good=x", "--program good=x", "goes with --engines good only"),
        ("--engines good --lmp x", "--lmp 'x'", "goes with --engines lammps only"),
        ("--engine-option lammps.colour=red", "lammps.colour=red", "takes the options"),
        ("--colour red", "--colour", "see dem-harness verify --help"),
        ("--output .", "--output .", "holds something already"),
    ],
}


@pytest.mark.parametrize("name", [*BAD, *OF_DOUBLES])
def test_bad_input_is_status_2_and_names_option_value_and_allowed(request, tmp_path, name):
    (tmp_path / "bad.toml").write_text('case = "bounce"\n[over]\ncolour = 1\n')
    run = request.getfixturevalue("command" if name in BAD else "harness")
    for words, option, *parts in (BAD | OF_DOUBLES)[name]:
        text = run(*filter(None, (name, *words.split())), status=2).err
        assert len(text.splitlines()) <= 2
        assert text.count(option) == 1
        for part in parts:
            assert part in text
        assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


def test_an_integrator_is_named_as_it_was_given():
    named = {"engine_option": ["reference.integrator=mfix-euler"]}
    assert ProgramOptions(**named).opening("reference") == {"integrator": "mfix-euler"}
    with pytest.raises(RequestError, match=r"^--integrator 'rk4': must be 'velocity-verlet', 'mfi"):
        ProgramOptions(integrator="rk4").opening("reference")
