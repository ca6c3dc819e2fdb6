"""HTML pages: made from Jinja2 templates that escape every value, and written whole or not at all."""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from movingout.maps.files.output_file import draft_of
from movingout.recordings.errors import RecordingError, cannot

SERVER = "http://127.0.0.1:8000"  # where links to replays lead, if nobody names another
_LAYOUT = Path(__file__).with_name("report")  # layout.html.j2 and page.css, which all reports share


def templates(folder: Path) -> Environment:
    """The templates of a folder; they may extend `layout.html.j2`."""
    return Environment(
        loader=FileSystemLoader([folder, _LAYOUT]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def check_name(path: Path) -> None:
    """Raises RecordingError unless the name ends in .html, so that a typing error does not overwrite a recording."""
    if path.suffix.lower() not in (".html", ".htm"):
        raise RecordingError(f"{path} is not the name of a page; it should end in .html")


def write_html(text: str, path: Path) -> None:
    """Write a page, over an older one if there is one. Raises RecordingError when it cannot be written."""
    check_name(path)
    try:
        with draft_of(path) as draft:
            draft.write_text(text, encoding="utf-8", errors="replace")  # names of files may be no UTF-8
    except OSError as error:
        raise cannot("write", path, error) from error
