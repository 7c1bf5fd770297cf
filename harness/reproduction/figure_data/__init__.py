"""What the figures of the source are drawn from, recomputed, and whether each holds."""
