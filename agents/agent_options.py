"""The options of an agent's id: `key=value,key=value` as values, checked against what its factory takes."""

import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from typing import get_args

from movingout.agents.errors import AgentError

OptionValue = int | float | bool | str


def parse_options(agent_id: str, text: str) -> dict[str, OptionValue]:
    """Finite numbers, `true` and `false` as such, all else as text; of two with one name the last. Raises AgentError.

    A number is what Python would write alike: `007`, `1e3` and `1.10` may be names, and stay as they are. Unless the
    factory takes text, `checked_options` reads them as numbers.
    """
    return dict(written_options(agent_id, text))


def check_none_twice(agent_id: str, text: str) -> None:
    """Raises AgentError for an option that stands twice."""
    seen: set[str] = set()
    for key, _ in written_options(agent_id, text):
        if key in seen:
            raise AgentError(f"agent {agent_id!r}: {key} stands twice in its options; leave one out")
        seen.add(key)


def written_options(agent_id: str, text: str) -> Iterator[tuple[str, OptionValue]]:
    """The same, one by one, both of two with one name. Raises AgentError."""
    for part in filter(None, text.split(",")):
        key, equals, value = part.partition("=")
        if not equals or not key.strip().isidentifier():
            raise AgentError(f"agent {agent_id!r}: options are written key=value,key=value; {part!r} is not")
        yield key.strip(), _value(value.strip())


def checked_options(
    agent_id: str, factory: Callable[..., object], options: Mapping[str, OptionValue]
) -> dict[str, OptionValue]:
    """The same options, with numbers however they are written, unless the factory takes text.

    Raises AgentError, with what the factory takes, for options that it does not take or that are missing.
    """
    if "self" in options:  # which would meet the object itself
        raise AgentError(f"agent {agent_id!r}: got an unexpected keyword argument 'self'")
    try:
        signature = _signature(factory)
    except (TypeError, ValueError):
        return dict(options)  # written in C: it checks its own arguments
    try:
        signature.bind(**options)
    except TypeError as error:
        known = ", ".join(signature.parameters) or "none"
        raise AgentError(f"agent {agent_id!r}: {error}; options: {known}") from error
    others = [one for one in signature.parameters.values() if one.kind is inspect.Parameter.VAR_KEYWORD]
    taking = {name: signature.parameters.get(name) or others[0] for name in options}
    return {name: value if _takes_text(taking[name]) else number_in(value) for name, value in options.items()}


def yes_or_no(name: str, value: object) -> bool:
    """The value of an option. Raises AgentError."""
    if value in (True, "yes"):
        return True
    if value in (False, "no"):
        return False
    raise AgentError(f"{name} is yes or no, not {value!r}")


def whole_number(name: str, value: object) -> int:
    """The value of an option. Raises AgentError."""
    if type(value) is not int:
        raise AgentError(f"{name} is a whole number, not {value!r}")
    return value


def ticks_between_decisions(execute: object, horizon: int) -> int:
    """The option `execute` of a policy that decides `horizon` ticks at once; 0: as in its card. Raises AgentError."""
    if type(execute) is not int or not 0 <= execute <= horizon:
        raise AgentError(f"execute is a whole number of ticks from 1 to {horizon}, not {execute}")
    return execute


def noise_factor(noise: object) -> float:
    """The option `noise` of a policy that draws its actions. Raises AgentError."""
    if isinstance(noise, bool) or not isinstance(noise, int | float) or not 0.0 <= noise <= 2.0:
        raise AgentError(f"noise is a number from 0 to 2, not {noise}")
    return noise


def number_in(value: OptionValue) -> OptionValue:
    """A text that is a finite number as that number; anything else as it is."""
    if not isinstance(value, str):
        return value
    for kind in (int, float):
        try:
            number = kind(value)
        except ValueError:
            continue
        return value if isinstance(number, float) and not math.isfinite(number) else number
    return value


def _value(text: str) -> OptionValue:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    number = number_in(text)
    return number if str(number) == text else text


def _takes_text(parameter: inspect.Parameter) -> bool:
    """By its annotation and its default: text, and no number."""
    kinds = {*(get_args(parameter.annotation) or (parameter.annotation,)), type(parameter.default)}
    return bool(kinds & {str, "str"}) and not kinds & {int, float, "int", "float"}


def _signature(factory: Callable[..., object]) -> inspect.Signature:
    """With annotations that were written as text as what they name, where they name something."""
    try:
        return inspect.signature(factory, eval_str=True)
    except (NameError, SyntaxError, AttributeError):
        return inspect.signature(factory)
