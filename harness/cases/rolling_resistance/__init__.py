"""A rolling sphere that a resistance to rolling slows down."""
