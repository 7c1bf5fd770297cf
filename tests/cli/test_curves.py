"""``verify --reference``: a user's points of curves of bulk cases."""

import json

import pytest

from harness.cli.engine_options import EngineOptions
from harness.cli.verify import VerifyOptions, _key
from harness.store import entries

HEAD = "system,time_s,remaining\n"


@pytest.mark.parametrize(
    ("cases", "text", "told"),
    [
        ("silo", None, "--reference a.csv: No such file or directory"),
        ("silo", HEAD + "sillo,0,9\n", "a.csv, row 2: system = 'sillo': must be one of 'silo'"),
        ("silo", "system,t,n\nsilo,0,9\n", "no columns of 'silo': must be time_s and remaining"),
        ("silo", HEAD + "silo,2,9\nsilo,3,8\n", "time_s = 2 is the smallest: no run goes beyond 1"),
        ("silo", HEAD + "silo,0,x\n", "a.csv, row 2: remaining = 'x' is not a number"),
        ("tower", HEAD + "silo,0,9\n", "--cases must name one of drum, heap, penetration, silo"),
        (
            "penetration",
            'system,time_s,height_m\n"penetration: published, its whole time",0,1\n',
            "row 2: system = 'penetration: published, its whole time': must be one of "
            "'penetration'",
        ),
    ],
)
def test_points_that_cannot_be_are_refused_at_once(command, tmp_path, cases, text, told):
    if text is not None:
        (tmp_path / "a.csv").write_text(text)
    words = ("verify", "--quick", "--cases", cases, "--reference", "a.csv", "--output", "run")
    out, err = command(*words, status=2)
    assert out == ""
    assert told in err
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "run").exists()


def test_what_is_kept_is_kept_with_the_content_of_the_points(monkeypatch, tmp_path):
    monkeypatch.setattr(entries, "verification_key", lambda *_, context, **__: repr(context))
    path, other = tmp_path / "a.csv", tmp_path / "b.csv"

    def key(file, text):
        if file is not None:
            file.write_text(HEAD + text)
        chosen = VerifyOptions(quick=True, cases="silo", no_baseline=True, reference=file)
        return _key(chosen, EngineOptions())

    first = key(path, "silo,0,9\nsilo,1,8\n")
    assert key(path, "silo,0,9\nsilo,1,8\n") == first
    # rows have the name of the file
    others = key(path, "silo,0,9\nsilo,1,7\n"), key(other, "silo,0,9\nsilo,1,8\n"), key(None, "")
    assert len({first, *others}) == 4


@pytest.mark.live
@pytest.mark.slow
def test_points_are_in_the_figure_and_a_finding_says_how_far_the_code_is(command, tmp_path):
    (tmp_path / "a.csv").write_text(HEAD + "silo,0.1,1080\nsilo,0.4,640\n")
    words = ("--quick", "--cases", "silo", "--no-baseline", "--reference", "a.csv", "--json")
    checks = json.loads(command("verify", *words, "--output", "run").out)["checks"]
    (row,) = [check for check in checks if check["name"].endswith(" against a.csv")]
    assert row["name"] == "silo: lammps: remaining against a.csv"
    assert row["verdict"] == "finding"
    assert 0.0 < row["value"] < 0.5
    assert "a.csv" in (tmp_path / "run" / "figures" / "silo-discharge.svg").read_text()
