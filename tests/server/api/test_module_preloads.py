"""The modules that a page announces in its head."""

from pathlib import Path

import pytest

from movingout.server.api.module_preloads import with_preloads
from movingout.server.api.pages import WEB

PAGE = '<head><script type="module" src="/static/play/page.js"></script></head><body>{}</body>'
MODULES = {
    "play/page.js": """
import { a } from "./near.js";
import {
  b,
} from "../core/far.js";
import "./bare.js";
""",
    "play/near.js": """
import { far } from "../core/far.js";
export { far } from "../core/far.js";
import "./page.js";
import { x } from "./gone.js";
""",
    "play/bare.js": 'export { more } from "./more.js";\nconst words = await import("./later.js");\n',
    "play/more.js": '/** @typedef {import("./later.js").Later} Later */\nexport const more = 1;\n',
    "play/later.js": "export const later = 1;\n",
    "core/far.js": "export const far = 1;\n",
}


def test_every_module_that_a_page_imports_is_named_once_the_nearest_first(tmp_path: Path) -> None:
    for name, text in MODULES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    names = ("play/near.js", "core/far.js", "play/bare.js", "play/more.js")
    links = "".join(f'<link rel="modulepreload" fetchpriority="low" href="/static/{name}" />' for name in names)
    assert with_preloads(PAGE.format("").encode(), tmp_path.resolve()) == PAGE.format(links).encode()


@pytest.mark.parametrize("page", sorted(WEB.rglob("*.html")), ids=lambda page: str(page.relative_to(WEB)))
def test_a_page_without_modules_stays_as_it_is_and_the_others_keep_their_text(page: Path) -> None:
    html = page.read_bytes()
    made = with_preloads(html, WEB.resolve())
    before, after = html.split(b"</body>")
    assert made.startswith(before) and made.endswith(after)
    assert (made == html) == (b'type="module"' not in html)
