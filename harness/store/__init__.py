"""Keep results between runs: baselines, outputs of engines and verifications."""
