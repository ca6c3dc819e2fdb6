"""Whether the partner that the lobby proposes can be made: found out at the start rather than in somebody's room."""

import subprocess
import sys

from movingout.agents.catalogue import agent_card, agent_cards, load_live_agent
from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import LLM
from movingout.recordings.recorded_seat import GHOST, is_ghost
from movingout.server.agent_workers.process import HANG_S
from movingout.server.rooms.ghost_partner import ghost_seat

_OURS = "movingout: "  # begins the sentence of a command


def check_partner(agent_id: str) -> None:
    """Raises AgentError, or what a recording that cannot be read raises, for an agent that cannot be made.

    An agent of one's own, or with options, is made once in another process: this one imports nobody's code.
    """
    kind = agent_card(agent_id).kind
    if kind == LLM:
        load_live_agent(agent_id)
    elif is_ghost(agent_id):
        ghost_seat(agent_id.removeprefix(f"{GHOST}:"))
    elif agent_id not in {card.id for card in agent_cards()}:
        _make_elsewhere(agent_id)


def _make_elsewhere(agent_id: str) -> None:
    command = [sys.executable, "-P", "-m", "movingout.server.cli", "agents", "show", agent_id]
    limit_s = HANG_S["loading"]
    try:
        made = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", timeout=limit_s)
    except subprocess.TimeoutExpired:
        raise AgentError(f"the partner {agent_id} was not ready within {limit_s:.0f} s") from None
    if made.returncode != 0:
        said = [line.removeprefix(_OURS) for line in made.stderr.splitlines() if line.startswith(_OURS)]
        raise AgentError(said[-1] if said else f"making the partner {agent_id} ended its process ({made.returncode})")
