"""Names in a page every module that its scripts import, so that a browser asks for all of them at once.

A browser learns what a module imports when it has read it: over a slow line each level of imports waits for the one
before. The links stand at the end and give way to styles, since a page is painted before its program runs.
"""

import re
from pathlib import Path

SCRIPT = re.compile(r'<script type="module" src="/static/([^"]+)"')
IMPORT = re.compile(r'^(?:import|export)\b[^"\';]*["\'](\.[^"\']+)["\']', re.MULTILINE)  # not the types in comments
END_OF_BODY = "</body>"


def with_preloads(html: bytes, web: Path) -> bytes:
    """The page with a link for each module of the folder `web` that its scripts import, however indirectly."""
    text = html.decode()
    scripts = [web / name for name in SCRIPT.findall(text)]
    links = (
        f'<link rel="modulepreload" fetchpriority="low" href="/static/{path.relative_to(web).as_posix()}" />'
        for path in below(scripts)
    )
    return text.replace(END_OF_BODY, "".join(links) + END_OF_BODY, 1).encode()


def below(modules: list[Path]) -> list[Path]:
    """What these modules import, however indirectly, nearest first and each once; what is not there is left out."""
    found = list(dict.fromkeys(path.resolve() for path in modules))
    begun = len(found)
    for path in found:  # grows meanwhile
        imported = IMPORT.findall(path.read_text(encoding="utf-8")) if path.is_file() else []
        paths = dict.fromkeys((path.parent / name).resolve() for name in imported)
        found += [one for one in paths if one not in found and one.is_file()]
    return found[begun:]
