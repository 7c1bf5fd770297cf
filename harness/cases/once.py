"""Results that several threads or engines share, each computed once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from typing import Any, TypeVar

Value = TypeVar("Value")


class Once:
    """Keeps values by their keys: who asks first computes one, the others wait for it."""

    def __init__(self) -> None:
        self._values: dict[Hashable, Future[Any]] = {}
        self._lock = threading.Lock()

    def __call__(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Return the value of a key; raise for all what ``make`` raised."""
        with self._lock:
            first = key not in self._values
            value: Future[Value] = self._values.setdefault(key, Future())
        if first:
            try:
                value.set_result(make())
            except BaseException as error:
                value.set_exception(error)
        return value.result()
