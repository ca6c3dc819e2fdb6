"""The golden frames: values written by hand, and their bytes, shared by the tests of the server and of the pages.

python -m tests.server.golden_frames     gives fields declared since then to the values, as zero, and writes the bytes
"""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from movingout.server.frame_layout import Packed
from movingout.server.frames import FRAMES, BundleEvent
from tests.server.support import zeros

FILE = Path(__file__).parent / "golden_frames.json"
TYPES: dict[str, type[Packed]] = {frame.__name__: frame for frame in FRAMES.values()}


def from_javascript_names(kind: str, value: dict[str, Any]) -> Packed:
    """The frame with the given values; a field that is not among them is zero."""
    fields = {re.sub(r"([A-Z])", lambda hit: "_" + hit[1].lower(), name): part for name, part in value.items()}
    if kind == "Bundle":
        poses = np.array(fields.pop("poses")).reshape(fields.pop("pose_count"), fields.pop("bodies"), 3)
        fields = {name: tuple(part) if isinstance(part, list) else part for name, part in fields.items()}
        fields["events"] = tuple(BundleEvent(**event) for event in fields["events"])
        fields["poses"] = poses
    return TYPES[kind](**(zeros(TYPES[kind]) | fields))


def written(text: str) -> str:
    """The file with a value for every declared field, and its bytes made anew."""
    return "[\n" + ",\n".join(json.dumps(_completed(golden)) for golden in json.loads(text)) + "\n]\n"


def _completed(golden: dict[str, Any]) -> dict[str, Any]:
    kind, value = golden["frame"], golden["value"]
    declared = {re.sub(r"_(\w)", lambda hit: hit[1].upper(), name): zero for name, zero in zeros(TYPES[kind]).items()}
    # Declared fields in their order, then what follows them: counts, poses, events.
    full = {name: value.get(name, zero) for name, zero in declared.items()} | value
    return golden | {"hex": from_javascript_names(kind, full).encode().hex(), "value": full}


if __name__ == "__main__":
    FILE.write_text(written(FILE.read_text(encoding="utf-8")), encoding="utf-8")
