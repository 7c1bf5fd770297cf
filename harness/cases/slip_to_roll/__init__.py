"""A sphere that slides on a floor until it rolls."""
