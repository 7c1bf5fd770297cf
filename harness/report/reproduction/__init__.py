"""The report on the reproduction of the source."""
