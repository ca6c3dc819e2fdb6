"""Agents given as Python objects rather than by their ids: classes, factories and instances, played in this process."""

import inspect
from collections.abc import Callable
from typing import cast

from movingout.agents.base import Agent
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.factories import check_methods
from movingout.agents.partners.families import group
from movingout.matches.errors import MatchError

AgentLike = str | Agent | Callable[[], Agent]
"""An id, an instance, or a class or function that makes instances without arguments."""


class AgentObjects:
    """Gives objects ids, by which matches and recordings name them, and finds them again."""

    def __init__(self, *agents: AgentLike) -> None:
        """`agents` are those that will be named: no object gets an id that is among them, or of a member of a group.

        Raises AgentError for an unknown group.
        """
        self._objects: dict[str, object] = {}
        self._ids = {member.agent_id for agent in agents if isinstance(agent, str) for member in group(agent)}

    def __bool__(self) -> bool:
        return bool(self._objects)

    def name(self, agent: AgentLike) -> str:
        """The id of an agent: `module:Class` for an object. Raises MatchError for what is no agent."""
        if isinstance(agent, str):
            return agent
        if not _is_instance(agent) and not callable(agent):
            raise MatchError(f"{agent!r:.80} is no agent: it has no reset() and act(), and it makes none when called")
        made_by = type(agent) if _is_instance(agent) else agent
        words = [getattr(made_by, "__module__", None) or "object", getattr(made_by, "__name__", type(agent).__name__)]
        name = ":".join(".".join(part for part in word.split(".") if part.isidentifier()) or "agent" for word in words)
        return self._registered(name, agent)

    def _registered(self, name: str, agent: object) -> str:
        number, found = 1, name
        while found in self._objects or found in self._ids:
            if self._objects.get(found) is agent:
                if _is_instance(agent):
                    raise MatchError(f"one {name} cannot play both seats; give its class, or two instances")
                return found
            number += 1
            found = f"{name}:instance={number}"
        self._objects[found] = agent
        return found

    def load(self, agent_id: str) -> Agent:
        """The agent of an id. Raises MatchError, AgentError for what is no object, or whatever its own code raises."""
        found = self._objects.get(agent_id)
        if found is None:
            return load_agent(agent_id)
        agent = found if _is_instance(found) else _made(agent_id, cast(Callable[[], object], found))
        try:
            check_methods(agent, agent_id)
        except AgentError as error:
            raise MatchError(str(error)) from None
        return cast(Agent, agent)


def _made(agent_id: str, factory: Callable[[], object]) -> object:
    """Raises MatchError for a factory that needs arguments; what it raises itself goes through."""
    try:
        inspect.signature(factory).bind()
    except TypeError as error:
        sentence = f"{agent_id} is made without arguments ({error}); give an instance instead of the class"
        raise MatchError(sentence) from error
    except ValueError:
        pass  # written in C: it checks its own arguments
    return factory()


def _is_instance(agent: object) -> bool:
    has_both = all(callable(getattr(agent, method, None)) for method in ("reset", "act"))
    return has_both and not isinstance(agent, type)
