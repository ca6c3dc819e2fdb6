"""The one registry of observation layouts: a name that never changes its meaning once published, and its encoder."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Protocol

from movingout.maps import MapSpec
from movingout.maps.suggestion import counted
from movingout.world.errors import WorldError
from movingout.world.observation.aware import (
    AWARE_LAYOUT,
    AWARE_SIZE,
    ITEM_COLUMNS,
    PARTNER_OFFSET,
    AwareEncoder,
    aware_bounds,
)
from movingout.world.observation.egocentric import OFFICIAL, ROBOT_WIDTH, WITH_MAP, Encoder, ObservationLayout
from movingout.world.observation.pictures import (
    PICTURE_LAYOUT,
    PICTURE_SHAPE,
    PICTURE_SIZE,
    PictureEncoder,
    picture_bounds,
)
from movingout.world.observation.relative import (
    OWN_NUMBERS,
    RELATIVE_ITEMS,
    RELATIVE_LAYOUT,
    RELATIVE_SIZE,
    RELATIVE_SLOTS,
    RelativeEncoder,
    relative_bounds,
    relative_mirror,
)
from movingout.world.observation.slots import Slots
from movingout.world.state import Floats, Ints, WorldState


class StateEncoder(Protocol):
    """Encodes the states of one map in one layout of D numbers."""

    def encode(self, state: WorldState, seat: int) -> Floats:
        """The vector (D,) that `seat` sees, as a new array."""

    def encode_both(self, state: WorldState) -> tuple[Floats, Floats]:
        """What blue and red see, (D,) each."""

    def encode_arrays(
        self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> Floats:
        """The vectors (T, D) of states given as arrays: (T, 2, 3), (T, 2, 3), (T, 2) and (T, N, 3)."""


@dataclass(frozen=True, slots=True)
class Layout:
    """A named layout of observations."""

    name: str
    size: int  # D
    bounds: Floats = field(compare=False)  # (D,) how large each number can be, up or down
    make: Callable[[MapSpec], StateEncoder]  # WorldError for a map that does not fit
    slots: Slots
    own_numbers: int = 0  # the first so many are of the own robot, as many after them of the partner; 0: not known
    partner_pose: int | None = None  # where the partner's x, y, cos and sin in the arena begin
    partner_offset: int | None = None  # where partner minus own position begins, along the axes of the arena
    items: tuple[tuple[int, ...], ...] = ()  # indices of each item's numbers, alike for all; empty: not known
    mirror: tuple[Ints, Floats] | None = field(default=None, compare=False)
    """Of a layout in the own frame: where each number of a mirrored observation comes from (D,), and its sign (D,)."""
    picture: tuple[int, int, int] | None = None  # height, width and colours of a layout that is a picture of bytes

    @property
    def own_frame(self) -> bool:
        """Whether directions are relative to the own heading, and headings of actions are to be as well."""
        return self.mirror is not None

    @property
    def headings(self) -> str:
        """What headings of actions are relative to in environments, exports and files of policies: own, or arena."""
        return "own" if self.own_frame else "arena"

    def check(self, map_spec: MapSpec) -> None:
        """Raises WorldError for a map that has more of something than the layout has slots."""
        self.slots.check(map_spec, self.name)

    def refusal(self, maps: Iterable[tuple[Path, MapSpec]]) -> str:
        """A sentence that names the files with maps that `check` refuses, given as (file, map); empty for none."""
        refused: dict[Path, str] = {}
        for file, map_spec in maps:
            try:
                self.check(map_spec)
            except WorldError as error:
                refused[file] = str(error)
        if not refused:
            return ""
        (first, why), *others = refused.items()
        more = f", and {counted(len(others), 'other')} with such maps" if others else ""
        return f"{first}: {why}; leave it out{more}"


def _egocentric(layout: ObservationLayout) -> Layout:
    return Layout(
        layout.name,
        layout.size,
        layout.bounds,
        partial(Encoder, layout=layout),
        layout.slots,
        own_numbers=ROBOT_WIDTH,
        partner_pose=ROBOT_WIDTH,
    )


LAYOUTS: Mapping[str, Layout] = {
    layout.name: layout
    for layout in (
        _egocentric(OFFICIAL),
        _egocentric(WITH_MAP),
        Layout(
            AWARE_LAYOUT,
            AWARE_SIZE,
            aware_bounds(),
            AwareEncoder,
            WITH_MAP.slots,
            own_numbers=ROBOT_WIDTH,
            partner_pose=ROBOT_WIDTH,
            partner_offset=PARTNER_OFFSET,
            items=ITEM_COLUMNS,
        ),
        Layout(PICTURE_LAYOUT, PICTURE_SIZE, picture_bounds(), PictureEncoder, Slots(), picture=PICTURE_SHAPE),
        Layout(
            RELATIVE_LAYOUT,
            RELATIVE_SIZE,
            relative_bounds(),
            RelativeEncoder,
            RELATIVE_SLOTS,
            own_numbers=OWN_NUMBERS,
            items=RELATIVE_ITEMS,
            mirror=relative_mirror(),
        ),
    )
}


def layout_named(name: str) -> Layout:
    """Raises WorldError for a name that is not registered."""
    if name not in LAYOUTS:
        raise WorldError(f"unknown layout {name!r}; known: {', '.join(LAYOUTS)}")
    return LAYOUTS[name]


@lru_cache(maxsize=256)
def encoder(map_spec: MapSpec, layout: str = OFFICIAL.name) -> StateEncoder:
    """The one encoder of a map and layout in this process.

    Raises WorldError for an unknown layout, or for a map that has more of something than the layout has slots.
    """
    return layout_named(layout).make(map_spec)


def encode_state(map_spec: MapSpec, state: WorldState, seat: int, layout: str = OFFICIAL.name) -> Floats:
    """The vector (D,) of one state; the encoder of a map is made once."""
    return encoder(map_spec, layout).encode(state, seat)
