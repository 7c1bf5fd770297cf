"""What the bulk cases share: statistics over seeds."""
