"""Which given episodes on varied maps agents may learn from, so that they are evaluated on what they have not seen."""

import sys
from collections.abc import Sequence
from pathlib import Path

from movingout.maps import MapSpec, load_map, map_names
from movingout.maps.randomize import EVALUATION_PAIRS
from movingout.maps.suggestion import counted
from movingout.matches.errors import MatchError
from movingout.matches.paper.workspace import Evaluation
from movingout.recordings.file_format.reader import read_episode


def fair_variants(paths: Sequence[Path], evaluation: Evaluation) -> list[Path]:
    """The episodes without an item that agents meet again when they are evaluated; how many are left out is printed.

    Official evaluation is on the maps as designed: there no item may have a size and shape that one has on its map as
    designed. The other evaluation is on combinations that are held out everywhere. Raises MatchError if none is left.
    """
    fair = [path for path in paths if not _seen_again(read_episode(path).header.map, evaluation)]
    if len(fair) == len(paths):
        return fair
    other = "--evaluation held-out, or variants of `split: official`"
    remedy = other if evaluation == "official" else "--evaluation official, or variants of `split: train`"
    sentence = (
        f"{counted(len(paths) - len(fair), 'episode')} of {len(paths)} on varied maps cannot be learned from: items in "
        f"them are as in the evaluation ({evaluation}); what works is {remedy}"
    )
    if not fair:
        raise MatchError(sentence)
    sys.stderr.write(f"movingout: {sentence}\n")
    return fair


def _seen_again(variant: MapSpec, evaluation: Evaluation) -> bool:
    pairs = {(item.size, item.shape) for item in variant.items}
    if evaluation == "held-out":
        return not pairs.isdisjoint(EVALUATION_PAIRS)
    if variant.name not in map_names():
        return False
    return not pairs.isdisjoint((item.size, item.shape) for item in load_map(variant.name).items)
