"""What an agent sees: the vector of one seat, in named layouts that never change once published."""

from movingout.world.observation.aware import AWARE_LAYOUT, ITEM_COLUMNS, AwareEncoder
from movingout.world.observation.egocentric import ITEM_SLOTS, ITEM_WIDTH
from movingout.world.observation.layouts import LAYOUTS, Layout, StateEncoder, encode_state, encoder, layout_named
from movingout.world.observation.pictures import PICTURE_LAYOUT, PICTURE_SHAPE
from movingout.world.observation.relative import RELATIVE_LAYOUT

__all__ = [
    "AWARE_LAYOUT",
    "ITEM_COLUMNS",
    "ITEM_SLOTS",
    "ITEM_WIDTH",
    "LAYOUTS",
    "PICTURE_LAYOUT",
    "PICTURE_SHAPE",
    "RELATIVE_LAYOUT",
    "AwareEncoder",
    "Layout",
    "StateEncoder",
    "encode_state",
    "encoder",
    "layout_named",
]
