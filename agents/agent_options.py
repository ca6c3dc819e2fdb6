"""The options of an agent's id: `key=value,key=value` as values, checked against what its factory takes."""

import inspect
from collections.abc import Callable, Mapping

from movingout.agents.errors import AgentError

OptionValue = int | float | bool | str


def parse_options(agent_id: str, text: str) -> dict[str, OptionValue]:
    """Numbers, `true` and `false` as such, all else as text. Raises AgentError."""
    options: dict[str, OptionValue] = {}
    for part in filter(None, text.split(",")):
        key, equals, value = part.partition("=")
        if not equals or not key.strip().isidentifier():
            raise AgentError(f"agent {agent_id!r}: options are written key=value,key=value; {part!r} is not")
        options[key.strip()] = _value(value.strip())
    return options


def check_options(agent_id: str, factory: Callable[..., object], options: Mapping[str, OptionValue]) -> None:
    """Raises AgentError, with what the factory takes, for options that it does not take or that are missing."""
    try:
        signature = inspect.signature(factory)
    except (TypeError, ValueError):
        return  # written in C: it checks its own arguments
    try:
        signature.bind(**options)
    except TypeError as error:
        known = ", ".join(signature.parameters) or "none"
        raise AgentError(f"agent {agent_id!r}: {error}; options: {known}") from error


def _value(text: str) -> OptionValue:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
