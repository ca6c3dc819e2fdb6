"""Whether the partner that the lobby proposes plays: found out at the start rather than in somebody's room."""

import subprocess
import sys
from pathlib import Path

from movingout.agents.catalogue import agent_card, agent_cards, load_live_agent
from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import LLM
from movingout.recordings.recorded_seat import GHOST, is_ghost
from movingout.server.agent_workers.process import HANG_S
from movingout.server.own_maps.folder import map_files, read_map_file, shown
from movingout.server.rooms.ghost_partner import ghost_seat

_USUAL = "HandOff"  # the map to try
_OURS = "movingout: "  # begins the sentence of a command


def check_partner(agent_id: str, maps: Path | None = None) -> str:
    """A caution, or nothing. Raises AgentError, or what a recording that cannot be read raises, for an agent that
    cannot be made or played.

    An agent of one's own, or with options, plays a tick in another process: this one imports nobody's code. It may be
    one for the operator's own maps, those of the folder `maps`, so one of these is enough.
    """
    kind = agent_card(agent_id).kind
    if kind == LLM:
        load_live_agent(agent_id)
    elif is_ghost(agent_id):
        ghost_seat(agent_id.removeprefix(f"{GHOST}:"))
    elif agent_id not in {card.id for card in agent_cards()}:
        return _play_somewhere(agent_id, maps)
    return ""


class _NotReadyError(AgentError):
    """It took too long, which another map would not change."""


def _play_somewhere(agent_id: str, maps: Path | None) -> str:
    try:
        _play_elsewhere(agent_id, _USUAL)
    except _NotReadyError:
        raise
    except AgentError as error:
        own = _own_map(maps)
        if own is None:
            raise
        try:
            _play_elsewhere(agent_id, str(own))
        except AgentError:
            raise error from None
        return f"the partner {agent_id} plays on {shown(own.name)}, but not on every map: {error}"
    return ""


def _own_map(folder: Path | None) -> Path | None:
    """The first file of the folder that can be played."""
    names = map_files(folder) if folder else {}
    return next((folder / name for name in names if folder and not isinstance(read_map_file(folder / name), str)), None)


def _play_elsewhere(agent_id: str, the_map: str) -> None:
    words = "agents", "probe", agent_id, "--map", the_map, "--ticks", "1", "--json"
    command = [sys.executable, "-P", "-m", "movingout.server.cli", *words]
    limit_s = HANG_S["loading"]
    try:
        played = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", timeout=limit_s)
    except subprocess.TimeoutExpired as late:
        if late.stdout:  # it has played, but a thread that the agent started keeps its process alive
            return
        raise _NotReadyError(f"the partner {agent_id} was not ready within {limit_s:.0f} s") from None
    if played.stdout:  # its times, also where the first decision takes longer than a tick
        return
    said = [line.removeprefix(_OURS) for line in played.stderr.splitlines() if line.startswith(_OURS)]
    if not said:
        raise AgentError(f"making the partner {agent_id} ended its process ({played.returncode})")
    raise AgentError(said[-1] if agent_id in said[-1] else f"the partner {agent_id} cannot play: {said[-1]}")
