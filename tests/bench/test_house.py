"""The source code keeps to the limits of the house."""

import ast
import re
import tomllib

import pytest
import yaml

from bench.house import LARGEST_FOLDER, LONGEST_FILE, main, report
from bench.source.files import SourceTree
from bench.source.import_graph import import_circles, import_graph
from movingout.server.messages_js import ANSWER_NAMES, NUMBER_NAMES
from tests.support import ROOT

TREE = SourceTree()
WRITTEN_ONCE = (
    "ONE_THREAD",
    "KL_WEIGHT",
    "LATENT_WEIGHT",
    "RECONSTRUCTION_WEIGHT",
    "POSE_SECONDS",
    "Receive",
    "Send",
    "WALL_MARGIN",
    "GOAL_MARGIN",
)
"""Names that used to be defined again, with the same value, where they were needed next."""


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


@pytest.mark.parametrize("name", WRITTEN_ONCE)
def test_a_fact_is_written_once(name: str) -> None:
    homes = [
        str(path)
        for path, tree in TREE.python.items()
        for node in tree.body
        if isinstance(node, ast.Assign) and [ast.unparse(one).lstrip("_") for one in node.targets] == [name]
    ]
    assert len(homes) == 1, homes


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
