"""docs/foxglove-layout.json names panels, topics and fields that a recording really has."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from movingout.recordings import finalise
from movingout.recordings.file_format import foxglove
from movingout.recordings.file_format.topics import METRICS_TOPIC, TRUTH, Schema
from tests.recordings.support import record

LAYOUT: dict[str, Any] = json.loads(
    (Path(__file__).parents[2] / "docs" / "foxglove-layout.json").read_text(encoding="utf-8")
)
PANELS: dict[str, Any] = LAYOUT["configById"]
DRAWN = ("boolean", "integer", "number")
SCHEMAS: dict[str, Schema] = {topic.name: topic.schema for topic in (*TRUTH, METRICS_TOPIC)}


def leaves(tree: Any) -> Iterator[str]:
    """The panels of a layout tree: a panel, or two trees beside each other."""
    if isinstance(tree, str):
        yield tree
        return
    assert tree["direction"] in ("row", "column") and 0 < tree["splitPercentage"] < 100
    yield from leaves(tree["first"])
    yield from leaves(tree["second"])


def field(path: str) -> str:
    """The type of what a message path leads to: the topic, a dot, and names of properties."""
    topic, *names = path.split(".")
    schema = SCHEMAS[topic]
    for name in names:
        schema = schema["properties"][name]
    return str(schema["type"])


def paths(kind: str) -> list[str]:
    return [path["value"] for name, panel in PANELS.items() if name.startswith(kind) for path in panel["paths"]]


def test_every_panel_has_its_place_and_its_settings() -> None:
    placed = list(leaves(LAYOUT["layout"]))
    assert sorted(placed) == sorted(PANELS)
    assert {"3D", "Plot", "StateTransitions", "Log"} <= {name.partition("!")[0] for name in placed}


@pytest.mark.parametrize("path", paths("Plot!"))
def test_a_plot_leads_to_a_number(path: str) -> None:
    assert field(path) in DRAWN


@pytest.mark.parametrize("path", paths("StateTransitions!"))
def test_a_state_leads_to_a_value(path: str) -> None:
    assert field(path) in (*DRAWN, "string")


def test_the_other_panels_show_topics_of_a_recording(tmp_path: Path) -> None:
    named = {*PANELS["3D!arena"]["topics"], PANELS["Log!events"]["topicToRender"]}
    named |= {panel["topicPath"] for name, panel in PANELS.items() if name.startswith("RawMessages!")}
    with finalise(record(tmp_path, ticks=3)[0]).open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert named <= {channel.topic for channel in summary.channels.values()}
    assert PANELS["3D!arena"]["followTf"] == foxglove.WORLD_FRAME
