"""Pages of the fields of a YAML file, written from the models that read it and the comments behind their fields."""

import inspect
import re
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from movingout.matches.experiment.grid import Grid
from movingout.study.design.definition import Study

_COMMENT = re.compile(r"^    (\w+): .*?  # (.+)$", re.MULTILINE)
_NAMED = {"LocalizedText": "text, or a text per language"}
_SIMPLE = {
    "integer": "whole number",
    "number": "number",
    "boolean": "true or false",
    "string": "text",
    "null": "nothing",
}

Schema = dict[str, Any]


def study_page() -> str:
    """Markdown: the fields of study.yaml."""
    intro = (
        "What it all means is told in [study.md](study.md); `movingout study check FILE` names what is wrong in a file."
    )
    return _page("Fields of a study file", intro, Study)


def grid_page() -> str:
    """Markdown: the fields of the YAML file of a grid."""
    intro = "The guide is [experiments.md](experiments.md); `movingout match grid FILE` runs a grid."
    return _page("Fields of a grid file", intro, Grid)


def _page(title: str, intro: str, model: type[BaseModel]) -> str:
    schema = model.model_json_schema()
    models = {one.__name__: one for one in _models_below(model)}
    named = [(model.__name__, schema), *sorted(schema.get("$defs", {}).items())]
    lines = [f"# {title}", "", intro]
    for name, part in named:
        if "properties" in part and name in models:
            lines += _section(models[name], part)
    return "\n".join(lines) + "\n"


def _models_below(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """A model and those that its module, and the modules of these, know."""
    found, waiting = {model}, [model]
    while waiting:
        yield (one := waiting.pop())
        for other in vars(inspect.getmodule(one)).values():
            if isinstance(other, type) and issubclass(other, BaseModel) and other not in found:
                found.add(other)
                waiting.append(other)


def _section(model: type[BaseModel], schema: Schema) -> Iterator[str]:
    comments = dict(_COMMENT.findall(inspect.getsource(model)))
    yield from ("", f"## {model.__name__}", "", inspect.getdoc(model) or "", "")
    yield from ("| field | value | default | |", "|---|---|---|---|")
    for name, field in schema["properties"].items():
        default = "required" if name in schema.get("required", ()) else _default(field)
        yield f"| `{name}` | {_value(field)} | {default} | {_cell(comments.get(name, ''))} |"


def _default(field: Schema) -> str:
    """Empty where the default is nothing."""
    default = field.get("default")
    if default in (None, "", [], {}) or isinstance(default, dict):
        return ""
    text = ", ".join(map(str, default)) if isinstance(default, list) else str(default)
    return f"`{_cell(text.lower() if isinstance(default, bool) else text)}`"


def _value(field: Schema) -> str:
    """What may stand there, in words."""
    if "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[1]
        return _NAMED.get(name) or f"[{name}](#{name.lower()})"
    if options := field.get("anyOf") or field.get("oneOf") or field.get("allOf"):
        return " or ".join(dict.fromkeys(_value(option) for option in options if option.get("type") != "null"))
    if "enum" in field:
        return " or ".join(f"`{value}`" for value in field["enum"])
    if "const" in field:
        return f"`{field['const']}`"
    if field.get("type") == "array":
        return f"list of {_value(field.get('items', {}))}"
    if field.get("type") == "object":
        return f"mapping to {_value(of)}" if isinstance(of := field.get("additionalProperties"), dict) else "mapping"
    return (_SIMPLE.get(field.get("type", ""), "anything") + _limits(field)).strip()


def _limits(field: Schema) -> str:
    low, high = field.get("minimum"), field.get("maximum")
    if low is not None and high is not None:
        return f", {low:g} to {high:g}"
    if low is not None:
        return f", {low:g} or more"
    if (above := field.get("exclusiveMinimum")) is not None:
        return f" above {above:g}" + (f", up to {high:g}" if high is not None else "")
    if "maxLength" in field:
        return f", up to {field['maxLength']} characters"
    return ""


def _cell(text: str) -> str:
    return text.replace("|", r"\|").replace("<", "&lt;")
