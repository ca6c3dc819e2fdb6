"""A figure of the paper that shows no numbers, as a picture: what it is painted from, and the files it becomes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from PIL import Image

from movingout.matches.errors import MatchError
from movingout.matches.paper.presentation.latex_text import tex
from movingout.matches.paper.workspace import Workspace

FIGURES = Path("figures")


@dataclass(frozen=True, slots=True)
class Drawing:
    """What a picture needs, and how it is painted."""

    paint: Callable[[Workspace], Image.Image] = field(compare=False)
    agents: tuple[str, ...] = ()  # ids of trained agents
    data: tuple[str, ...] = ()  # the episodes that it shows: names of `methods.DATA_SETS`


def figure_file(label: str, ending: str) -> Path:
    """Where a file of a figure lies in the workspace."""
    return FIGURES / f"{label.replace(':', '_')}.{ending}"


def save_drawing(drawing: Drawing, label: str, title: str, notes: tuple[str, ...], space: Workspace) -> list[Path]:
    """Paint it as PNG, and write Markdown, LaTeX and HTML that show it. Raises MatchError."""
    files = {ending: figure_file(label, ending) for ending in ("md", "tex", "html", "png")}
    picture = drawing.paint(space)
    name, remarks = files["png"].name, " ".join(notes)
    caption = f"{title}. {remarks}".strip()
    texts = {
        "md": f"## {title} (`{label}`)\n\n![{title}]({name})\n\n{remarks}\n",
        "tex": f"\\begin{{figure}}[h]\n\\centering\n\\includegraphics[width=\\linewidth]{{{name}}}\n"
        f"\\caption{{{tex(caption)}}}\n\\label{{{label}}}\n\\end{{figure}}\n",
        "html": f'<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f'<h1>{escape(title)}</h1>\n<img src="{name}" alt="{escape(title)}">\n<p>{escape(remarks)}</p>\n</html>\n',
    }
    try:
        FIGURES.mkdir(parents=True, exist_ok=True)
        picture.save(files["png"], "PNG", optimize=True)
        for ending, text in texts.items():
            files[ending].write_text(text, encoding="utf-8")
    except OSError as error:
        raise MatchError(f"cannot write {files['png']}: {error.strerror or error}") from error
    return list(files.values())
