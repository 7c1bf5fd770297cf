"""A program that passes for any of the codes: it answers who it is, runs drops, and misbehaves.

Run as ``python -I player.py CODE MODE WORDS...``. It takes the batches of LAMMPS (``batch.in``). At
the speed 13 m/s sideways it does what MODE says instead, where MODE is of a run.
"""

import mmap
import os
import re
import signal
import sys
import time
from pathlib import Path

LMP = "Large-scale Atomic/Molecular Massively Parallel Simulator - {}\n"
ANSWERS = {  # of each code, who it is
    "lammps": f"\n{LMP}\nInstalled packages:\n\nGRANULAR MC \n\n",
    "liggghts": "LIGGGHTS (Version LIGGGHTS-PUBLIC {}, compiled 2022)\n\n hertz  hooke/stiffness\n",
    "yade": "Yade version: {} \n",
    "kratos": "Multi-Physics 10.9\nKRATOS {}\nDeregistering DEMApplication\n",
}
LOG = "RESULT engine_of_a_test = yes\nRESULT verdict = finished\n"
CLOCK = (0.0, 3.141592653589793e-3, 6.283185307179586e-3)  # [s] a contact time apart, k = 1e6 N/m
# a script of a user's own that prints an error, goes on, and has its words in the log
ECHO = """
if "${angle} < 0 || ${angle} > 30" then   "print 'ERROR: angle = ${angle} deg: must be less"
print 'ERROR: angle = ${angle} deg: must be less than or equal to 30'
ERROR: angle = 13 deg: must be less than or equal to 30
# Failed to allocate: not by this
run 1000
Step 10
"""
HALF = LOG[: len(LOG) // 2]
LOST = "ERROR: Lost atoms: original 10 current 9 (src/thermo.cpp:494)\n"
REFUSED = "ERROR: Illegal model type (src/input.cpp:1)\n"


def table(x):
    """Return the motion of a drop at rest at x."""
    rows = [f"{time!r},{x},1,0,-1\n" for time in CLOCK]
    return "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n" + "".join(rows)


def exhaust():
    """Ask for more memory than there is; die where it was not there."""
    try:
        mmap.mmap(-1, 2 * 1024**3)
    except (OSError, MemoryError):
        print("terminate called after throwing an instance of 'std::bad_alloc'", flush=True)
        os.abort()


def misbehave(mode, log):
    """End, hang, or return the log and the series of a mode."""
    if mode.startswith("echo, then "):
        log.write_text(HALF + ECHO, encoding="utf-8")
        mode = mode.removeprefix("echo, then ")
    if mode in ("SIGSEGV", "SIGKILL"):
        os.kill(os.getpid(), getattr(signal, mode))
    elif mode == "hang":
        time.sleep(60)
    elif mode == "exceed memory":
        exhaust()
    elif mode.startswith("exit "):
        sys.exit(int(mode.split()[1]))
    elif mode in ("refuse", "half a log"):
        log.write_text(REFUSED if mode == "refuse" else HALF, encoding="utf-8")
        sys.exit(mode == "refuse")
    series = table(13)
    return {
        "error and verdict": (LOST + LOG, series),
        "not a number": (LOG.replace("finished", "not_a_number"), series),
        "nan": (LOG, series.replace(",1,0,-1", ",nan,0,-1")),
        "half a row": (LOG, series[: series.rindex(",")] + "\n"),
    }.get(mode, (LOG, series))


def main(code, mode):
    """Answer who it is, or a batch."""
    if not Path("batch.in").exists():
        version = mode.removeprefix("version ") if mode.startswith("version ") else "9.9"
        print(ANSWERS[code].replace("{}", version))
        return
    for place in re.findall(r"^shell cd (\d+)", Path("batch.in").read_text("utf-8"), re.MULTILINE):
        folder = Path(place)
        script = (folder / "in.lmp").read_text("utf-8")
        speed = float(re.search(r"variable (?:vx|sideways) +index (\S+)", script)[1])
        log = folder / "log.txt"
        end, rows = misbehave(mode, log) if speed == 13.0 else (LOG, table(speed))
        (folder / "series.csv").write_text(rows, encoding="utf-8")
        log.write_text(end, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
