"""Which agents exist, and how an id becomes an agent.

An id is a catalogue name, with options where it takes any (`scripted:seed=3,patience=40`), a trained agent with a
checkpoint (`dp@all`), a recorded seat (`ghost:FILE#red`), a policy's file (`onnx:path=policy.onnx`), a language model
(`llm:model=…,url=…`), a name that an installed package has registered, or `package.module:Factory` (again with
`:options`) for a policy of your own. Every agent takes the option `lag` (`agents.baseline.delayed_agent`). Modules of
agents are imported when they are loaded, so that heavy dependencies cost nothing until then.
"""

import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import cast

from movingout.agents.adapters.policy_file import POLICY_FILES, existing, id_of_file, policy_file
from movingout.agents.agent_options import OptionValue, check_none_twice, checked_options, number_in, parse_options
from movingout.agents.around_others import inner_id
from movingout.agents.base import Agent
from movingout.agents.built_in import AROUND_OTHERS, BUILT_IN, AgentCard
from movingout.agents.checkpoint.card import OTHER_MAPS, Card
from movingout.agents.checkpoint.checkpoint import (
    checkpoint_folders,
    damage,
    find_checkpoint,
    folder_name,
    missing_models,
    model_roots,
    named_instead,
    readable_checkpoints,
)
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.factories import check_methods, factory_at
from movingout.agents.fault_place import located
from movingout.agents.kinds.registry import KINDS, kind_of
from movingout.agents.llm.model_id import LLM, model_id
from movingout.maps import MovingOutError, map_names
from movingout.maps.extras import AGENTS, installed, package_of
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.maps.files.list_file import LIST
from movingout.maps.generated.names import PREFIX
from movingout.maps.suggestion import known_names, probably_meant
from movingout.recordings.recorded_seat import GHOST

UNSEEN_TCR = "TCR with unseen scripted people"
UNSEEN_NFD = "NFD with unseen scripted people"
ALONE_TCR = "TCR of these people with an idle partner"
"""Names of the scores of a trained agent that are shown to a person who chooses a partner."""

_GROUPS = ("people", "family", "families")  # of partners (agents.partners.families), where commands take several
LAG = "lag"  # option of every agent: delay in ticks


def agent_cards() -> list[AgentCard]:
    """The built-in agents, those with a checkpoint, then those of installed packages, in display order."""
    return [*(entry.card for entry in BUILT_IN.values()), *trained_cards(), *map(_installed_card, _registered())]


def open_to_all(agent_id: str) -> bool:
    """Whether an id may come from anybody: it names an agent of `agent_cards`, and no file, module or address.

    Options of built-in and of trained agents are harmless, but for those that name another agent; those of installed
    packages are not known.
    """
    reference, _, options = agent_id.strip().partition(":")
    if reference not in [card.id for card in agent_cards()] or (options and reference in _registered()):
        return False
    named = [part.partition("=") for part in options.split(",")] if reference in AROUND_OTHERS else []
    return all(open_to_all(other.replace(";", ",")) for key, _, other in named if key.strip() in AROUND_OTHERS.values())


def _registered() -> list[str]:
    """Names of agents that installed packages have registered as entry points, unless they mean something else."""
    return [name for name in installed(AGENTS) if name.isidentifier() and name not in _reserved()]


def _reserved() -> frozenset[str]:
    return frozenset((*BUILT_IN, *POLICY_FILES, GHOST, LLM))


def _installed_card(name: str) -> AgentCard:
    entry = installed(AGENTS)[name]
    return AgentCard(name, name, "policy", "all", f"Of the package {package_of(entry)}: {entry.value}.")


def trained_cards() -> list[AgentCard]:
    """The agents with a readable checkpoint of a known kind; `damaged_cards` describes the others."""
    readable = readable_checkpoints(*model_roots())
    return [_trained_card(checkpoint.card) for checkpoint in readable if checkpoint.card.kind in KINDS]


def damaged_cards() -> list[str]:
    """One sentence per agent that `agent_cards` leaves out: what is wrong with its checkpoint, or with its name."""
    sentences = damage(*model_roots())
    for checkpoint in readable_checkpoints(*model_roots()):
        try:
            kind_of(checkpoint.card)
        except CheckpointError as error:
            sentences.append(str(error))
    for name in sorted(set(installed(AGENTS)) - set(_registered())):
        why = "is taken" if name in _reserved() else "is no name: letters, digits and _ only"
        sentences.append(f"the agent {name!r} of {package_of(installed(AGENTS)[name])}: its name {why}")
    return sentences


