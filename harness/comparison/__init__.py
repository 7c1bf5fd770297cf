"""Compare results: tolerances, verdicts, convergence. No files, no processes."""
