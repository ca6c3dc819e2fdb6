"""The source code keeps to the limits of the house."""

import ast
import re
import tomllib
from collections.abc import Iterator

import pytest
import yaml

from bench.house import LARGEST_FOLDER, LONGEST_FILE, main, report
from bench.source.files import SourceTree
from bench.source.import_graph import import_circles, import_graph
from movingout.server.messages_js import ANSWER_NAMES, NUMBER_NAMES
from tests.support import ROOT

TREE = SourceTree()
WRITTEN_ONCE = ("Receive", "Send")
"""Types that used to be defined again where they were needed next."""
EQUAL_BY_CHANCE = {
    "AGREE": "for what BASS simulates, and for what is imported",
    "DATA": "default folders of commands of three packages",
    "DEFAULT": "the language of reports, and the one that every text of a study has",
    "FOLDER": "where a module lies",
    "KEPT_S": "how long agents are remembered, and how long a welcome waits",
    "LANGUAGE_FILES": "beside a module",
    "LARGE": "weights that are quantised, and tensors of a file",
    "LENGTH": "of messages to agents, and between processes",
    "LOOK_S": "how often four things are looked at",
    "MARGIN": "of routes, and of standing aside",
    "MASSES": "of maps that are generated, and of the official ones",
    "MAX_BYTES": "of a chat's answer, and of a YAML file",
    "NEIGHBOURS": "of cells of two grids",
    "REST": "rows of actions in two wrappers",
    "SETTLED": "tuned for carrying together, and for dragging",
    "SLIP_TICKS": "of perturbed experts, and of late hands",
    "STANDS": "a share of full speed, and a speed",
    "VALIDATION_ROWS": "of two trainings",
}
"""Names in several modules with one value that are different facts."""
COMPARED = {"SUBPROTOCOL"}
"""Written again on purpose, on both sides of a border that nothing is imported across; a test compares the two."""


def test_no_modules_import_one_another_in_a_circle() -> None:
    assert import_circles(import_graph()) == []


def test_no_folder_has_too_many_files_of_its_own() -> None:
    assert {folder: files for folder, files in TREE.folder_sizes.items() if files > LARGEST_FOLDER} == {}


def test_no_file_is_too_long() -> None:
    assert {file: lines for file, lines in TREE.line_counts.items() if lines > LONGEST_FILE} == {}


def test_contributing_says_the_sizes_that_are_kept() -> None:
    rules = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert f"more than {LONGEST_FILE} lines" in rules and f"more than {LARGEST_FOLDER} files" in rules


def test_the_package_names_the_authors_and_keywords_of_the_citation() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (project["authors"], project["keywords"]) == (citation["authors"], citation["keywords"])
    assert project["classifiers"]


def test_no_class_name_has_two_meanings() -> None:
    assert TREE.recurring_classes == {}


def constants() -> Iterator[tuple[str, ast.expr, str]]:
    """Name without `_`, value and module of what is assigned at the top of a module, with a type or without one."""
    for path, tree in TREE.python.items():
        for node in tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
            if isinstance(node, ast.Assign | ast.AnnAssign) and node.value and isinstance(targets[0], ast.Name):
                yield targets[0].id.lstrip("_"), node.value, str(path)


@pytest.mark.parametrize("name", WRITTEN_ONCE)
def test_a_type_is_written_once(name: str) -> None:
    homes = [path for found, _, path in constants() if found == name]
    assert len(homes) == 1, homes


def test_a_fact_is_written_once() -> None:
    homes: dict[tuple[str, str], list[str]] = {}
    for name, value, path in constants():
        small = isinstance(value, ast.Constant) and type(value.value) is int and abs(value.value) < 10
        text = ast.unparse(value)
        if re.fullmatch("[A-Z][A-Z0-9_]+", name) and not small and not text.startswith("logging."):
            homes.setdefault((name, text), []).append(path)
    again = {name: paths for (name, _), paths in homes.items() if len(paths) > 1}
    assert {name: paths for name, paths in again.items() if name not in EQUAL_BY_CHANCE.keys() | COMPARED} == {}
    assert EQUAL_BY_CHANCE.keys() | COMPARED <= again.keys()  # no exception outlives its reason


def test_pages_declare_no_number_that_messages_js_has() -> None:
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (ROOT / "web").rglob("*.js")
        if path.name != "messages.js"
        for name in re.findall(r"^(?:export )?const (\w+) =", path.read_text(encoding="utf-8"), re.MULTILINE)
        if name in (*NUMBER_NAMES, *ANSWER_NAMES)
    }
    assert found == set()


def test_which_ends_of_a_round_count_is_written_once() -> None:
    homes = {
        str(path)
        for path, tree in TREE.python.items()
        for types in [{node.slice for node in ast.walk(tree) if isinstance(node, ast.Subscript)}]
        for node in ast.walk(tree)
        if isinstance(node, ast.Tuple | ast.List | ast.Set) and node not in types
        if {one.value for one in node.elts if isinstance(one, ast.Constant)} == {"delivered", "time"}
    }
    assert homes == {"recordings/episode.py"}


def test_every_function_is_annotated_and_no_javascript_line_is_too_long() -> None:
    assert TREE.annotated_share == 1.0
    assert TREE.long_js_lines == []


@pytest.mark.slow
def test_the_report_is_one_markdown_table_with_what_is_behind_it(capsys: pytest.CaptureFixture[str]) -> None:
    main()
    out = capsys.readouterr().out
    assert "| import circles | 0 | 0 |" in out and "| functions with all types annotated | 100.0 % | 100 % |" in out
    assert report(TREE) in out
