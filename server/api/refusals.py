"""What is said of a request body that is not understood: the reason, and what would be."""

import re
from collections.abc import Mapping

from msgspec import inspect

from movingout.maps.suggestion import known_names

_AT = re.compile(r" - at `(?:key in )?\$(?P<path>[^`]*)`$")
_WRONG_CHOICE = re.compile(r"^Invalid enum value (?P<given>.+?) - at")
_UNKNOWN_FIELD = re.compile(r"^Object contains unknown field `(?P<given>[^`]*)`")
_QUOTES = "'\""
_MOST = 60  # letters in which to look for what was meant


def refusal(error: Exception, kind: type) -> str:
    """The words of msgspec, and the known values or fields where one was given that is none of these.

    `kind` is the type, made of msgspec.Struct, that the body was to have.
    """
    text = str(error)
    place = _AT.search(text)
    found = _type_at(kind, place["path"] if place else "")
    if (wrong := _WRONG_CHOICE.match(text)) and isinstance(found, inspect.LiteralType):
        return f"{text}; {known_names(wrong['given'].strip(_QUOTES)[:_MOST], map(str, found.values))}"
    if (unknown := _UNKNOWN_FIELD.match(text)) and isinstance(found, inspect.StructType):
        return f"{text}; {known_names(unknown['given'][:_MOST], _fields(found))}"
    return text


def _type_at(kind: type, path: str) -> inspect.Type:
    """The type at a path such as `.seats[...].kind`; where it leads nowhere, the type before."""
    found = inspect.type_info(kind)
    for field in re.findall(r"\.(\w+)|\[", path):
        found = _struct_or_literal(found)
        if isinstance(found, inspect.StructType) and field in (known := _fields(found)):
            found = known[field]
        elif isinstance(found, inspect.ListType) and not field:
            found = found.item_type
    return _struct_or_literal(found)


def _struct_or_literal(found: inspect.Type) -> inspect.Type:
    """Of a union, such as with None, its part that has fields or values."""
    if not isinstance(found, inspect.UnionType):
        return found
    wanted = (inspect.StructType, inspect.LiteralType, inspect.ListType)
    parts = [part for part in found.types if isinstance(part, wanted)]
    return parts[0] if len(parts) == 1 else found


def _fields(struct: inspect.StructType) -> Mapping[str, inspect.Type]:
    return {field.encode_name: field.type for field in struct.fields}
