"""Names that others chose, on a terminal: they may hold letters that it would obey, or that hide others."""

import unicodedata


def printable(text: str) -> str:
    """The text with every control and formatting character replaced."""
    return "".join(letter if unicodedata.category(letter)[0] != "C" else "�" for letter in text)


def printable_lines(text: str) -> str:
    """The same of each line; the bytes of a name that is no UTF-8 are escaped, so that one sees which file it is."""
    return "\n".join(map(printable, text.encode(errors="backslashreplace").decode().split("\n")))
