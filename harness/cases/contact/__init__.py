"""What the cases of contacts with friction share; no case of its own."""
