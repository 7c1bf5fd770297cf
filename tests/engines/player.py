"""A program that passes for any of the codes: it answers each drop of a batch, and misbehaves.

Run as ``python -I player.py CODE MODE WORDS...``. It takes the batches of codes with the language
of LAMMPS (``batch.in``) and of those with scripts in Python (a list of runs in JSON). At the speed
13 m/s sideways it does what MODE says instead, where MODE is of a run.
"""

import json
import mmap
import os
import re
import signal
import sys
import time
from pathlib import Path

LMP = "Large-scale Atomic/Molecular Massively Parallel Simulator - {}\n"
ANSWERS = {
    "lammps": f"\n{LMP}\nInstalled packages:\n\nGRANULAR MC \n\n",
    "liggghts": "LIGGGHTS (Version LIGGGHTS-PUBLIC {}, compiled 2022)\n\n hertz  hooke/stiffness\n",
    "yade": "Yade version: {} \n",
    "kratos": "Multi-Physics 10.9\nKRATOS {}\nDeregistering DEMApplication\n",
}
"""What each says of itself."""

LOG = "RESULT engine_of_a_test = yes\nRESULT verdict = finished\n"
CLOCK = (0.0, 3.141592653589793e-3, 6.283185307179586e-3)
"""[s] of three samples of a drop of k = 1e6 N/m and 1 kg, a contact time apart."""
ECHO = """
if "${angle} < 0 || ${angle} > 30" then   "print 'ERROR: angle = ${angle} deg: must be less"
print 'ERROR: angle = ${angle} deg: must be less than or equal to 30'
ERROR: angle = 13 deg: must be less than or equal to 30
# Failed to allocate: not by this
run 1000
Step 10
"""
"""A script of a user's own that prints an error, goes on, and has its words in the log."""

LOST = "ERROR: Lost atoms: original 10 current 9 (src/thermo.cpp:494)\n"
REFUSED = "ERROR: Illegal model type (src/input.cpp:1)\n"


def table(x):
    """Return the motion of a drop at rest at x."""
    rows = [f"{time!r},{x},1,0,-1\n" for time in CLOCK]
    return "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n" + "".join(rows)


def jobs():
    """Yield the sideways speed of each job, and its files for log and series."""
    batch = Path("batch.in")
    if batch.exists():
        for job in re.split(r"^log ", batch.read_text("utf-8"), flags=re.MULTILINE)[1:]:
            log = Path(job.split()[0])
            speed = float(re.search(r"variable (?:vx|sideways) index (\S+)", job)[1])
            yield speed, log, log.with_suffix(".csv")
        return
    for run in json.loads(Path(sys.argv[-1]).read_text("utf-8")):
        yield run["vx"][0], Path(run["results"]), Path(run["series"] or os.devnull)


def exhaust():
    """Ask for more memory than there is; return where it was there."""
    try:
        mmap.mmap(-1, 2 * 1024**3)
    except (OSError, MemoryError):
        print("terminate called after throwing an instance of 'std::bad_alloc'", flush=True)
        os.abort()


def misbehave(mode, log):
    """End, hang, or return what log and series are in a mode."""
    end, series = LOG, table(13)
    if mode.startswith("echo, then "):
        log.write_text(LOG[: len(LOG) // 2] + ECHO, encoding="utf-8")
        mode = mode.removeprefix("echo, then ")
    if mode in ("SIGSEGV", "SIGKILL"):
        os.kill(os.getpid(), getattr(signal, mode))
    elif mode == "hang":
        time.sleep(60)
    elif mode == "exceed memory":
        exhaust()
    elif mode.startswith("exit "):
        sys.exit(int(mode.split()[1]))
    elif mode.startswith("say "):
        sys.exit(mode.removeprefix("say "))
    elif mode == "raise":
        raise ValueError("no such particle")
    elif mode == "refuse":
        log.write_text(REFUSED, encoding="utf-8")
        sys.exit(1)
    elif mode == "half a log":
        log.write_text(LOG[: len(LOG) // 2], encoding="utf-8")
        sys.exit(0)
    elif mode == "error and verdict":
        end = LOST + LOG
    elif mode == "not a number":
        end = LOG.replace("finished", "not_a_number")
    elif mode == "nan":
        series = series.replace(",1,0,-1", ",nan,0,-1")
    elif mode == "half a row":
        series = series[: series.rindex(",")] + "\n"
    elif mode == "half a series":
        series = series[: series.rindex(",")]
    elif mode == "no series":
        series = ""
    return end, series


def main(code, mode):
    """Answer who it is, or a batch."""
    version = mode.removeprefix("version ") if mode.startswith("version ") else "9.9"
    if not Path("batch.in").exists() and not sys.argv[-1].endswith(".json"):
        print(ANSWERS[code].replace("{}", version))
        return
    if code == "yade":  # it has a Python of its own, and makes folders at home
        assert os.environ["HOME"] == str(Path.cwd())
        assert not any(name.startswith(("PYTHON", "OMPI_")) for name in os.environ)
    try:
        for speed, log, series in jobs():
            end, rows = misbehave(mode, log) if speed == 13.0 else (LOG, table(speed))
            if rows:
                series.write_text(rows, encoding="utf-8")
            log.write_text(end, encoding="utf-8")
    finally:
        if code == "kratos":
            print("Deregistering DEMApplication", flush=True)
    if mode.startswith("late "):
        misbehave(mode.removeprefix("late "), Path(os.devnull))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
