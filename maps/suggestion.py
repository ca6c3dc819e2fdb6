"""The words of an error about a name that does not exist: the one that was probably meant, and all there are."""

import difflib
from collections.abc import Iterable


def known_names(name: str, known: Iterable[str]) -> str:
    """`did you mean HandOff? known: HandOff, FourCorners` for `HandOf`; without a question where nothing is close."""
    names = list(known)
    folded = {candidate.lower(): candidate for candidate in names}
    close = difflib.get_close_matches(name.lower(), folded, n=1)
    question = f"did you mean {folded[close[0]]}? " if close else ""
    return f"{question}known: {', '.join(names)}"
