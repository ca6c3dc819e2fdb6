"""Figures about our own source code: sizes, import circles, annotations, and the length of two walks through it.

    python -m bench house

Functions are counted in all Python packages; files and folders also in `web/`. The two walks are those of
docs/architecture.md: the files that a key press and an agent's decision pass through, in order.
"""

from collections.abc import Sequence

from bench.source.files import SourceTree
from bench.source.import_graph import import_circles, import_graph
from bench.source.walks import walks

LARGEST_FOLDER = 22  # files
LONGEST_FILE = 400  # lines


def main() -> None:
    print()
    print(report(SourceTree()))


def report(tree: SourceTree) -> str:
    """A Markdown table of the figures, followed by the places that break a rule."""
    circles = import_circles(import_graph())
    recurring = tree.recurring_classes
    rows = [*_sizes(tree), ("import circles", str(len(circles)), "0"), *_rules(tree)]
    rows.append(("class names in more than one module", str(len(recurring)), "0"))
    rows += [(f"files on the walk of {walk.title}", str(len(walk.files)), walk.target) for walk in walks(tree.root)]
    lines = ["| figure | now | target |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    lines += _listed("Import circles", [" ↔ ".join(circle) for circle in circles])
    lines += _listed("Long JavaScript lines", tree.long_js_lines)
    lines += _listed("Recurring class names", [f"{name}: {', '.join(map(str, p))}" for name, p in recurring.items()])
    lines += _listed("Breaks in the walks", [fault for walk in walks(tree.root) for fault in walk.faults])
    return "\n".join(lines)


def _sizes(tree: SourceTree) -> list[tuple[str, str, str]]:
    lengths = tree.function_lengths
    (folder, files), (file, lines) = (
        tree.folder_sizes.most_common(1)[0],
        max(tree.line_counts.items(), key=lambda item: item[1]),
    )
    return [
        ("functions", f"{len(lengths):,}", ""),
        ("lines of a function, p50", str(lengths[len(lengths) // 2]), ""),
        ("lines of a function, p90", str(lengths[len(lengths) * 9 // 10]), "25"),
        ("largest folder by its own files", f"{files} (`{folder}/`)", f"{LARGEST_FOLDER}"),
        ("longest file in lines", f"{lines} (`{file}`)", f"{LONGEST_FILE}"),
    ]


def _rules(tree: SourceTree) -> list[tuple[str, str, str]]:
    broad, handlers = tree.handlers
    return [
        ("functions with all types annotated", f"{100 * tree.annotated_share:.1f} %", "100 %"),
        ("broad excepts", f"{broad} of {handlers}", ""),
        ("JavaScript lines over 120 characters", str(len(tree.long_js_lines)), "0"),
    ]


def _listed(title: str, entries: Sequence[str]) -> list[str]:
    return ["", f"{title}:", "", *(f"- {entry}" for entry in entries)] if entries else []
