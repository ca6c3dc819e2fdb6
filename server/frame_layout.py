"""How the fields of a binary frame lie on the wire, declared once beside the fields themselves.

A `Packed` class annotates each field with a `Wire`; from that follow its struct, `encode` and `decode` here and the
reader and writer in `web/messages.js` (server/messages_js.py). Knows no particular frame.
"""

import struct
from collections.abc import Callable, Iterable
from enum import Enum
from math import floor
from operator import attrgetter, itemgetter
from typing import Any, ClassVar, NamedTuple, Self, get_type_hints

import msgspec

from movingout.maps.errors import MovingOutError
from movingout.maps.spec import SEAT_COLOURS

SIZES = {"B": 1, "b": 1, "H": 2, "h": 2, "I": 4, "d": 8}  # bytes per struct letter


class FrameError(MovingOutError):
    """A binary frame that no client of this protocol sends."""


class Form(Enum):
    """How many numbers a field is."""

    ONE = "one number"
    EACH_SEAT = "a number for blue and one for red"
    FLAGS = "up to 32 booleans as the bits of one number; a count of the frame says how many"


class Wire(NamedTuple):
    """One field on the wire: `round(value * scale)` as a little-endian struct letter, clipped to its range."""

    letter: str  # B b H h I d
    meaning: str
    scale: float = 1.0
    wraps: bool = False  # an angle: modulo the range instead of clipped
    form: Form = Form.ONE

    @property
    def letters(self) -> str:
        return self.letter * (2 if self.form is Form.EACH_SEAT else 1)

    @property
    def limits(self) -> tuple[int, int]:
        """Smallest and largest number sent; signed ranges are symmetric."""
        bits = 8 * SIZES[self.letter]
        return (0, 2**bits - 1) if self.letter.isupper() else (1 - 2 ** (bits - 1), 2 ** (bits - 1) - 1)

    @property
    def is_scaled(self) -> bool:
        return self.scale != 1.0


class FrameLayout:
    """The struct of a class: its type byte if it has one, its fields in order, then counts of what follows."""

    def __init__(self, type_byte: int | None, fields: dict[str, Wire], counts: dict[str, str]) -> None:
        self.type = type_byte
        self.fields = fields
        self.counts = counts  # name to meaning, a byte each
        letters = "".join(wire.letters for wire in fields.values())
        self._struct = struct.Struct(f"<{'' if type_byte is None else 'B'}{letters}{'B' * len(counts)}")
        self._head = () if type_byte is None else (type_byte,)
        self.size = self._struct.size
        # Ten times a second for every room: what can be, is done by functions in C.
        packers = [(index, _packer(wire)) for index, wire in enumerate(fields.values(), len(self._head))]
        self._packers = [(index, put) for index, put in reversed(packers) if put is not None]
        self._values_of = _tuple_of(attrgetter, list(fields))
        unpackers = [(index, _unpacker(wire)) for index, wire in enumerate(fields.values())]
        self._unpackers = [(index, from_numbers) for index, from_numbers in unpackers if from_numbers is not None]
        places = _places(len(self._head), fields, counts)
        self._names = [name for name, _ in places]
        self._numbers_of = _tuple_of(itemgetter, [place for _, place in places])

    @classmethod
    def of(cls, declared: type, type_byte: int | None, counts: dict[str, str]) -> "FrameLayout":
        """From the annotations of a class; fields without a `Wire` are left to the class."""
        hints = get_type_hints(declared, include_extras=True)
        wires = {name: _wire(hint) for name, hint in hints.items()}
        return cls(type_byte, {name: wire for name, wire in wires.items() if wire is not None}, counts)

    @property
    def format(self) -> str:
        return self._struct.format

    def names(self) -> list[str]:
        """What the numbers of the struct are called, in order: a field of both seats is NAME_blue and NAME_red."""
        names = ["type"] * len(self._head)
        for name, wire in self.fields.items():
            names += [f"{name}_{colour}" for colour in SEAT_COLOURS] if wire.form is Form.EACH_SEAT else [name]
        return names + list(self.counts)

    def offsets(self) -> dict[str, int]:
        """Where each field and each count begins, in bytes."""
        offsets, at = {}, len(self._head)
        for name, wire in self.fields.items():
            offsets[name], at = at, at + struct.calcsize("<" + wire.letters)
        for name in self.counts:
            offsets[name], at = at, at + 1
        return offsets

    def pack(self, value: object, *counts: int) -> bytes:
        numbers: list[Any] = [*self._head, *self._values_of(value)]
        for index, put in self._packers:  # from the last, because one value may become two numbers
            numbers[index : index + 1] = put(numbers[index])
        return self._struct.pack(*numbers, *counts)

    def unpack(self, frame: bytes) -> dict[str, Any]:
        """Fields and counts by name, from the beginning of `frame`; flags are still one number. Raises FrameError."""
        return dict(zip(self._names, self.values(frame), strict=True))

    def values(self, frame: bytes) -> list[Any]:
        """The same in the order of declaration. Raises FrameError."""
        if len(frame) < self.size or (self.type is not None and frame[0] != self.type):
            raise FrameError(f"a frame of type {self.type} has at least {self.size} bytes and begins with its type")
        values = list(self._numbers_of(self._struct.unpack_from(frame)))
        for index, from_numbers in self._unpackers:
            values[index] = from_numbers(values[index])
        return values


