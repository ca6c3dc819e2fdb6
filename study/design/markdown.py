"""Markdown as the pages of participants show it: they take no styles, and no pictures from elsewhere."""

import re
from collections.abc import Iterator
from functools import cache

from markdown_it import MarkdownIt
from markdown_it.token import Token

_ALIGNED = "text-align:"
_REFUSED = re.compile(r"!\[[^\]]*\]\((data:[^\s;,)]*)")  # is shown as the letters that it is
_markdown = MarkdownIt("commonmark", {"html": False}).enable("table")


@cache
def html(text: str) -> str:
    """Columns of tables are aligned by an attribute."""
    names: dict[str, object] = {}  # of links that are defined below the text
    tokens = _markdown.parse(text, names)
    for token in tokens:
        if str(token.attrGet("style")).startswith(_ALIGNED):
            token.attrSet("align", str(token.attrs.pop("style")).removeprefix(_ALIGNED))
    return str(_markdown.renderer.render(tokens, _markdown.options, names))


def unseen_pictures(text: str) -> Iterator[str]:
    """The addresses of pictures that are not within the text, and the kinds of those that no page shows, as of SVG."""
    for token in _inside(_markdown.parse(text)):
        address = str(token.attrGet("src") or "")
        if token.type == "image" and not address.startswith("data:"):
            yield address
        elif token.type == "text":
            yield from _REFUSED.findall(token.content)


def _inside(tokens: list[Token]) -> Iterator[Token]:
    for token in tokens:
        yield from token.children or ()
