"""Names that others chose, on a terminal: they may hold letters that it would obey, or that hide others."""

import unicodedata


def printable(text: str) -> str:
    """The text with every control and formatting character replaced."""
    return "".join(letter if unicodedata.category(letter)[0] != "C" else "�" for letter in text)
