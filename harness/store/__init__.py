"""What is kept between runs: baselines, cached runs, history."""
