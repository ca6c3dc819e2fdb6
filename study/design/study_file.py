"""Reads study.yaml; every fault is reported with its line and the path of its field."""

import json
import re
import typing
from collections.abc import Iterable, Iterator
from contextlib import suppress
from datetime import date
from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import BaseModel, TypeAdapter, ValidationError

from movingout.maps.files.composed_name import as_stored
from movingout.maps.files.input_file import read_input
from movingout.maps.suggestion import known_names
from movingout.maps.yaml_document import (
    MAX_BYTES,
    NOT_UTF8,
    FieldPath,
    FileFault,
    YamlDocument,
    YamlError,
    list_needed,
    path_text,
    utf8_text,
)
from movingout.study.design.definition import Study
from movingout.study.design.instruments import instrument_names
from movingout.study.design.map_files import MapFiles
from movingout.study.design.sections.retention import Retention
from movingout.study.design.sections.study_model import Name
from movingout.study.errors import StudyError, StudyFileError

FILE_KEY = "file"
QUOTED_MARK, QUOTED_CRLF = '"\\U0000feff', "\\r\\n"  # in texts of files, as earlier versions kept them
_ID_LINE = re.compile(
    rb"""^(?:\xef\xbb\xbf|\xff\xfe|\xfe\xff)?id[ \t]*:[ \t]*["']?([a-z0-9][a-z0-9-]{0,47})["']?[ \t]*(?:#.*)?\r?$""",
    re.MULTILINE,
)
_ESCAPE = re.compile(r"\\r\\n|\\.", re.DOTALL)


def read_study(path: Path) -> Study:
    """The study in a file, which may be the text that an earlier version kept of it.

    Raises StudyFileError with all faults, StudyError for a file that cannot be read.
    """
    return parse_study(plain_text(_text(path)), path.name, path.parent)


def parse_study(
    text: str, name: str = "study.yaml", folder: Path | None = None, *, begun: bool = False, complete: bool = False
) -> Study:
    """The study in a text; texts given as {file: NAME} and maps are read from `folder`, if there is one.

    Of one that has begun, the parts may contradict each other: earlier versions let some of that pass. A complete one
    may name no texts in files. Raises StudyFileError with all faults.
    """
    try:
        document = YamlDocument(text)
    except YamlError as error:
        raise StudyFileError(name, [error.fault]) from None
    if not isinstance(document.value, dict):
        problem = "a study is a mapping of fields; `movingout study new` writes one"
        raise StudyFileError(name, [FileFault(1, path_text(()), problem)])
    try:
        values = _with_files(document, document.value, (), None if complete else folder)
        study = Study.model_validate(values, context=MapFiles(folder))
    except YamlError as error:
        raise StudyFileError(name, [error.fault]) from None
    except ValidationError as error:
        faults = [_fault(document, one) for one in error.errors(include_url=False) if not _follows(one)]
        raise StudyFileError(name, sorted(set(faults))) from None
    contradicting = [] if begun else _inconsistencies(study)
    found = [FileFault(document.line(path), path_text(path), message) for path, message in contradicting]
    if found:
        raise StudyFileError(name, sorted(found))
    return study


def retention_of(text: str) -> Retention:
    """The retention periods of a study file whose other parts may no longer be readable. Raises StudyError."""
    try:
        document: Any = YamlDocument(text).value
        return Retention.model_validate(document.get("retention") or {})
    except (YamlError, AttributeError, ValidationError) as error:
        raise StudyError(f"the periods of `retention` cannot be read: {error}") from None


def codes_of(text: str) -> Literal["unique"] | dict[str, str]:
    """The fixed completion codes of a study file whose other parts may no longer be readable."""
    document: Any = None
    with suppress(YamlError):
        document = YamlDocument(text).value
    codes = document.get("codes") if isinstance(document, dict) else None
    return {name: str(code) for name, code in codes.items()} if isinstance(codes, dict) else "unique"


