"""A program that passes for LAMMPS: it answers each job of a batch with a recorded log.

Run as ``python fake_lmp.py MODE LOG OPTIONS...``. At the angle 13 it does what MODE says instead.
"""

import mmap
import os
import re
import signal
import sys
import time
from pathlib import Path

GREETING = "Large-scale Atomic/Molecular Massively Parallel Simulator - 22 Jul 2025 - Update 4\n"

ECHO = """
if "${angle} < 0 || ${angle} > 30" then   "print 'ERROR: angle = ${angle} deg: must be less"
print 'ERROR: angle = ${angle} deg: must be less than or equal to 30'
ERROR: angle = 13 deg: must be less than or equal to 30
# Failed to allocate: not by this
run 1000
Step 10
"""
"""A script of a user's own that prints an error, goes on, and has its words in the log."""


def packages(mode):
    return "KSPACE MC" if mode == "without granular" else "GRANULAR MC"


def misbehave(mode, log, text):
    if mode == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif mode == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    elif mode.startswith("echo, then "):
        log.write_text(text[: len(text) // 2] + ECHO, encoding="utf-8")
        misbehave(mode.removeprefix("echo, then "), log, text)
    elif mode == "half a log is left":
        sys.exit(0)
    elif mode == "hang":
        time.sleep(60)
    elif mode == "exceed memory":
        try:
            hog = mmap.mmap(-1, 2 * 1024**3)
        except (OSError, MemoryError):
            print("terminate called after throwing an instance of 'std::bad_alloc'", flush=True)
            os.abort()
        log.write_text(text + f"# {len(hog)} bytes were there\n", encoding="utf-8")
    elif mode == "nan":
        log.write_text(re.sub(r"(RESULT margin_J = ).*", r"\1-nan", text), encoding="utf-8")
    elif mode == "half a log":
        log.write_text(text[: len(text) // 2], encoding="utf-8")
        sys.exit(0)
    elif mode == "exit":
        sys.exit(3)
    elif mode == "refuse":
        log.write_text("ERROR: Illegal model type (src/input.cpp:1)\n", encoding="utf-8")
        sys.exit(1)
    elif mode == "error and verdict":
        head, tail = text.rsplit("RESULT margin_J", 1)
        lost = "ERROR: Lost atoms: original 10 current 9 (src/thermo.cpp:494)\n"
        log.write_text(f"{head}{lost}RESULT margin_J{tail}", encoding="utf-8")


def main(mode, recorded, options):
    if "-h" in options:
        print(f"\n{GREETING}\nInstalled packages:\n\n{packages(mode)} \n\n")
        return
    if mode == "killed after its work":
        mode = ""
    ending = mode == "ends with 139"
    text = Path(recorded).read_text(encoding="utf-8")
    batch = Path("batch.in").read_text(encoding="utf-8")
    for job in re.split(r"^log ", batch, flags=re.MULTILINE)[1:]:
        log, angle = Path(job.split()[0]), float(re.search(r"angle index (\S+)", job)[1])
        text = re.sub(r"(RESULT angle_deg = ).*", rf"\g<1>{angle}", text)
        if angle == 13.0:
            misbehave(mode, log, text)
        if angle != 13.0 or mode == "" or ending:
            log.write_text(text, encoding="utf-8")
    if mode == "":
        os.kill(os.getpid(), signal.SIGKILL)
    if ending:
        sys.exit(139)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
