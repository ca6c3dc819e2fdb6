"""Plain text as LaTeX."""

_SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "↑": r"$\uparrow$", "↓": r"$\downarrow$", "±": r"$\pm$",
    "–": "--", "×": r"$\times$", "σ": r"$\sigma$",
}  # fmt: skip


def tex(text: str) -> str:
    """With LaTeX's own characters escaped, and arrows and signs as it writes them; `--data` keeps its two hyphens."""
    parts = ("".join(_SPECIAL.get(letter, letter) for letter in part) for part in text.split("--"))
    return "-{}-".join(parts)
