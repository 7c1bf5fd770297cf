"""Results: rows of values with verdicts, and tables of rows compared."""
