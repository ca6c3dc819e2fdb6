"""Whether a trained agent sees all of a map: the layout of what it sees has room for so many walls and goals."""

from movingout.agents.catalogue import trained_cards
from movingout.agents.errors import AgentError
from movingout.agents.partners.identity import acting_id
from movingout.maps import MapSpec
from movingout.world import WorldError
from movingout.world.observation import LAYOUTS


def check_map_seen(agent_id: str, map_spec: MapSpec, name: str = "") -> None:
    """Raises AgentError for a map that has more of something than the agent sees.

    Of `late` and `clone`, the agent inside is looked at. Nothing is known of agents of one's own.
    `name` is what the map is called where it was chosen, as the path of its file.
    """
    layouts = {card.id: card.layout for card in trained_cards()}
    if layout := layouts.get(acting_id(agent_id).strip().partition(":")[0]):
        try:
            LAYOUTS[layout].check(map_spec)
        except WorldError as error:
            raise AgentError(f"{agent_id} cannot play {name or map_spec.name}: {error}") from None
