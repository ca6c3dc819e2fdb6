"""What mkdocs calls while it builds the site (mkdocs.yml): adds pages that are made elsewhere, and mends links.

The pages of `docs/` are written for the repository. Links to its other files become plain text on the site.
"""

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from bench.site.commands_page import commands_page
from bench.site.yaml_page import grid_page, study_page

ROOT = Path(__file__).resolve().parents[2]
ADDED = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
_LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s#]+)(?P<anchor>#[^)\s]*)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """The pages at the top of the repository, and those that are written from the sources."""
    for source, name in ADDED.items():
        files.append(File.generated(config, name, content=(ROOT / source).read_text(encoding="utf-8")))
    for name, content in (
        ("commands.md", commands_page()),
        ("study-file.md", study_page()),
        ("grid-file.md", grid_page()),
    ):
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, page: Page, files: Files, **_: Any) -> str:
    """The page with links that work on the site."""
    sources = {site: source for source, site in ADDED.items()}
    folder = "" if page.file.src_uri in sources else "docs"
    return with_site_links(markdown, folder, {file.src_uri for file in files})


def with_site_links(markdown: str, folder: str, known: set[str]) -> str:
    """Links of a page in `folder` of the repository, as links of the site; the text alone where it has no such page."""

    def mended(link: re.Match[str]) -> str:
        target, anchor = link["target"], link["anchor"] or ""
        if ":" in target:
            return link[0]
        path = posixpath.normpath(posixpath.join(folder, target))
        name = ADDED.get(path, path.removeprefix("docs/"))
        if name in known and (path in ADDED or path.startswith("docs/")):
            return f"{link['picture']}[{link['text']}]({name}{anchor})"
        if (folder, path) == ("docs", f"docs/{target}") and not (ROOT / path).exists():
            return link[0]  # mkdocs says that it leads nowhere
        return link["text"]

    return _LINK.sub(mended, markdown)
