"""YAML texts as values with lines."""

import pytest
import yaml

from movingout.maps.yaml_document import YamlDocument, YamlError, path_text

TEXT = "name: x\nblocks:\n  - maps: [a, b]\n    rounds: 3\n"


def test_every_value_has_its_line() -> None:
    document = YamlDocument(TEXT)
    assert document.value == {"name": "x", "blocks": [{"maps": ["a", "b"], "rounds": 3}]}
    assert [document.line(path) for path in ((), ("name",), ("blocks", 0), ("blocks", 0, "rounds"))] == [1, 1, 3, 4]


def test_a_field_that_is_missing_has_the_line_of_what_it_belongs_to() -> None:
    document = YamlDocument(TEXT)
    path = document.path_of(("blocks", 0, "seats"), missing=True)
    assert (path_text(path), document.line(path)) == ("blocks[0].seats", 3)


def test_names_that_pydantic_adds_for_unions_are_not_part_of_a_path() -> None:
    location = ("blocks", "function-after[check(), tuple]", 0, "maps", "literal['all']")
    assert YamlDocument(TEXT).path_of(location, missing=False) == ("blocks", 0, "maps")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [1\n", "line 2: the file: this is not YAML"),
        ("a: 1\nb: {c: 1, c: 2}\n", "line 2: b.c: 'c' appears twice; remove one"),
        ("a: 1\nb: \x07\n", "line 2: the file: holds a control character"),
        ("a: 2026-13-45\n", "line 1: a: '2026-13-45' is not a valid value"),
        ("a: &a [*a]\n", "line 1: a[0]: an alias (*) contains itself"),
        ("? [1]\n: 2\n", "line 1: the file: the name of a field must be text"),
        ("a: " + "[" * 2000 + "]" * 2000, "line 1: the file: lists or mappings are nested too deeply"),
        ("a: " + "x" * (1 << 20), "line 1: the file: the file is larger than 1 MiB"),
    ],
)
def test_what_cannot_be_read_is_named_with_line_and_path(text: str, message: str) -> None:
    with pytest.raises(YamlError) as caught:
        YamlDocument(text)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("text", "line", "advice"),
    [
        ("a:\n  - {text: Why?, kind: text}\n", 2, "in double quotes"),
        ("a: {text: 'It wasn't'}\n", 1, "in double quotes"),
        ("a:\n\t- b\n", 2, "indent with spaces"),
        ("a: 1\nb:2\nc: 3\n", 2, "with a space after the colon"),
        ("a: 1\nb = 2\nc: 3\n", 2, "NAME: VALUE"),
        ("title: Trust: a study\n", 1, "a text with a colon"),
        ("a:\n  b: 1\n   c: 2\n", 3, "indented wrongly"),
        ("a:\n  b: 1\n c: 2\n", 3, "unlike its neighbours"),
        ("a: @home\n", 1, "put this text in double quotes"),
        ('a: "own\\den.json"\n', 1, "write /"),
        ('a: "C:\\Users\\den.json"\n', 1, "write /"),
        ("b: 1\na: 'x\nc: 2\n", 2, "closing quotation mark"),
        ("b: 1\na: 'x\n---\nc: 2\n", 2, "closing quotation mark"),
        ("a: 1\n---\nb: 2\n", 2, "remove the line ---"),
    ],
)
def test_common_slips_are_told_what_would_be_right_with_the_line_on_which_they_are(
    text: str, line: int, advice: str
) -> None:
    with pytest.raises(YamlError) as caught:
        YamlDocument(text)
    assert caught.value.fault.line == line and advice in caught.value.fault.message


def test_texts_keep_the_spaces_and_hyphens_of_word_processors() -> None:
    text = "z.\u00a0B. 5\u202f%, Haft\u00adpflicht, \N{ZERO WIDTH JOINER}"
    assert YamlDocument(f"a: '{text}'").value == {"a": text}


def test_aliases_can_be_refused() -> None:
    text = "a: &a [1]\nb: *a\n"
    assert YamlDocument(text).value == {"a": [1], "b": [1]}
    with pytest.raises(YamlError, match=r"line 2: .*no aliases \(\*a\); write it out"):
        YamlDocument(text, aliases=False)


@pytest.mark.parametrize("number", ["9" * 100_000, "1_" * 100_000 + "1", "1:" * 100_000 + "1", "0x" + "f" * 100_000])
def test_a_number_that_would_take_minutes_to_read_is_refused_shortly(number: str) -> None:
    with pytest.raises(YamlError, match="too long for a number") as refused:
        YamlDocument(f"a: {number}")
    assert len(str(refused.value)) < 200
    assert YamlDocument(f"a: '{number}'").value == {"a": number}


def test_deep_brackets_are_refused_at_once_where_aliases_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scanning them for aliases takes minutes."""
    monkeypatch.setattr(yaml, "scan", None)
    with pytest.raises(YamlError, match="nested too deeply"):
        YamlDocument("[" * 10_000, aliases=False)
