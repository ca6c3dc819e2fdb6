from pathlib import Path

from bench.source.files import SourceTree

MODULE = """
class Seat:
    def take(self, chunk, *rest: int) -> None:
        try:
            pass
        except (ValueError, Exception):
            raise

async def play(*, seed: int) -> int:
    try:
        return seed
    except OSError:
        return 0
"""


def _tree(root: Path, **files: str) -> SourceTree:
    for name, text in files.items():
        path = root / name.replace("__", "/").replace("_js", ".js").replace("_py", ".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return SourceTree(root)


def test_functions_and_handlers_are_counted(tmp_path: Path) -> None:
    tree = _tree(tmp_path, maps__one_py=MODULE)
    assert tree.function_lengths == [5, 5]
    assert tree.annotated_share == 0.5  # `chunk` has no type
    assert tree.handlers == (1, 2)


def test_a_class_name_recurs_only_across_modules(tmp_path: Path) -> None:
    tree = _tree(tmp_path, maps__one_py="class A: ...\nclass B: ...", world__two_py="class A: ...\nclass C: ...\n")
    assert tree.recurring_classes == {"A": [Path("maps/one.py"), Path("world/two.py")]}


def test_long_javascript_lines_are_named_and_generated_files_left_out(tmp_path: Path) -> None:
    tree = _tree(tmp_path, web__messages_js="x" * 130, web__play__hud_js="x" * 120 + "\n" + "x" * 121)
    assert tree.long_js_lines == ["web/play/hud.js:2"]
    assert tree.folder_sizes == {Path("web/play"): 1}
