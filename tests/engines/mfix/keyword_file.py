"""A reader of MFiX's keyword files: ``KEY = value`` pairs, several to a line, as in a namelist."""

import re

PAIR = re.compile(r"([A-Za-z_]\w*(?:\([\d:, ]+\))?)\s*=\s*")


def read_keywords(text):
    """Return the values by keyword, in capitals; arrays written in one go are lists."""
    keywords = {}
    for line in text.splitlines():
        line = re.split(r"[!#]", line)[0]
        pairs = list(PAIR.finditer(line))
        if not pairs:
            continue
        ends = [pair.start() for pair in pairs[1:]] + [len(line)]
        for pair, end in zip(pairs, ends, strict=True):
            values = [_value(word) for word in line[pair.end() : end].split()]
            key = pair[1].upper().replace(" ", "")
            if key in keywords:
                raise ValueError(f"{key} is given twice")
            keywords[key] = values[0] if len(values) == 1 else values
    return keywords


def _value(word):
    if word.startswith("'"):
        return word.strip("'")
    if word.upper().strip(".") in ("T", "TRUE"):
        return True
    if word.upper().strip(".") in ("F", "FALSE"):
        return False
    return float(re.sub("[dD]", "e", word))
