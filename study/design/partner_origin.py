"""Whether the agents of a study learned from what it presents as new to them, or never saw what it plays."""

from collections.abc import Iterator

from movingout.agents.catalogue import unseen_maps
from movingout.agents.checkpoint.checkpoint import card_of
from movingout.maps.randomize import pair_text, variant_pairs
from movingout.study.design.definition import Study
from movingout.study.design.sections.rounds import Block


def origin_warnings(study: Study) -> Iterator[str]:
    """Sentences for the experimenter. Agents that cannot be loaded are left out."""
    for block in study.blocks:
        for agent in _trained(study, block):
            if sentence := unseen_maps(agent, [study.load_map(name).name for name in block.maps]):
                yield f"block {block.id}: {sentence.removesuffix('.')}"
        if block.challenge == 2 and block.split == "evaluation":
            yield from _held_out(study, block)


def _held_out(study: Study, block: Block) -> Iterator[str]:
    """Variants of this split have only combinations of size and shape that are held out from those learned from."""
    played = {pair_text(pair) for name in block.maps for pair in variant_pairs(study.load_map(name), block.split)}
    silent = []
    for agent in _trained(study, block):
        card = card_of(agent)
        if card is None or card.learned_items is None:
            silent.append(agent)
        elif known := sorted(played & card.learned_items):
            yield (
                f"block {block.id}: {agent} learned from items that its variants hold out: {', '.join(known)}; "
                "let it learn from variants of split train"
            )
    if silent:
        yield (
            f"block {block.id}: its variants hold items out that {', '.join(silent)} may have learned from: the card "
            "does not say; agents that come with the game learned from maps as designed, which have such items"
        )


def _trained(study: Study, block: Block) -> list[str]:
    """The trained agents that participants meet in a block."""
    agents = [study.partner(name).agent for name in block.partners]
    if study.group == 2 and study.pairing.otherwise == "agent":
        agents.append(study.pairing.agent)
    return [agent for agent in dict.fromkeys(agents) if card_of(agent) is not None]
