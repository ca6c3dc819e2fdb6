"""Which parts of the floor hang together and how far it is over it, very fast: the floor as one long integer.

One bit per grid point. A few operations on integers move a whole front of points, where arrays take many.
"""

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.lattice import UNREACHED, Cost
from movingout.agents.scripted.navigation.terrain import CELLS, Terrain

STRAIGHT, DIAGONAL = 2, 3  # quarter ticks that a step to a neighbouring grid point takes
_SURCHARGE = 3  # quarter ticks besides from a point that is shunned
_WIDTH = CELLS + 1  # one empty column keeps the rows apart
_BYTES = (CELLS * _WIDTH + 7) // 8
_DEAREST = DIAGONAL + _SURCHARGE
Mask = npt.NDArray[np.bool_]


def to_bits(mask: Mask) -> int:
    """A (CELLS, CELLS) mask as an integer."""
    padded = np.zeros((CELLS, _WIDTH), dtype=np.uint8)
    padded[:, :CELLS] = mask
    return int.from_bytes(np.packbits(padded.ravel(), bitorder="little").tobytes(), "little")


def to_mask(bits: int) -> Mask:
    """The (CELLS, CELLS) mask of an integer."""
    mask: Mask = _unpacked([bits])[0].view(np.bool_)
    return mask


def _unpacked(planes: list[int]) -> npt.NDArray[np.uint8]:
    """(planes, CELLS, CELLS) of zeros and ones."""
    raw = np.frombuffer(b"".join(bits.to_bytes(_BYTES, "little") for bits in planes), dtype=np.uint8)
    flat = np.unpackbits(raw.reshape(len(planes), _BYTES), axis=1, bitorder="little", count=CELLS * _WIDTH)
    return np.ascontiguousarray(flat.reshape(len(planes), CELLS, _WIDTH)[..., :CELLS])


def flood(start: int, free: int) -> int:
    """All free points that hang together with the points of `start`."""
    reached = start & free
    while True:
        wider = reached | reached << 1 | reached >> 1
        wider = (wider | wider << _WIDTH | wider >> _WIDTH) & free
        if wider == reached:
            return reached
        reached = wider


def pieces(start: int, free: int) -> list[int]:
    """All free points that hang together with points of `start`, by what hangs together."""
    found: list[int] = []
    start &= free
    while start:
        found.append(flood(start & -start, free))
        start &= ~found[-1]
    return found


def flood_around(hole: int, start: int, whole: int) -> int:
    """`flood(start, whole & ~hole)`, sooner, for a `whole` that hangs together.

    Where what is left hangs together all around the hole, every way through it can be replaced by one around it.
    """
    left = whole & ~hole
    start &= left
    cut = whole & hole
    if not cut or not start:
        return left if start else 0
    rim = grown(cut, 1) & left
    ring = grown(rim, 2) & left
    lowest = max((ring & -ring).bit_length() - 1, 0)  # short numbers are quick
    return left if _hangs_together(rim >> lowest, ring >> lowest) else flood(start, left)


def _hangs_together(points: int, free: int) -> bool:
    """Whether ways over free points lead from each of these, which are free, to every other."""
    reached = points & -points
    while points & ~reached:
        wider = reached | reached << 1 | reached >> 1
        wider = (wider | wider << _WIDTH | wider >> _WIDTH) & free
        if wider == reached:
            return False
        reached = wider
    return True


def lengths(starts: int, free: int, shunned: int = 0) -> Cost:
    """(CELLS, CELLS) quarter ticks over free points to the nearest of `starts`, those from `shunned` points dearer."""
    left, open_floor = free, free & ~shunned
    pending = [0] * (_DEAREST + 1)  # a ring: the points that may be so and so far
    pending[0] = starts
    planes: list[int] = []  # of the lengths, written as binary numbers
    length = last = 0
    while length <= last:
        front = pending[length % len(pending)] & left
        pending[length % len(pending)] = 0
        if front:
            left ^= front
            last = length + _DEAREST
            _note(planes, length, front)
            beside = front << 1 | front >> 1
            straight, diagonal = beside | front << _WIDTH | front >> _WIDTH, beside << _WIDTH | beside >> _WIDTH
            if shunned:
                pending[(length + STRAIGHT + _SURCHARGE) % len(pending)] |= straight & shunned
                pending[(length + DIAGONAL + _SURCHARGE) % len(pending)] |= diagonal & shunned
                straight, diagonal = straight & open_floor, diagonal & open_floor
            pending[(length + STRAIGHT) % len(pending)] |= straight
            pending[(length + DIAGONAL) % len(pending)] |= diagonal
        length += 1
    found = np.zeros((CELLS, CELLS), dtype=np.int16)
    for place, digits in enumerate(_unpacked(planes) if planes else ()):
        found += digits.astype(np.int16) << place
    return np.where(to_mask(free ^ left), found, np.int16(UNREACHED))


def _note(planes: list[int], length: int, front: int) -> None:
    """Write a length at the points of a front."""
    place = 0
    while length:
        if place == len(planes):
            planes.append(0)
        if length & 1:
            planes[place] |= front
        length >>= 1
        place += 1


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
