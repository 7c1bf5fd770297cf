"""Keep results between runs: baselines, outputs of engines, verifications, the history of runs."""