def unread_study(path: Path, only: str = "") -> Study:
    """What stands for a study whose file cannot be read where its data are only copied: its id and its place, no more.

    The id is that of the file, of its line `id: NAME` where it is no YAML; where it has none, `only`. Raises StudyError
    where there is none either.
    """
    name = _id_of(path) or only
    if not name:
        raise StudyError(f"the id of the study in {path} cannot be read")
    study = Study.model_construct(id=name, blocks=())
    study._map_files = MapFiles(path.parent)
    return study


def _id_of(path: Path) -> str:
    """The id in a file, whatever else is wrong with it; "" if it has none."""
    try:
        content = read_input(path)
    except OSError:
        return ""
    with suppress(UnicodeDecodeError, YamlError, TypeError, KeyError, ValidationError):
        document: Any = YamlDocument(content.decode("utf-8")).value
        return TypeAdapter[str](Name).validate_python(document["id"])
    found = _ID_LINE.search(content.replace(b"\0", b""))  # which UTF-16 has between the letters
    return found[1].decode() if found else ""


def complete_text(path: Path) -> str:
    """The text of a study file that `read_study` can read, with each {file: NAME} replaced by what that file holds.

    It says everything that participants read, also after these files have changed or are no longer there. Raises
    StudyError where it would be another study, or none: data that were recorded with it could not be exported.
    """
    text, parts, end = path.read_text(encoding="utf-8-sig"), [], 0
    for start, stop, name in sorted(set(_file_places(text, yaml.compose(text, yaml.SafeLoader)))):
        parts += [text[end:start], _quoted(_text_beside(path.parent / name))]
        end = stop
    complete = "".join([*parts, text[end:]])
    if complete != text and not _is_of(complete, read_study(path), path.parent):
        raise StudyError(
            f"{path.name} cannot be kept together with the texts of its files; write each of them as {{file: NAME}}, "
            f"without tags and *aliases inside. All of it may have {MAX_BYTES >> 20} MiB"
        )
    return complete


def _is_of(text: str, study: Study, folder: Path) -> bool:
    try:
        return parse_study(plain_text(text), folder=folder, complete=True) == study
    except StudyFileError:
        return False


def _file_places(text: str, node: yaml.Node | None) -> Iterator[tuple[int, int, str]]:
    """Where each {file: NAME} begins and ends, without its anchor, and its name."""
    if isinstance(node, yaml.SequenceNode):
        for entry in node.value:
            yield from _file_places(text, entry)
    elif isinstance(node, yaml.MappingNode):
        if [key.value for key, _ in node.value] != [FILE_KEY]:
            for _, value in node.value:
                yield from _file_places(text, value)
            return
        ((key, value),) = node.value
        if node.flow_style:
            yield text.index("{", node.start_mark.index), node.end_mark.index, value.value
        else:
            yield key.start_mark.index, value.end_mark.index, value.value


def _quoted(text: str) -> str:
    """A text on one line of YAML, so that faults keep their line numbers."""
    letters = json.dumps(text, ensure_ascii=False)
    return "".join(letter if letter.isprintable() else f"\\U{ord(letter):08x}" for letter in letters)


def _text(path: Path) -> str:
    try:
        return utf8_text(read_input(path))
    except YamlError as error:
        raise StudyFileError(path.name, [error.fault]) from None
    except OSError as error:
        raise StudyError(f"cannot read {path}: {error.strerror or error}") from None


def _with_files(document: YamlDocument, value: Any, path: FieldPath, folder: Path | None) -> Any:
    """The values with each {file: NAME} replaced by the contents of that file next to the study."""
    if isinstance(value, list):
        return [_with_files(document, entry, (*path, index), folder) for index, entry in enumerate(value)]
    if not isinstance(value, dict):
        return value
    if set(value) != {FILE_KEY} or folder is None:
        return {key: _with_files(document, entry, (*path, key), folder) for key, entry in value.items()}
    file = Path(str(value[FILE_KEY]))
    if file.is_absolute() or ".." in file.parts:
        raise document.error(path, "the file must be next to the study: a relative name without ..")
    try:
        return _text_beside(folder / file)
    except UnicodeDecodeError:
        raise document.error(path, f"{value[FILE_KEY]} {NOT_UTF8}") from None
    except OSError as error:
        raise document.error(path, f"cannot read {value[FILE_KEY]}: {error.strerror or error}") from None


