"""End a worker process with the one that started it, however that one ended."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable

LOOK_SECONDS = 1.0
"""Between two looks at the parent."""


def end_with(parent: int, clear: Callable[[], object] = lambda: None) -> None:
    """Exit once ``parent``, a process number, is no longer this process's parent.

    A thread looks for it: a worker in compiled code, or one that waits for a pipe that other
    workers hold open, would not notice a SIGKILL of the parent. ``clear`` runs before the exit.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_SECONDS)
        clear()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
