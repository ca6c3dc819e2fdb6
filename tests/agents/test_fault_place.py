"""The place of an exception is a line of the author's own file, wherever below it the exception came from."""

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

import numpy as np
import pytest

from movingout.agents.action_chunk import checked_chunk
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import LONGEST_SENTENCE, fault_place, located

OWN = """import json
import numpy as np

def plain():
    raise ValueError("no way")

def in_numpy():
    return np.zeros(3).reshape(2, 2)

def in_the_standard_library():
    return json.loads("{")

def in_compiled_code():
    return np.random.default_rng(0).normal(scale=-1.0)

def in_two_lines():
    raise ValueError("this\\nand that")

def without_a_word():
    raise StopIteration

def of_a_file():
    raise OSError("no such file: caf\\udce9.txt")
"""


def caught(call: Callable[[], object]) -> BaseException:
    with pytest.raises(Exception) as found:
        call()
    return found.value


def defined_in(path: Path, name: str) -> Callable[[], object]:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(OWN, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("own_policy", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found: Callable[[], object] = getattr(module, name)
    return found


@pytest.mark.parametrize(
    ("name", "line"), [("plain", 5), ("in_numpy", 8), ("in_the_standard_library", 11), ("in_compiled_code", 14)]
)
def test_libraries_below_the_own_line_are_passed_over(
    name: str, line: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    error = caught(defined_in(tmp_path / "mine" / "policy.py", name))
    assert fault_place(error) == f"mine/policy.py, line {line}"


def from_file(error: BaseException, name: str) -> TracebackType | None:
    """The traceback from the first frame on whose file has `name` in its path."""
    frames = error.__traceback__
    while frames is not None and name not in frames.tb_frame.f_code.co_filename:
        frames = frames.tb_next
    return frames


def test_a_path_elsewhere_shows_no_more_than_its_folder(tmp_path: Path) -> None:
    error = caught(defined_in(tmp_path / "away" / "policy.py", "plain"))
    assert fault_place(error) == "away/policy.py, line 5"


def test_an_installed_agent_is_named_by_its_own_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.agents.fault_place._INSTALLED", (tmp_path.resolve(),))
    error = caught(defined_in(tmp_path / "their_agent" / "policy.py", "plain"))
    assert fault_place(error.with_traceback(from_file(error, "their_agent"))) == "their_agent/policy.py, line 5"


def test_what_this_package_raises_has_no_place() -> None:
    error = caught(lambda: checked_chunk(np.zeros(3)))
    assert fault_place(error.with_traceback(from_file(error, "movingout"))) == ""
    assert located("no place", KeyError("never raised")) == "no place"


def test_a_long_message_keeps_its_place(tmp_path: Path) -> None:
    error = caught(defined_in(tmp_path / "own" / "policy.py", "plain"))
    sentence = located("x" * 9000, error)
    assert len(sentence) == LONGEST_SENTENCE and sentence.endswith("x (own/policy.py, line 5)")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("in_two_lines", "red raised ValueError: this and that (own/policy.py, line 17)"),
        ("without_a_word", "red raised StopIteration (own/policy.py, line 20)"),
        ("of_a_file", "red raised OSError: no such file: caf\\udce9.txt (own/policy.py, line 23)"),
    ],
)
def test_a_fault_is_one_line_whatever_the_exception_says(name: str, sentence: str, tmp_path: Path) -> None:
    error = caught(defined_in(tmp_path / "own" / "policy.py", name))
    assert located(f"red raised {type(error).__name__}: {error}", error) == sentence


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("def make():\n    raise RuntimeError('no weights')\n", "RuntimeError: no weights (placed_agent.py, line 2)"),
        ("import math\n\nmath.nothing\n", "attribute 'nothing' (placed_agent.py, line 3)"),
        ("\ndef make(:\n", "(placed_agent.py, line 2)"),
    ],
)
def test_an_agent_that_cannot_be_loaded_is_told_the_line(
    text: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "placed_agent", raising=False)
    (tmp_path / "placed_agent.py").write_text(text, encoding="utf-8")
    with pytest.raises(AgentError) as raised:
        load_agent("placed_agent:make")
    assert str(raised.value).endswith(sentence)
    assert str(tmp_path) not in str(raised.value)
