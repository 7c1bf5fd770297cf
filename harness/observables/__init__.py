"""What a run yields, whoever made it. No files, no processes."""
