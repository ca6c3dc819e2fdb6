"""The schemas: flat enough for strict viewers, and true of what is written."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from movingout.maps import load_map, map_names
from movingout.recordings import AgentDecision, finalise
from movingout.recordings.file_format.payloads import read_agent, write_agent, write_map
from movingout.recordings.file_format.topics import JOURNAL_TOPICS, METRICS_TOPIC, PINGS_TOPIC, TRUTH, Topic
from tests.recordings.support import record

SCALARS = {"boolean", "string", "number", "integer"}
TOPICS = (*JOURNAL_TOPICS, METRICS_TOPIC, PINGS_TOPIC)


def faults(schema: dict[str, Any], where: str = "") -> list[str]:
    """Why a strict viewer would drop a channel with this schema (notes of the Lichtblick parser)."""
    kind = str(schema.get("type"))
    unknown = set(schema) - {"type", "description", "properties", "required", "items"}
    found = [f"{where}: {key}" for key in sorted(unknown)]
    if kind == "object":
        if not schema.get("properties"):
            return [*found, f"{where}: an object without properties"]
        return found + [f for key, value in schema["properties"].items() for f in faults(value, f"{where}/{key}")]
    if kind == "array":
        items = schema.get("items", {})
        if items.get("type") == "array":
            found.append(f"{where}: an array of arrays")
        return found + faults(items, f"{where}[]")
    return found if kind in SCALARS else [*found, f"{where}: type {kind}"]


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_a_schema_is_flat_enough_for_strict_viewers(topic: Topic) -> None:
    assert topic.schema["type"] == "object"
    assert faults(topic.schema) == []


@pytest.mark.parametrize(
    "schema",
    [
        {"type": "object"},
        {"type": ["integer", "null"]},
        {"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
        {"$ref": "#/definitions/x", "type": "number"},
    ],
)
def test_the_check_itself_refuses_what_viewers_refuse(schema: dict[str, Any]) -> None:
    assert faults(schema)


def test_every_message_obeys_its_schema(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, ticks=12)
    seen: set[str] = set()
    with finalise(journal).open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if schema is not None and schema.encoding == "jsonschema":
                Draft202012Validator(orjson.loads(schema.data)).validate(orjson.loads(message.data))
                seen.add(channel.topic)
    assert seen == {*(topic.name for topic in TRUTH), METRICS_TOPIC.name} - {"/agent/blue"}


def test_every_map_obeys_the_map_schema() -> None:
    validator = Draft202012Validator(TRUTH[0].schema)
    for name in map_names():
        validator.validate(orjson.loads(write_map(load_map(name))))


@pytest.mark.parametrize(
    "detail",
    [
        {},
        {"chosen": 2, "candidates": [{"score": 1.5, "terms": [], "x": [0.5], "y": [0.25]}]},
        {"chosen": "left", "candidates": [{"score": 1.5}], "why": {"nested": [1, [2]]}},
        {"error": "boom"},
        {"chosen": 1, "scores": [-0.5, 0.25], "candidates": [[[1.0, 0.0, 1.0]], [[0.5, 1.0, 0.0]]]},
        {"chosen": 0, "scores": "high", "candidates": [{"score": 1, "terms": [], "x": [], "y": []}]},
        {"chosen": True, "scores": [True, [0.5]]},
        {"chosen": 5, "scores": [1, 2.5]},
        {"chosen": -1, "scores": []},
    ],
)
def test_whatever_an_agent_says_comes_back(detail: dict[str, object]) -> None:
    payload = orjson.loads(write_agent(AgentDecision(3, 1, 2.5, True, detail)))
    Draft202012Validator(JOURNAL_TOPICS[5].schema).validate(payload)
    assert read_agent(payload, 1) == AgentDecision(3, 1, 2.5, True, detail)


@pytest.mark.parametrize(
    "detail",
    [
        {"chosen": 1, "scores": [-1.0, 2.0, 0.5], "candidates": [[[1.0, 0.0, 1.0]]] * 3},
        {"chosen": 1, "scores": np.array([-1.0, 2.0, 0.5])},
        {"chosen": 1, "candidates": [{"score": score, "terms": [], "x": [], "y": []} for score in (-1.0, 2.0, 0.5)]},
    ],
)
def test_what_was_scored_can_be_plotted(detail: dict[str, object]) -> None:
    payload = orjson.loads(write_agent(AgentDecision(3, 1, 2.5, False, detail)))
    plotted = {name: payload[name] for name in ("latency_ms", "chosen_score", "best_score", "mean_score", "scores")}
    assert plotted == {
        "latency_ms": 2.5, "chosen_score": 2.0, "best_score": 2.0, "mean_score": 0.5, "scores": [-1.0, 2.0, 0.5],
    }  # fmt: skip


@pytest.mark.parametrize("detail", [{}, {"scores": [0.5, math.nan]}, {"scores": ["high"]}, {"chosen": 0}])
def test_where_nothing_was_scored_nothing_is_plotted(detail: dict[str, object]) -> None:
    payload = orjson.loads(write_agent(AgentDecision(3, 1, 2.5, False, detail)))
    assert not {"chosen_score", "best_score", "mean_score", "scores"} & payload.keys()


def test_a_decision_that_was_recorded_before_scores_had_a_field_still_reads() -> None:
    old = {"tick": 3, "latency_ms": 2.5, "missed": False, "chosen": 1, "candidates": []}
    detail = {"scores": [0.1, 0.2], "candidates": [[[1.0, 0.0, 1.0]]] * 2}
    read = read_agent({**old, "detail": orjson.dumps(detail).decode()}, 0)
    assert read.detail == {**detail, "chosen": 1}
    Draft202012Validator(JOURNAL_TOPICS[5].schema).validate({**old, "detail": ""})
