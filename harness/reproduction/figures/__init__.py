"""The figures of the source, drawn from our own runs."""
