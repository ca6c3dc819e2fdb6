"""The partner that a server proposes, and who plays instead where that one cannot."""

from collections.abc import Sequence
from importlib.util import find_spec

from movingout.agents.catalogue import agent_card
from movingout.agents.errors import AgentError
from movingout.server.settings import PARTNER, Settings

STAND_IN = "scripted"  # needs neither weights nor onnxruntime, and a tenth of the time of a trained one
RUNTIME = "onnxruntime"


def proposed_partner(settings: Settings) -> str:
    """The operator's choice; without one the trained partner, or the scripted one where its weights do not run."""
    return STAND_IN if settings.partner == PARTNER and not _runs(PARTNER) else settings.partner


def proposed_partners(settings: Settings) -> Sequence[str]:
    """Who may take a seat for which nobody chose a partner, best first. Whom the operator names nobody replaces."""
    proposed = proposed_partner(settings)
    return (PARTNER, STAND_IN) if proposed == PARTNER else (proposed,)


def _runs(agent_id: str) -> bool:
    """Whether the weights of a trained agent are here and readable, and what runs them is installed."""
    try:
        agent_card(agent_id)
    except AgentError:
        return False
    return find_spec(RUNTIME) is not None
