import resource

import pytest


def _seconds(whose):
    used = resource.getrusage(whose)
    return used.ru_utime + used.ru_stime


@pytest.fixture
def cpu():
    """Return a function from a call to its value, its CPU time [s] and that of its processes.

    A busy machine changes neither.
    """

    def measure(call):
        whose = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
        before = [*map(_seconds, whose)]
        value = call()
        return value, *(_seconds(one) - start for one, start in zip(whose, before, strict=True))

    return measure
