"""Whether a trained agent sees all of a map: the layout of what it sees has room for so many walls and goals."""

from collections.abc import Iterable, Mapping

from movingout.agents.around_others import acting_id
from movingout.agents.catalogue import trained_cards
from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
from movingout.world import WorldError
from movingout.world.observation import LAYOUTS


def check_map_seen(agent_id: str, map_spec: MapSpec, name: str = "") -> None:
    """Raises AgentError for a map that has more of something than the agent sees.

    Of `late` and `clone`, the agent inside is looked at. Nothing is known of agents of one's own.
    `name` is what the map is called where it was chosen, as the path of its file.
    """
    _check(agent_id, map_spec, name or map_spec.name, _layouts())


def check_own_maps_seen(seated: Iterable[tuple[str, MapSpec]]) -> None:
    """The same for agents and the maps that they are to play on, whatever these are called. Raises AgentError."""
    layouts = _layouts()
    for agent_id, spec in dict.fromkeys(seated):
        _check(agent_id, spec, spec.name, layouts)


def _layouts() -> dict[str, str]:
    """By the ids of trained agents."""
    return {card.id: card.layout for card in trained_cards()}


def _check(agent_id: str, map_spec: MapSpec, name: str, layouts: Mapping[str, str]) -> None:
    if layout := layouts.get(acting_id(agent_id).strip().partition(":")[0]):
        try:
            LAYOUTS[layout].check(map_spec)
        except WorldError as error:
            raise AgentError(f"{agent_id} cannot play {name}: {error}") from None