class Packed(msgspec.Struct, frozen=True):
    """A value with a binary layout. Subclasses annotate fields with a `Wire` and may set `TYPE` and `COUNTS`."""

    TYPE: ClassVar[int | None] = None  # the first byte
    COUNTS: ClassVar[dict[str, str]] = {}  # of the parts that follow the fields: name to meaning
    layout: ClassVar[FrameLayout]

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.layout = FrameLayout.of(cls, cls.TYPE, cls.COUNTS)

    def encode(self) -> bytes:
        return self.layout.pack(self)

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Raises FrameError."""
        if len(frame) != cls.layout.size:
            raise FrameError(f"{cls.__name__} has {cls.layout.size} bytes, not {len(frame)}")
        return cls(*cls.layout.values(frame))


def bits_of(flags: tuple[bool, ...]) -> int:
    """Flag `i` as bit `i`."""
    bits, bit = 0, 1
    for flag in flags:
        if flag:
            bits += bit
        bit += bit
    return bits


def flags_of(bits: int, count: int) -> tuple[bool, ...]:
    return tuple(bool(bits >> index & 1) for index in range(count))


def _wire(hint: Any) -> Wire | None:
    return next((each for each in getattr(hint, "__metadata__", ()) if isinstance(each, Wire)), None)


def _packer(wire: Wire) -> Callable[[Any], Iterable[float]] | None:
    """What turns a field into its numbers; None where it is its own number."""
    to_wire = _to_wire(wire)
    match wire.form:
        case Form.ONE:
            return (lambda value: (to_wire(value),)) if wire.is_scaled else None
        case Form.EACH_SEAT:
            return (lambda values: (to_wire(values[0]), to_wire(values[1]))) if wire.is_scaled else tuple
        case Form.FLAGS:
            return lambda flags: (bits_of(flags),)


def _unpacker(wire: Wire) -> Callable[[Any], Any] | None:
    """What turns the numbers of a field into its value; None where they are its value."""
    from_wire = _from_wire(wire)
    if not wire.is_scaled:
        return None
    return (lambda pair: (from_wire(pair[0]), from_wire(pair[1]))) if wire.form is Form.EACH_SEAT else from_wire


def _tuple_of(getter: Callable[..., Callable[[Any], Any]], wanted: list[Any]) -> Callable[[Any], tuple[Any, ...]]:
    """A getter of the operator module that returns a tuple for one thing too."""
    get = getter(*wanted)
    return get if len(wanted) > 1 else lambda value: (get(value),)


def _places(first: int, fields: dict[str, Wire], counts: Iterable[str]) -> list[tuple[str, int | slice]]:
    """Which of the unpacked numbers belong to a field: one, or a slice of two."""
    places: list[tuple[str, int | slice]] = []
    for name, wire in fields.items():
        places.append((name, slice(first, first + 2) if wire.form is Form.EACH_SEAT else first))
        first += len(wire.letters)
    return places + [(name, first + index) for index, name in enumerate(counts)]


def _to_wire(wire: Wire) -> Callable[[float], int]:
    """Rounds half up, as JavaScript's Math.round."""
    scale, (low, high), span = wire.scale, wire.limits, 256 ** SIZES[wire.letter]
    if wire.wraps:
        return lambda value: (floor(value * scale + 0.5) + span // 2) % span - span // 2

    def clipped(value: float) -> int:
        number = floor(value * scale + 0.5)
        return low if number < low else high if number > high else number

    return clipped


def _from_wire(wire: Wire) -> Callable[[int], float]:
    scale, (low, _) = wire.scale, wire.limits
    return (lambda number: number / scale) if wire.wraps else (lambda number: max(low, number) / scale)
