"""Which agents there are, and how an id becomes an agent.

An id is a catalogue name, with options where it takes any (`scripted:seed=3,patience=40`), a trained agent with a
checkpoint (`dp@all`), a recorded seat (`ghost:FILE#red`), or `package.module:Factory` (again with `:options`) for a
policy of the user's own. The option `lag` is everybody's (`agents.lagged`). Imports happen here, late, so that an
agent that needs torch costs nothing to those who do not use it.
"""

import importlib
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import cast

from agents.base import Agent
from agents.checkpoint import MODEL_ROOTS, checkpoint_folders, read_checkpoint
from agents.errors import AgentError, CheckpointError
from maps import map_names

OptionValue = int | float | bool | str


@dataclass(frozen=True, slots=True)
class AgentCard:
    """What a person choosing a partner should know."""

    id: str
    name: str
    kind: str  # scripted, idle, policy
    maps: str  # "all", or names joined by commas
    description: str
    scores: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Entry:
    card: AgentCard
    factory: str  # "module:attribute", imported when asked for


_ENTRIES = (
    _Entry(
        AgentCard(
            "scripted",
            "Scripted",
            "scripted",
            "all",
            "Plans its own way: fetches, hands over, and helps with whatever is too heavy for one. "
            "Options: seed and the fields of its style.",
        ),
        "agents.scripted:ScriptedAgent",
    ),
    _Entry(
        AgentCard(
            "person",
            "Scripted person",
            "scripted",
            "all",
            "One of sixty people who plan like Scripted and play each in their own way. Option: name, A01 to C20.",
        ),
        "agents.person:Person",
    ),
    _Entry(AgentCard("idle", "Idle", "idle", "all", "Stands still: the control condition."), "agents.idle:IdleAgent"),
)
_CATALOGUE = {entry.card.id: entry for entry in _ENTRIES}
LAG = "lag"  # the option of any agent: ticks by which it plays late
GHOST = "ghost"  # ghost:FILE#red, a recorded seat; never offered in a list, since it names a file of this machine


def agent_cards() -> list[AgentCard]:
    """The agents that come with the project, then those with a checkpoint, in the order to show them."""
    return [*(entry.card for entry in _ENTRIES), *trained_cards()]


def trained_cards() -> list[AgentCard]:
    """The agents with a checkpoint; a damaged one is left out here and complained of when it is loaded."""
    cards = []
    for folder in checkpoint_folders(*MODEL_ROOTS):
        try:
            card = read_checkpoint(folder).card
        except CheckpointError:
            continue
        scores = {name: score.mean for name, score in card.scores.items()}
        maps = "all" if len(card.maps) == len(map_names()) else ", ".join(card.maps)
        cards.append(AgentCard(card.id, card.name, card.kind, maps, card.description, scores))
    return cards


def agent_card(agent_id: str) -> AgentCard:
    """The card of an id, without importing the agent. Raises AgentError for an id that names nothing."""
    reference, options = _parse(agent_id)
    if reference in _CATALOGUE:
        return _CATALOGUE[reference].card
    if reference == GHOST:
        return AgentCard(agent_id, "Ghost", GHOST, "its own", f"Plays a recorded seat again: {options['recording']}.")
    if "@" in reference:
        known = {card.id: card for card in trained_cards()}
        if reference not in known:
            raise AgentError(f"unknown agent {agent_id!r}; known: {', '.join([*known, *_CATALOGUE])}")
        return known[reference]
    named = f" with {', '.join(f'{key}={value}' for key, value in options.items())}" if options else ""
    return AgentCard(agent_id, reference.rpartition(":")[2], "policy", "all", f"Your own policy {reference}{named}.")


def load_agent(agent_id: str) -> Agent:
    """Make the agent that `agent_id` names.

    Raises AgentError, in a sentence, when the id is unknown, the module is missing, an option is wrong, or the
    factory itself fails.
    """
    reference, options = _parse(agent_id)
    lag = options.pop(LAG, 0)
    factory = _factory(reference)
    _check_options(agent_id, factory, options)
    try:
        agent = factory(**options)
    except AgentError:
        raise
    except Exception as error:
        raise AgentError(f"agent {agent_id!r} could not be made: {type(error).__name__}: {error}") from error
    for method in ("reset", "act"):
        if not callable(getattr(agent, method, None)):
            raise AgentError(f"agent {agent_id!r}: {reference} returns {type(agent).__name__}, which has no {method}()")
    return _lagged(agent_id, cast(Agent, agent), lag) if lag != 0 else cast(Agent, agent)


def _lagged(agent_id: str, agent: Agent, lag: OptionValue) -> Agent:
    from agents.lagged import LaggedAgent

    try:
        return LaggedAgent(agent, cast(int, lag))
    except AgentError as error:
        raise AgentError(f"agent {agent_id!r}: {error}") from error


def _parse(agent_id: str) -> tuple[str, dict[str, OptionValue]]:
    head, _, rest = agent_id.strip().partition(":")
    if head == GHOST:
        return GHOST, {"recording": rest}
    if head in _CATALOGUE or "@" in head:
        return head, _parse_options(agent_id, rest)
    attribute, _, options = rest.partition(":")
    if not attribute.isidentifier() or not all(part.isidentifier() for part in head.split(".")):
        known = ", ".join(dict.fromkeys([*_CATALOGUE, *(card.id for card in trained_cards())]))
        raise AgentError(f"unknown agent {agent_id!r}; known: {known}, or package.module:Factory for your own")
    return f"{head}:{attribute}", _parse_options(agent_id, options)


def _factory(reference: str) -> Callable[..., object]:
    """What makes the agent: a trained one (`dp@all`), one of the catalogue, or the user's own."""
    if "@" in reference:
        return partial(_resolve("agents.serving:trained_agent"), reference)
    if reference == GHOST:
        return _resolve("agents.ghost:GhostAgent")
    entry = _CATALOGUE.get(reference)
    return _resolve(entry.factory if entry else reference)


def _parse_options(agent_id: str, text: str) -> dict[str, OptionValue]:
    options: dict[str, OptionValue] = {}
    for part in filter(None, text.split(",")):
        key, equals, value = part.partition("=")
        if not equals or not key.strip().isidentifier():
            raise AgentError(f"agent {agent_id!r}: options are written key=value,key=value; {part!r} is not")
        options[key.strip()] = _parse_value(value.strip())
    return options


def _parse_value(text: str) -> OptionValue:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _resolve(reference: str) -> Callable[..., object]:
    module_name, _, attribute = reference.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)  # a user's module lies beside the user, and never shadows ours
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise AgentError(f"cannot import {module_name!r}: {type(error).__name__}: {error}") from error
    factory = getattr(module, attribute, None)
    if not callable(factory):
        raise AgentError(f"{module_name!r} has no factory {attribute!r}")
    return cast(Callable[..., object], factory)


def _check_options(agent_id: str, factory: Callable[..., object], options: Mapping[str, OptionValue]) -> None:
    try:
        signature = inspect.signature(factory)
    except (TypeError, ValueError):
        return  # a factory written in C: it complains for itself
    try:
        signature.bind(**options)
    except TypeError as error:
        known = ", ".join(signature.parameters) or "none"
        raise AgentError(f"agent {agent_id!r}: {error}; options: {known}") from error