def _text_beside(file: Path) -> str:
    """The text without the byte order mark of Notepad, which would hide a heading, and with plain line ends."""
    return read_input(as_stored(str(file))).decode("utf-8-sig").replace("\r\n", "\n")


def plain_text(complete: str) -> str:
    """A complete text that an earlier version kept, without the byte order marks and line ends of Windows."""
    text, parts, end = complete.removeprefix("\ufeff"), [], 0
    if QUOTED_MARK not in text and QUOTED_CRLF not in text:
        return text
    for start, stop in _double_quoted(text):
        letters = text[start:stop].removeprefix(QUOTED_MARK)
        mark = '"' if len(letters) < stop - start else ""
        parts += [text[end:start], mark, _ESCAPE.sub(_plain_end, letters)]
        end = stop
    return "".join([*parts, text[end:]])


def _plain_end(escape: re.Match[str]) -> str:
    return "\\n" if escape[0] == QUOTED_CRLF else escape[0]


def _double_quoted(text: str) -> list[tuple[int, int]]:
    """Where double-quoted texts begin and end: only there is a backslash an escape. None for a faulty file."""
    try:
        tokens = list(yaml.scan(text, yaml.SafeLoader))
    except yaml.YAMLError:
        return []
    quoted = [one for one in tokens if isinstance(one, yaml.ScalarToken) and one.style == '"']
    return [(one.start_mark.index, one.end_mark.index) for one in quoted]


# ---- faults of single fields ------------------------------------------------------------------------------------


def _follows(error: Any) -> bool:
    """Whether another error already covers it: a list that is too short after a faulty entry, an alternative form."""
    if error["type"] == "literal_error" and isinstance(error["input"], dict):
        return str(error["loc"][-1]).startswith("literal[")  # `codes: unique`, or a mapping
    if error["type"] == "bool_type" and error["loc"][-1] == "bool":
        return True  # a number is needed; a truth value would do, and be warned of
    return bool(error["type"] == "too_short" and len(error["input"]) >= error["ctx"]["min_length"])


def _fault(document: YamlDocument, error: Any) -> FileFault:
    path = document.path_of(error["loc"], missing=error["type"] == "missing")
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        message = _unknown_field(path, error["input"])
    elif error["type"] == "missing":
        message = "this field is missing"
    elif error["type"] == "tuple_type":
        message = list_needed(None if path == ("partners",) else error["input"])  # these are no names, but objects
    elif error["type"] == "model_type":
        message = _fields_needed(path, error["input"])
    elif error["type"] in ("too_short", "string_too_short"):
        message = "at least one entry is needed" if error["type"] == "too_short" else "this text is empty"
    elif error["type"] == "string_type" and isinstance(error["input"], bool | int | float | date):
        message = f"a text is needed: write it in quotes, not as the YAML value {error['input']}"
    elif not isinstance(error["input"], dict | list):
        message = f"{message}, not {error['input']!r}" if "not " not in message else message
    return FileFault(document.line(path), path_text(path), message[:1].lower() + message[1:])


def _unknown_field(path: FieldPath, value: object) -> str:
    split = "in {...} a comma ends a text: put one with commas in quotes, and write 10.5, not 10,5; "
    known = known_names(str(path[-1]), _model_at(path[:-1]).model_fields)
    return f"there is no such field; {split if value is None else ''}{known}"


