"""Parts of a law that a case does not take."""

from __future__ import annotations

from harness.cases.contact.parameters import ContactSystem


def refused(parameters: ContactSystem, **allowed: tuple[str, ...]) -> None:
    """Raise ValueError for a part of a law that a case does not take, by its name."""
    for name, words in allowed.items():
        value = getattr(parameters, name)
        if value not in words:
            must = ", ".join(words)
            raise ValueError(f"{name} = {value!r}: must be one of {must} in this case")
