from pathlib import Path

from bench.source.walks import walks

PAGE = """# The house
## A key press, from the keyboard to the journal
1. `web/input/keyboard.js` hears it.
2. `web/play.js`: sends it.
3. `server/endpoint.py` (wire): takes it.
4. `recordings/writer.py`: writes it.
## An agent's decision
1. `server/endpoint.py`
2. `recordings/none.py`
3. `world/alone.py`
"""


def test_a_walk_is_whole_when_its_files_exist_and_are_linked(tmp_path: Path) -> None:
    files = {
        "docs/architecture.md": PAGE,
        "web/input/keyboard.js": "export const key = 1;\n",
        "web/play.js": 'import { key } from "./input/keyboard.js";\n',
        "server/endpoint.py": "def take() -> None:\n    from movingout.recordings import Writer\n",
        "recordings/__init__.py": "from movingout.recordings.writer import Writer\n",
        "recordings/writer.py": "",
        "world/alone.py": "",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    key_press, decision = walks(tmp_path)
    assert key_press.files == [
        "web/input/keyboard.js",
        "web/play.js",
        "server/endpoint.py",
        "recordings/writer.py",
    ]
    assert key_press.faults == []
    assert decision.faults == [
        "decision: recordings/none.py does not exist",
        "decision: no import links world/alone.py with a file before it",
    ]


def test_a_page_without_walks_is_a_fault(tmp_path: Path) -> None:
    assert [walk.faults for walk in walks(tmp_path)] == [
        ["docs/architecture.md has no numbered list below a heading with 'key press'"],
        ["docs/architecture.md has no numbered list below a heading with 'decision'"],
    ]
