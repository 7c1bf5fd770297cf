import json
import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.live


def test_quick(answer, tmp_path):
    record = answer("verify", "--quick", "--output", "run")
    assert record["status"] == 0
    extrapolated = record["extrapolated"]
    closed_form = record["closed_form_deg"]
    assert abs(extrapolated["critical_angle_deg"] - closed_form) <= 3e-4
    assert abs(extrapolated["critical_angle_deg"] - closed_form) <= extrapolated["uncertainty_deg"]
    assert extrapolated["uncertainty_deg"] <= 6e-4
    kinds = {check["kind"] for check in record["checks"]}
    assert kinds == {"analytic", "cross-code", "regression", "finding"}
    against = [check for check in record["checks"] if check["kind"] == "regression"]
    assert {check["verdict"] for check in against} == {"pass"}
    assert not any(check["triage"] for check in against)
    on_disk = json.loads((tmp_path / "run" / "results.json").read_text())
    assert on_disk["checks"] == record["checks"]
    assert set(record["scripts"]) == {p.name for p in (tmp_path / "run" / "scripts").iterdir()}
    for name in record["scripts"]:  # each script that ran left a log that names its command
        assert (
            (tmp_path / "run" / "logs" / f"{name}.log").read_text().startswith(f"# lmp -in {name}")
        )
    assert (tmp_path / "run" / "report.html").stat().st_size < 5e6
    again = answer("verify", "--quick", "--output", "again")
    assert (record["cached"], again["cached"], again["engine_runs"]) == (False, True, 0)
    assert again["checks"] == record["checks"]
    page = "report.html"
    assert (tmp_path / "again" / page).read_bytes() == (tmp_path / "run" / page).read_bytes()


def test_requests_that_cannot_be_met(harness, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "results.json").write_text("{}")
    assert "--quick and --full" in harness("verify", "--quick", "--full", status=2).stderr
    assert "holds something" in harness("verify", "--output", "full", status=2).stderr
    (tmp_path / "file").write_text("")
    assert "cannot be written" in harness("verify", "--output", "file/run", status=2).stderr


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_nothing(tmp_path, home, number, status):
    process = subprocess.Popen(
        [sys.executable, "-m", "harness", "verify", "--output", "run"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    until = time.monotonic() + 60.0
    while not (home / "cache").exists():
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.05)
    time.sleep(1.0)
    os.killpg(process.pid, number)
    _, said = process.communicate(timeout=30)
    assert process.returncode == status
    assert "nothing half-written is left" in said
    assert "Traceback" not in said
    assert list(tmp_path.iterdir()) == []


def test_a_lammps_that_dies_leaves_a_report_and_status_3(harness, tmp_path):
    fake = tmp_path / "lmp"
    fake.write_text(
        '#!/bin/sh\nif [ "$1" = "-h" ]; then\n'
        'echo "Large-scale Atomic/Molecular Massively Parallel Simulator - 1 Jan 2030"\n'
        'printf "Installed packages:\\n\\nGRANULAR MOLECULE\\n\\n"\nexit 0\nfi\nkill -SEGV $$\n'
    )
    fake.chmod(0o755)
    words = ("--quick", "--cases", "incline,drop", "--lmp", str(fake), "--output", "run")
    harness("verify", *words, status=3)
    record = json.loads((tmp_path / "run" / "results.json").read_text())
    died = [check for check in record["checks"] if check["engine_died"]]
    assert died
    assert all(check["triage"] == "engine error: crashed" for check in died)
    assert all("crashed" in check["note"] and "SIGSEGV" in check["note"] for check in died)
    for check in died:
        assert "sha256 of the script" in (tmp_path / "run" / "logs" / check["log"]).read_text()
    assert [
        c for c in record["checks"] if c["name"].startswith("theory") and c["verdict"] == "pass"
    ]


def test_an_unwritable_engine_option_leaves_no_folder(harness, tmp_path):
    harness("verify", "--quick", "--lmp", "/bin/true", "--output", "run", status=3)
    assert list(tmp_path.iterdir()) == []
