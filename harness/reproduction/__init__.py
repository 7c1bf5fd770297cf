"""The reproduction of the source: every equation, number and figure, recomputed."""
