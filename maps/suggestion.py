"""Words that messages share: the name that was probably meant and all there are, and a number with its noun."""

import difflib
from collections.abc import Iterable


def known_names(name: str, known: Iterable[str]) -> str:
    """`did you mean HandOff? known: HandOff, FourCorners` for `HandOf`; without a question where nothing is close."""
    names = list(known)
    question = probably_meant(name, names).removeprefix("; ")
    return f"{question}{' ' if question else ''}known: {', '.join(names)}"


def probably_meant(name: str, known: Iterable[str]) -> str:
    """`; did you mean HandOff?` for `HandOf`; nothing where nothing is close."""
    folded = {candidate.lower(): candidate for candidate in known}
    close = difflib.get_close_matches(name.lower(), folded, n=1)
    return f"; did you mean {folded[close[0]]}?" if close else ""


def shortened(name: str, most: int = 60) -> str:
    """A name that somebody sent, for a sentence: its beginning and `…` where it has more than `most` characters."""
    return name if len(name) <= most else f"{name[: most - 1]}…"


def counted(number: int, noun: str) -> str:
    """`1 episode`, `3 episodes`."""
    return f"{number:,} {noun}{'s' * (number != 1)}"
