"""What an agent sees: the vector of one seat, in named layouts that never change once published."""

from movingout.world.observation.aware import AWARE_LAYOUT, ITEM_COLUMNS, AwareEncoder
from movingout.world.observation.egocentric import ITEM_SLOTS, ITEM_WIDTH, ROBOT_WIDTH
from movingout.world.observation.layouts import LAYOUTS, StateEncoder, encode_state, encoder, layout_named

__all__ = [
    "AWARE_LAYOUT",
    "ITEM_COLUMNS",
    "ITEM_SLOTS",
    "ITEM_WIDTH",
    "LAYOUTS",
    "ROBOT_WIDTH",
    "AwareEncoder",
    "StateEncoder",
    "encode_state",
    "encoder",
    "layout_named",
]
