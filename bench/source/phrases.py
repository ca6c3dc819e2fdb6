"""One phrase per source file, from its docstring or first comment: the last section of docs/architecture.md.

python -m bench.source.phrases      writes the section anew
"""

import ast
import re
from collections import defaultdict
from pathlib import Path

from bench.source.files import ROOT

PAGE = ROOT / "docs" / "architecture.md"
START = "<!-- files: written by python -m bench.source.phrases -->"
FOLDERS = ("maps", "world", "recordings", "agents", "matches", "study", "server", "src/movingout", "web", "bench")
_SKIPPED = {"tests", "migrations", "__pycache__"}


def main() -> None:
    before = PAGE.read_text(encoding="utf-8").partition(START)[0]
    PAGE.write_text(before + section(ROOT), encoding="utf-8")


def section(root: Path) -> str:
    """The section as it should stand in the page, from its first line to the end of the file."""
    lines = [START, ""]
    for top in FOLDERS:
        lines += [f"### {top}", ""]
        for folder, files in sorted(_by_folder(root, top).items()):
            package = root / folder / "__init__.py"
            about = f": {phrase(package)}" if package.is_file() and phrase(package) else ""
            lines += [f"**{folder}/**{about}", ""]
            lines += [f"- `{file.name}`: {phrase(file)}" for file in files if file.name != "__init__.py"] + [""]
    return "\n".join(lines)


def phrase(file: Path) -> str:
    """The first sentence of a docstring, or of the comment that opens a JavaScript file; empty if there is none."""
    text = file.read_text(encoding="utf-8")
    opening = (ast.get_docstring(ast.parse(text)) or "") if file.suffix == ".py" else _comment(text)
    paragraph = " ".join(opening.split("\n\n")[0].split())
    sentence = re.match(r"(.+?)[.!?](?:\s|$)", paragraph)
    return sentence[1] if sentence else paragraph


def _comment(text: str) -> str:
    text = text.removeprefix("// @ts-check\n").lstrip()
    if block := re.match(r"/\*\*?(.*?)\*/", text, re.DOTALL):
        return re.sub(r"^\s*\* ?", "", block[1], flags=re.MULTILINE).strip()
    lines = re.match(r"(?://.*\n)*", text)
    return "\n".join(line[2:].strip() for line in (lines[0] if lines else "").splitlines())


def _by_folder(root: Path, top: str) -> dict[str, list[Path]]:
    found: dict[str, list[Path]] = defaultdict(list)
    for file in sorted((root / top).rglob("*")):
        inner = file.relative_to(root).parts
        if file.suffix in (".py", ".js") and not _SKIPPED & set(inner):
            found["/".join(inner[:-1])].append(file)
    return found


if __name__ == "__main__":
    main()
