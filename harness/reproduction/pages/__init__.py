"""The report of the reproduction: ledger, figures, movies and findings in one folder."""
