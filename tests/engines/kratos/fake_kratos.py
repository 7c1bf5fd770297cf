"""A program that passes for a Python with Kratos: it answers each case with recorded output.

Run as ``python fake_kratos.py MODE RECORDED OPTIONS...``. At the angle 13 it does what MODE
says instead.
"""

import json
import math
import mmap
import os
import re
import signal
import sys
import time
from pathlib import Path

FAREWELL = "Deregistering DEMApplication"
REFUSAL = "RuntimeError: Error: Variable YOUNG_MODULUS should be presented.\n\nin some.cpp:32"


def misbehave(mode, log, series):
    """Spoil what was recorded, or end."""
    if mode == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif mode == "hang":
        time.sleep(60)
    elif mode == "exceed memory":
        try:
            hog = mmap.mmap(-1, 2 * 1024**3)
        except (OSError, MemoryError):
            sys.exit("MemoryError")
        return log, series + f"{len(hog)} bytes were there"
    elif mode == "nan":
        return re.sub(r"(stage = [1-9]\d* \S+) \S+", r"\1 nan", log), series
    elif mode == "half a series":
        return log, series[: len(series) // 2]
    elif mode == "no end":
        return re.sub(r"RESULT stage = [1-9].*\n", "", log), series
    elif mode == "half a log":
        return log[: len(log) // 2], series
    elif mode == "exit":
        sys.exit("a sphere moved by half the search tolerance between two searches")
    elif mode == "overflow":
        sys.exit("a velocity is not a number")
    elif mode == "refuse":
        sys.exit(REFUSAL)
    elif mode == "ends":
        sys.exit(0)
    return log, series


def main(mode, recorded, options):
    """Answer ``-c`` with a version, and a file of cases with recorded output."""
    if "-c" in options:
        if mode == "no Kratos":
            print("ImportError: libKratosDEMCore.so: cannot open shared object file", flush=True)
            sys.exit(FAREWELL)
        print("Multi-Physics 10.9\nKRATOS 10.9.1\n" + FAREWELL)
        return
    stem = recorded / Path(options[1]).stem
    for values in json.loads(Path(options[2]).read_text(encoding="utf-8")):
        log, series = (
            stem.with_suffix(end).read_text(encoding="utf-8") for end in (".txt", ".csv")
        )
        if values["gravity_x"] > 9.81 * math.sin(math.radians(12.0)):
            try:
                log, series = misbehave(mode, log, series)
            finally:
                print(FAREWELL, flush=True)
        if values["series"]:
            Path(values["series"]).write_text(series, encoding="utf-8")
        Path(values["results"]).write_text(log, encoding="utf-8")
    if mode == "killed after its work":
        os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
