"""Which parts of the floor hang together, very fast: the floor as one long integer, one bit per grid point."""

import numpy as np
import numpy.typing as npt

from agents.scripted.terrain import CELLS, Terrain

_WIDTH = CELLS + 1  # one empty column keeps the rows apart
Mask = npt.NDArray[np.bool_]


def to_bits(mask: Mask) -> int:
    """A (CELLS, CELLS) mask as an integer."""
    padded = np.zeros((CELLS, _WIDTH), dtype=np.uint8)
    padded[:, :CELLS] = mask
    return int.from_bytes(np.packbits(padded.ravel(), bitorder="little").tobytes(), "little")


def to_mask(bits: int) -> Mask:
    """The (CELLS, CELLS) mask of an integer."""
    size = CELLS * _WIDTH
    raw = np.frombuffer(bits.to_bytes((size + 7) // 8, "little"), dtype=np.uint8)
    flat = np.unpackbits(raw, bitorder="little", count=size)
    return flat.reshape(CELLS, _WIDTH)[:, :CELLS].astype(np.bool_)


def flood(start: int, free: int) -> int:
    """All free points that hang together with the points of `start`."""
    reached = start & free
    while True:
        wider = reached | reached << 1 | reached >> 1
        wider = (wider | wider << _WIDTH | wider >> _WIDTH) & free
        if wider == reached:
            return reached
        reached = wider


def grown(bits: int, cells: int) -> int:
    """The points within so many steps of `bits`."""
    for _ in range(cells):
        bits |= bits << 1 | bits >> 1
        bits = (bits | bits << _WIDTH | bits >> _WIDTH) & _FLOOR
    return bits


_FLOOR = to_bits(np.ones((CELLS, CELLS), dtype=np.bool_))


def standing_room(ground: Terrain, radius: float) -> int:
    """The points at which a disc of this radius fits."""
    return to_bits(ground.clearance >= radius)
