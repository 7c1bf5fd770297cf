"""What the command line can do, as functions."""
