"""What is kept between runs: results of engines and verifications, and the history of all runs."""
