"""Whether the agents of a grid learned from the items that its variants hold out as unseen."""

from collections.abc import Iterator
from contextlib import suppress

from movingout.agents.around_others import acting_id
from movingout.agents.checkpoint.checkpoint import card_of
from movingout.agents.errors import AgentError
from movingout.agents.partners.families import to_try
from movingout.maps import load_map
from movingout.maps.randomize import pair_text, variant_pairs
from movingout.matches.experiment.grid import Grid


def held_out_cautions(grid: Grid) -> Iterator[str]:
    """A sentence for each agent that the grid measures on such items and that learned from some of them.

    Where the grid names its split, also one about those whose cards do not say what they learned from.
    """
    if 2 not in grid.challenges or grid.split != "evaluation":
        return
    played = {pair_text(pair) for name in grid.map_list for pair in variant_pairs(load_map(name), grid.split)}
    silent = []
    for agent in _measured(grid):
        if (card := card_of(agent)) is None:
            continue
        if card.learned_items is None:
            silent.append(agent)
        elif known := sorted(played & card.learned_items):
            yield (
                f"{agent} learned from items that the variants of this grid hold out ({', '.join(known)}): its numbers "
                "are not those of unseen combinations; let it learn from variants of split train"
            )
    if silent and "split" in grid.model_fields_set:
        yield (
            f"the variants of this grid hold items out that {', '.join(silent)} may have learned from: the card does "
            "not say"
        )


def _measured(grid: Grid) -> list[str]:
    """The agents that decide; not those whose id cannot be read, which the plan names."""
    measured: dict[str, None] = {}
    for contestant in (one.agent for condition in grid.all_conditions for one in condition.contestants):
        with suppress(AgentError):
            measured |= dict.fromkeys(acting_id(agent) for agent in to_try(contestant))
    return list(measured)
