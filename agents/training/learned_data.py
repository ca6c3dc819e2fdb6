"""What the weights of a run learned from, however often it was continued: its maps, and the items on them.

The run folder keeps it in config.json from the moment a training begins, so that one that is interrupted counts, too.
"""

from collections.abc import Collection, Iterable, Mapping
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError

from movingout.agents.checkpoint.card import OTHER_MAPS, Card
from movingout.agents.errors import DataError
from movingout.maps import MapSpec
from movingout.maps.generated.names import PREFIX, is_generated
from movingout.maps.randomize import Pair, pair_text, pairs_on

LEARNED = "learned"  # in config.json
OTHERS_BEFORE = ", and on others before"
"""In the description of an agent that went on with other data or maps than it began with."""
_Names = Annotated[tuple[str, ...], AfterValidator(lambda names: tuple(sorted(set(names))))]


class LearnedData(BaseModel):
    """Names of maps, one word for all generated ones; sizes and shapes of items, or None where that is not known."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    maps: _Names = ()
    items: _Names | None = ()
    others_before: bool = False  # whether there were other data or maps than the last ones

    def plus(self, more: "LearnedData") -> "LearnedData":
        """Both."""
        items = None if self.items is None or more.items is None else (*self.items, *more.items)
        return LearnedData(
            maps=(*self.maps, *more.maps), items=items, others_before=self.others_before or more.others_before
        )


NOTHING = LearnedData()
UNKNOWN = LearnedData(maps=(OTHER_MAPS,), items=None)


def on_maps(specs: Iterable[MapSpec], pairs: Collection[Pair] | None = None) -> LearnedData:
    """Who learns on these maps; from their items as they lie there, or from `pairs`."""
    played = list(specs)
    found = {pair for one in played for pair in pairs_on(one)} if pairs is None else pairs
    names = (PREFIX if is_generated(one.name) else one.name for one in played)
    return LearnedData(maps=tuple(names), items=tuple(map(pair_text, found)))


def said_before(begun: Mapping[str, object]) -> LearnedData:
    """What a configuration says that was written by this version. Raises DataError for a damaged one."""
    try:
        return LearnedData.model_validate(begun[LEARNED])
    except ValidationError as error:
        raise DataError(f"config.json does not say what the run learned from ({error}); choose another --id") from error


def said_by_card(card: Card, begun: Mapping[str, object], data_sha256: str) -> LearnedData:
    """What is known where the configuration is older: the card knows no training that was interrupted after it."""
    bass = (card.dynamics_training, card.value_training, card.progress_training)
    own = [part for part in (bass if card.kind == "bass" else (card.training,)) if part is not None]
    items = [part.items for part in own]
    known = LearnedData(
        maps=card.maps,
        items=None if None in items else tuple(item for some in items for item in some or ()),
        others_before=OTHERS_BEFORE in card.description,
    )
    is_complete = begun.get("data_sha256") in (None, "", data_sha256, *(part.data_sha256 for part in own))
    return known if is_complete else known.plus(UNKNOWN)
