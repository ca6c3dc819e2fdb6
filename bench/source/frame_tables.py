"""The tables of binary frames in docs/protocol.md, written from server/frames.py.

python -m bench.source.frame_tables      writes them anew
"""

from bench.source.files import ROOT
from movingout.server import messages as m
from movingout.server.frame_layout import Packed, Wire
from movingout.server.frames import FRAMES

PAGE = ROOT / "docs" / "protocol.md"
START = "<!-- frames: written by python -m bench.source.frame_tables -->"
END = "<!-- end of frames -->"
SCALES = {m.ANGLE_SCALE: "32768/π"}  # the others are whole numbers


def main() -> None:
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


def page(text: str) -> str:
    """The page with its tables made anew."""
    before, _, rest = text.partition(START)
    _, _, after = rest.partition(END)
    return before + "\n\n".join([START, *(_table(name, frame) for name, frame in FRAMES.items()), END]) + after


def _table(name: str, frame: type[Packed]) -> str:
    about = (frame.__doc__ or "").split("\n")[0]
    number = "" if frame.layout.type is None else f", type {frame.layout.type}"
    head = [f"**{name}**{number}, `{frame.layout.format}`: {about}", "", "| field | | |", "|---|---|---|"]
    fields = [f"| {key} | `{' '.join(wire.letters)}` | {_meaning(wire)} |" for key, wire in frame.layout.fields.items()]
    counts = [f"| {key} | `B` | how many follow: {what} |" for key, what in frame.layout.counts.items()]
    return "\n".join([*head, *fields, *counts])


def _meaning(wire: Wire) -> str:
    return wire.meaning + (f"; times {SCALES.get(wire.scale, f'{wire.scale:g}')}" if wire.is_scaled else "")


if __name__ == "__main__":
    main()
