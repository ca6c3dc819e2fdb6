"""Whether the partner that the lobby proposes plays: found out at the start rather than in somebody's room."""

from pathlib import Path

from movingout.agents.catalogue import agent_card, agent_cards, load_live_agent
from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import LLM
from movingout.agents.trial import NotReadyError, play_a_tick
from movingout.recordings.recorded_seat import GHOST, is_ghost
from movingout.server.own_maps.folder import map_files, read_map_file, shown
from movingout.server.rooms.ghost_partner import ghost_seat

_USUAL = "HandOff"  # the map to try


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


def _play_somewhere(agent_id: str, maps: Path | None) -> str:
    try:
        play_a_tick(agent_id, _USUAL)
    except NotReadyError:
        raise
    except AgentError as error:
        own = _own_map(maps)
        if own is None:
            raise
        try:
            play_a_tick(agent_id, str(own))
        except AgentError:
            raise error from None
        return f"the partner {agent_id} plays on {shown(own.name)}, but not on every map: {error}"
    return ""


def _own_map(folder: Path | None) -> Path | None:
    """The first file of the folder that can be played."""
    names = map_files(folder) if folder else {}
    return next((folder / name for name in names if folder and not isinstance(read_map_file(folder / name), str)), None)