def _trained_card(card: Card) -> AgentCard:
    scores = {name: score.mean for name, score in card.scores.items()}
    maps = "all" if set(card.maps) >= set(map_names()) else ", ".join(card.maps)
    policy = card.policy.kind if card.policy else card.kind
    layout = card.policy.layout if card.policy else ""
    population = card.training.population
    offered = card.kind not in KINDS or KINDS[card.kind].offered
    return AgentCard(card.id, card.name, card.kind, maps, card.description, scores, policy, population, layout, offered)


def agent_card(agent_id: str) -> AgentCard:
    """The card of an id, without importing the agent.

    Raises AgentError for an unknown id, CheckpointError for a damaged card.
    """
    reference, options = id_parts(agent_id)
    if reference in BUILT_IN:
        return BUILT_IN[reference].card
    if reference == GHOST:
        return AgentCard(agent_id, "Ghost", GHOST, "its own", f"Replays a recorded seat: {options['recording']}.")
    if reference in POLICY_FILES:
        kind, path = POLICY_FILES[reference], policy_file(agent_id)
        if path is not None:
            if sentence := named_instead(path):
                raise AgentError(sentence)
            existing(reference, path, folder=path.is_dir())
        return AgentCard(
            agent_id, path.name if path else kind.title, "policy", "all", f"A policy of {kind.title}: {path}."
        )
    if reference == LLM:
        which = model_id(options.get("model", ""), options.get("url", ""))
        about = f"The language model {which.model} at {which.url} chooses among scripted skills."
        return AgentCard(agent_id, which.model, LLM, "all", about)
    if reference in _registered():
        return replace(_installed_card(reference), id=agent_id)
    if "@" in reference:
        if any(folder.name == folder_name(reference) for folder in checkpoint_folders(*model_roots())):
            return _trained_card(find_checkpoint(reference, *model_roots()).card)
        known = [*(card.id for card in trained_cards()), *BUILT_IN, *_registered()]
        raise AgentError(f"unknown agent {agent_id!r}; {known_names(reference, known)}{missing_models()}")
    named = f" with {', '.join(f'{key}={value}' for key, value in options.items())}" if options else ""
    return AgentCard(agent_id, reference.rpartition(":")[2], "policy", "all", f"Your own policy {reference}{named}.")


def unseen_map(agent_id: str, map_name: str) -> str:
    """A sentence saying that an agent was not trained on a map; empty if it was, or if it is not a trained agent."""
    return unseen_maps(agent_id, [map_name])


def unseen_maps(agent_id: str, names: Sequence[str]) -> str:
    """Likewise of several maps; those that it was trained on are left out.

    Who learned on generated maps learned for maps that it has never seen, and a card may have no room for all maps:
    nothing is then said of any.
    Variants of a map (Challenge 2) share its name and count as known.
    """
    reference = agent_id.strip().partition(":")[0]
    if "@" not in reference:
        return ""
    maps = find_checkpoint(reference, *model_roots()).card.maps
    unseen = [name for name in names if name not in maps]
    if not unseen or PREFIX in maps or OTHER_MAPS in maps:
        return ""
    others = ", ".join(maps) if len(maps) <= 3 else f"{len(maps)} others"
    which = f"map{'s' * (len(unseen) > 1)} {', '.join(unseen)}"
    return f"{agent_id} has never seen the {which}: it was trained on {others}."


def load_agent(agent_id: str) -> Agent:
    """Make the agent that `agent_id` names.

    Raises AgentError when the id is unknown, the module is missing, an option is wrong or stands twice, or the factory
    fails.
    """
    if not isinstance(agent_id, str):
        raise AgentError(f'the id of an agent is text, such as "scripted", not {agent_id!r:.80}')
    check_options_once(agent_id)
    return load_admitted_agent(agent_id)


def load_admitted_agent(agent_id: str) -> Agent:
    """The same, but of an option that stands twice the last one counts: studies that began so go on."""
    reference, options = id_parts(agent_id)
    lag = number_in(options.pop(LAG, 0))
    factory = _factory(reference)
    options = checked_options(agent_id, factory, options)
    agent = _made(agent_id, reference, partial(factory, **options))
    try:
        check_methods(agent, reference)
    except AgentError as error:
        raise AgentError(f"agent {agent_id!r}: {error}") from None
    return _delayed(agent_id, cast(Agent, agent), lag) if lag != 0 else cast(Agent, agent)


def _made(agent_id: str, reference: str, make: Callable[[], object]) -> object:
    """What a factory makes. Raises AgentError for whatever it raises."""
    with noticing_ctrl_c():
        try:
            with redirect_stdout(sys.stderr):  # what it prints is no part of a command's answer
                return make()
        except CheckpointError as error:
            if "@" not in reference or reference in str(error):
                raise
            raise CheckpointError(f"{reference}: {error}") from error
        except AgentError:
            raise
        except MovingOutError as error:
            raise AgentError(f"agent {agent_id!r}: {error}") from error
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            sentence = f"agent {agent_id!r} could not be made: {type(error).__name__}: {error}"
            raise AgentError(located(sentence, error)) from error


