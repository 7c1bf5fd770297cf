"""The command line in a process of its own, forked from one that has imported it already.

A command that ends at once is mostly imports: of numpy, pandas, numba and the harness, 0.3 to 1.7 s
of a core. The server imports them once; each command is a fork of it with its own arguments,
folder, environment and streams, that ends as an interpreter does. What a cold start shows (what
help imports, how fast it is, an interrupt while commands are imported) is tested on real ones.
"""

import atexit
import contextlib
import gc
import importlib
import json
import os
import pkgutil
import runpy
import select
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from pathlib import Path

READ_AT_START = ("PYTHON", "NUMBA", "MPL", "OMP", "OPENBLAS", "MKL")
"""Beginnings of variables that an interpreter or a library reads when it starts."""

PROGRAMS = ("worker", "templates", "__main__")
"""Modules that are programs of their own, or hold those of other codes."""


class CommandServer:
    """Starts a server, and runs command lines in forks of it."""

    def __init__(self):
        self._started_in = self._at_start(os.environ)
        self._folder = tempfile.TemporaryDirectory(prefix="commands-")
        self._unread = b""
        self._process = subprocess.Popen(
            [sys.executable, __file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=self._folder.name,
        )

    @staticmethod
    def _at_start(environment):
        return {k: v for k, v in environment.items() if k.startswith(READ_AT_START)}

    def run(self, words, cwd, timeout, env=None):
        """Return a ``CompletedProcess`` of ``python -m harness`` with these words, text as output.

        Raises ``subprocess.TimeoutExpired`` where it takes longer; it is killed then.
        """
        env = dict(os.environ if env is None else env)
        if self._at_start(env) != self._started_in:
            return subprocess.run(
                [sys.executable, "-m", "harness", *words],
                capture_output=True, text=True, timeout=timeout, cwd=cwd, env=env, check=False,
            )  # fmt: skip
        streams = [str(Path(self._folder.name, name)) for name in ("out", "err")]
        words = [str(word) for word in words]
        order = {"words": words, "cwd": str(cwd), "env": env, "streams": streams}
        print(json.dumps(order), file=self._process.stdin, flush=True)
        child = self._answer(60.0)
        try:
            status = self._answer(timeout)
        except TimeoutError:
            os.kill(child, signal.SIGKILL)
            self._answer(60.0)
            raise subprocess.TimeoutExpired(words, timeout) from None
        said = [Path(path).read_text(encoding="utf-8") for path in streams]
        return subprocess.CompletedProcess(words, status, *said)

    def _answer(self, seconds):
        # a command that ends at once answers twice before it is read: a buffer that select does
        # not see would hide the second line
        stream = self._process.stdout.fileno()
        while b"\n" not in self._unread:
            if not select.select([stream], [], [], seconds)[0]:
                raise TimeoutError
            if not (piece := os.read(stream, 4096)):
                raise EOFError("the command server has ended")
            self._unread += piece
        line, _, self._unread = self._unread.partition(b"\n")
        return int(line)

    def close(self):
        """End the server and remove its folder."""
        self._process.stdin.close()
        self._process.wait(timeout=60)
        self._process.stdout.close()
        self._folder.cleanup()


def serve():
    """Fork for each order on stdin; return in the fork, with all set as it was ordered."""
    orders, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    _import_all()
    gc.collect()
    gc.freeze()  # what is there stays: the forks share its memory
    for line in orders:
        order = json.loads(line)
        with warnings.catch_warnings():
            # threads of the linear algebra, which starts them anew in a fork
            warnings.simplefilter("ignore", DeprecationWarning)
            child = os.fork()
        if child == 0:
            orders.close()
            answers.close()
            _become(**order)
            return True
        print(child, file=answers, flush=True)
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), file=answers, flush=True)
    return False


def _import_all():
    sys.path.pop(0)  # the folder of this file
    import harness

    for module in pkgutil.walk_packages(harness.__path__, "harness."):
        if not {*PROGRAMS} & {*module.name.split(".")}:
            # what an optional package is missing for is missing in the command as well
            with contextlib.suppress(ImportError):
                importlib.import_module(module.name)


def _become(words, cwd, env, streams):
    for number, path in enumerate([os.devnull, *streams]):
        opened = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(opened, number)
        os.close(opened)
    os.environ.clear()
    os.environ.update(env)
    os.chdir(cwd)
    sys.path.insert(0, cwd)
    sys.argv[1:] = words


def _end(status):
    """End as an interpreter does, but for taking to pieces what was imported, which takes long."""
    threading._shutdown()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


if __name__ == "__main__" and serve():
    try:
        runpy.run_module("harness", run_name="__main__", alter_sys=True)
    except SystemExit as ending:
        _end(ending.code or 0)
