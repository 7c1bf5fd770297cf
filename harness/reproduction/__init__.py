"""The reproduction of the source: every equation, number and figure, recomputed.

In the order of the work: ``source.toml`` has what the source says, statement by statement, and
``as_printed`` its formulas and numbers; ``ledger`` recomputes and judges them by section
(``claims`` has the rules, ``facts`` the sentences); ``figure_data`` recomputes what its figures
show and ``figures`` draws it; ``movies`` runs and draws the motions of its supplement;
``findings`` are tables beyond it; ``pages`` writes all of it into a folder. ``run.reproduce``
does the whole, ``ledger_differences`` holds two ledgers against each other.
"""