def load_live_agent(agent_id: str) -> Agent:
    """As `load_admitted_agent`. Raises AgentError for one whose decisions wait for somebody else: rooms would wait."""
    agent = load_admitted_agent(agent_id)
    if any(getattr(one, "waits", False) for one in (agent, getattr(agent, "agent", None))):
        raise AgentError(f"{agent_id} waits for its answers, which is for matches without people: leave out wait=yes")
    return agent


def _delayed(agent_id: str, agent: Agent, lag: OptionValue) -> Agent:
    from movingout.agents.baseline.delayed_agent import DelayedAgent

    try:
        return DelayedAgent(agent, cast(int, lag))
    except AgentError as error:
        raise AgentError(f"agent {agent_id!r}: {error}") from error


def factory_of(agent_id: str) -> Callable[..., object]:
    """What makes the agent that `agent_id` names. Raises AgentError as `load_agent`, but for the options' values."""
    return _factory(id_parts(agent_id)[0])


def _names() -> list[str]:
    """What an id may begin with, for answers to one that is unknown."""
    return list(dict.fromkeys([*(card.id for card in agent_cards()), *POLICY_FILES, LLM, _GROUPS[-1]]))


def check_options_once(agent_id: str) -> None:
    """Raises AgentError for an option that stands twice, in the id or in that of an agent inside."""
    try:
        text = _reference_and_options(agent_id)[1]
    except AgentError:  # which says more where it is loaded
        return
    check_none_twice(agent_id, text)
    if inner := inner_id(agent_id):
        check_options_once(inner)


def id_parts(agent_id: str) -> tuple[str, dict[str, OptionValue]]:
    """What an id names, and the options behind it. Raises AgentError."""
    head, _, rest = agent_id.strip().partition(":")
    if head == GHOST:
        return GHOST, {"recording": rest}
    reference, text = _reference_and_options(agent_id)
    return reference, parse_options(agent_id, text)


def _reference_and_options(agent_id: str) -> tuple[str, str]:
    """Likewise with the options as they are written; a recorded seat has none."""
    head, _, rest = agent_id.strip().partition(":")
    if head == GHOST:
        return GHOST, ""
    if head in _GROUPS or head.startswith(LIST):
        where = "" if head.startswith(LIST) else ", which `movingout demos people` lists"
        raise AgentError(f"{agent_id} names several partners; name one of them{where}")
    named = "@" in head or head in BUILT_IN or head in POLICY_FILES or head == LLM
    if named or (head in _registered() and (not rest or "=" in rest.partition(":")[0])):
        return head, rest
    attribute, _, options = rest.partition(":")
    if head.endswith(".py"):
        file = Path(head).with_suffix("")
        module = ".".join(file.parts) if all(part.isidentifier() for part in file.parts) else file.name
        right = f"{module}:{attribute or 'Factory'}"
        raise AgentError(f"unknown agent {agent_id!r}; name the module instead of its file: {right}")
    if sentence := named_instead(Path(head)):
        raise AgentError(sentence)
    if right := id_of_file(head):
        raise AgentError(f"unknown agent {agent_id!r}; name the file with its kind: {right}")
    if not attribute.isidentifier() or not all(part.isidentifier() for part in head.split(".")):
        known = known_names(head, _names())
        raise AgentError(f"unknown agent {agent_id!r}; {known}, or package.module:Factory for your own")
    return f"{head}:{attribute}", options


def _factory(reference: str) -> Callable[..., object]:
    """The factory of a trained agent (`dp@all`), of one in the catalogue, or of your own."""
    if "@" in reference:
        checkpoint = find_checkpoint(reference, *model_roots())
        return partial(kind_of(checkpoint.card).load, checkpoint)
    if reference == GHOST:
        return factory_at("movingout.agents.baseline.replay_agent:ReplayAgent")
    if reference == LLM:
        return factory_at("movingout.agents.llm.agent:llm_agent")
    if reference in POLICY_FILES:
        return factory_at(POLICY_FILES[reference].factory)
    if reference in _registered():
        return factory_at(installed(AGENTS)[reference].value)
    entry = BUILT_IN.get(reference)
    return factory_at(entry.factory) if entry else _own_factory(reference)


def _own_factory(reference: str) -> Callable[..., object]:
    module = reference.partition(":")[0]
    try:
        return factory_at(reference)
    except AgentError as error:
        cause = error.__cause__
        absent = isinstance(cause, ModuleNotFoundError) and cause.name == module
        if absent and (meant := probably_meant(module, [*_names(), *_GROUPS])):
            raise AgentError(f"cannot import {module!r}: there is no such module{meant}") from cause
        raise