def _fields_needed(path: FieldPath, value: object) -> str:
    """What to say where an entry with fields is needed: how to write a partner that is only named."""
    if path[:-1] == ("partners",) and isinstance(value, str):
        name = re.sub(r"[^a-z0-9]+", "-", value.lower()).strip("-") or "NAME"
        agent = value if re.fullmatch(r"[A-Za-z][A-Za-z0-9_@-]*", value) else json.dumps(value, ensure_ascii=False)
        return f"a partner has a name in this study and an agent; write {{id: {name}, agent: {agent}}}"
    return f"fields are needed here; known: {', '.join(_model_at(path).model_fields)}"


def _model_at(path: FieldPath) -> type[BaseModel]:
    model: type[BaseModel] = Study
    for part in path:
        if isinstance(part, str) and part in model.model_fields:
            model = next(_models(model.model_fields[part].annotation), model)
    return model


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _models(argument)


# ---- faults between fields --------------------------------------------------------------------------------------


def _inconsistencies(study: Study) -> Iterator[tuple[FieldPath, str]]:
    yield from _partner_faults(study)
    yield from _questionnaire_faults(study)
    yield from _group_faults(study)
    played = {name for block in study.blocks for name in block.maps}
    for name in study.map_texts:
        if name not in played and (study.practice is None or study.practice.map != name):
            yield ("map_texts", name), f"no block plays {name!r}; played are: {', '.join(sorted(played))}"
    for key in ("partners", "blocks", "questionnaires"):
        yield from _taken((key,), getattr(study, key))
    yield from _taken(("consent", "boxes"), study.consent.boxes)
    for language in study.languages:
        if language not in study.consent.text.root:
            yield ("consent", "text"), f"the consent has no text in {language!r}, which `languages` promises"


def _taken(path: FieldPath, entries: Iterable[Any]) -> Iterator[tuple[FieldPath, str]]:
    ids = [entry.id for entry in entries]
    for index, name in enumerate(ids):
        if name in ids[:index]:
            yield (*path, index, "id"), f"{name!r} is taken; every id must be unique"


def _partner_faults(study: Study) -> Iterator[tuple[FieldPath, str]]:
    known = [partner.id for partner in study.partners]
    for number, block in enumerate(study.blocks):
        for index, name in enumerate(block.partners):
            if name not in known:
                yield ("blocks", number, "partners", index), f"unknown partner {name!r}; known: {', '.join(known)}"
        if len(set(block.partners)) < len(block.partners):
            yield ("blocks", number, "partners"), "each partner appears once in a block"
        if study.group == 1 and not block.partners:
            yield (
                ("blocks", number),
                "partners is missing: name whom participants play with, or say group: 2",
            )
        if study.group == 2 and block.partners:
            yield ("blocks", number, "partners"), "with group: 2 people play with each other; remove the partners"


def _questionnaire_faults(study: Study) -> Iterator[tuple[FieldPath, str]]:
    known = [*(one.id for one in study.questionnaires), *instrument_names()]
    used: list[tuple[FieldPath, str]] = [(("at_end", index), name) for index, name in enumerate(study.at_end)]
    if study.demographics:
        used.append((("demographics",), study.demographics))
    for number, block in enumerate(study.blocks):
        used += [(("blocks", number, "after_round", index), name) for index, name in enumerate(block.after_round)]
        used += [(("blocks", number, "after_partner", index), name) for index, name in enumerate(block.after_partner)]
    for path, name in used:
        if name not in known:
            yield path, f"unknown questionnaire {name!r}; known: {', '.join(known)}"
    for index, (path, name) in enumerate(used):
        if any(name == other and path[:-1] == at[:-1] for at, other in used[:index]):  # they would be one step
            yield path, f"{name!r} is in this list already; remove one"


def _group_faults(study: Study) -> Iterator[tuple[FieldPath, str]]:
    if study.participants % study.group:
        yield ("participants",), f"pairs need an even number of participants, not {study.participants}"
    if study.group == 1 and study.debrief is None:
        yield (
            (),
            "debrief is missing: partners are blinded, so participants must be told afterwards which ones they were",
        )
