"""Whether the partner that the lobby proposes plays: found out at the start rather than in somebody's room."""

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
    """Raises AgentError, or what a recording that cannot be read raises, for an agent that cannot be made or played.

    An agent of one's own, or with options, plays a tick in another process: this one imports nobody's code.
    """
    kind = agent_card(agent_id).kind
    if kind == LLM:
        load_live_agent(agent_id)
    elif is_ghost(agent_id):
        ghost_seat(agent_id.removeprefix(f"{GHOST}:"))
    elif agent_id not in {card.id for card in agent_cards()}:
        _play_elsewhere(agent_id)


def _play_elsewhere(agent_id: str) -> None:
    words = "agents", "probe", agent_id, "--ticks", "1", "--json"
    command = [sys.executable, "-P", "-m", "movingout.server.cli", *words]
    limit_s = HANG_S["loading"]
    try:
        played = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", timeout=limit_s)
    except subprocess.TimeoutExpired:
        raise AgentError(f"the partner {agent_id} was not ready within {limit_s:.0f} s") from None
    if played.stdout:  # its times, also where the first decision takes longer than a tick
        return
    said = [line.removeprefix(_OURS) for line in played.stderr.splitlines() if line.startswith(_OURS)]
    if not said:
        raise AgentError(f"making the partner {agent_id} ended its process ({played.returncode})")
    raise AgentError(said[-1] if agent_id in said[-1] else f"the partner {agent_id} cannot play: {said[-1]}")
