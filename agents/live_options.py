"""Whether a room could play an agent, by its id alone: no weights are read, and nobody's own code is run."""

from functools import partial

from movingout.agents.agent_options import OptionValue, checked_options, number_in
from movingout.agents.baseline.delayed_agent import DelayedAgent
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.built_in import AROUND_OTHERS, BUILT_IN
from movingout.agents.catalogue import LAG, agent_card, check_options_once, factory_of, id_parts, load_admitted_agent
from movingout.agents.checkpoint.checkpoint import find_checkpoint, model_roots
from movingout.agents.errors import AgentError
from movingout.agents.kinds.registry import kind_of
from movingout.agents.partners.wrapped import checked_inner


def check_live_agent(agent_id: str) -> None:
    """Raises AgentError, with what would be possible, for an unknown id and for options that cannot be or stand twice.

    What only loading shows comes later: damaged weights, or what an agent of one's own takes.
    """
    check_options_once(agent_id)
    check_admitted_agent(agent_id)


def check_admitted_agent(agent_id: str) -> None:
    """The same, but of an option that stands twice the last one counts."""
    agent_card(agent_id)
    reference, options = id_parts(agent_id)
    if lag := number_in(options.pop(LAG, 0)):
        _check_lag(agent_id, lag)
    if "@" in reference:
        _check_trained(agent_id, reference, options)
    elif reference in AROUND_OTHERS:
        options = checked_options(agent_id, factory_of(agent_id), options)
        if inner := checked_inner(reference, options):
            check_admitted_agent(inner)
    elif reference in BUILT_IN:
        load_admitted_agent(agent_id)  # as cheap as a check


def _check_lag(agent_id: str, lag: OptionValue) -> None:
    try:
        DelayedAgent(IdleAgent(), lag)  # type: ignore[arg-type]  # it checks its value itself
    except AgentError as error:
        raise AgentError(f"agent {agent_id!r}: {error}") from None


def _check_trained(agent_id: str, reference: str, options: dict[str, OptionValue]) -> None:
    checkpoint = find_checkpoint(reference, *model_roots())
    kind = kind_of(checkpoint.card)
    if kind.check is None:
        checked_options(agent_id, partial(kind.load, checkpoint), options)
        return
    checked = partial(kind.check, checkpoint.card)
    checked(**checked_options(agent_id, checked, options))
