"""What is kept between runs: baselines, results of engines and verifications, history."""
