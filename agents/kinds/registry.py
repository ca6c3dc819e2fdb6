"""The kinds there are. A new one is a module beside this one, and an entry here."""

from typing import Any

from movingout.agents.checkpoint.card import Card
from movingout.agents.errors import CheckpointError
from movingout.agents.kinds.bass import BASS
from movingout.agents.kinds.kind import AgentKind
from movingout.agents.kinds.latent import LATENT
from movingout.agents.kinds.mappo import COMEDI, MAPPO
from movingout.agents.kinds.policy import DP, GRU, MLP
from movingout.agents.kinds.response import RESPONSE
from movingout.agents.kinds.self_play import SELF_PLAY

_ALL: tuple[AgentKind[Any], ...] = MLP, GRU, DP, BASS, RESPONSE, MAPPO, COMEDI, SELF_PLAY, LATENT
KINDS = {kind.name: kind for kind in _ALL}


def kind_of(card: Card) -> AgentKind[Any]:
    """The kind of a trained agent. Raises CheckpointError for one that this version does not know."""
    if card.kind not in KINDS:
        raise CheckpointError(f"{card.id} is of the unknown kind {card.kind!r}; known: {', '.join(KINDS)}")
    return KINDS[card.kind]
