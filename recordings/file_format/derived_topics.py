"""The topics derived from the truth topics when a recording is finished: scene, transforms, log, running metrics."""

from collections.abc import Callable, Iterator

import orjson
from mcap.writer import Writer

from movingout.recordings.episode import Episode, Event
from movingout.recordings.file_format import foxglove
from movingout.recordings.file_format.topics import METRICS_TOPIC, PINGS_TOPIC
from movingout.recordings.pings import ping_of
from movingout.world.metrics import METRICS, EpisodeMetrics, Metrics, to_numbers
from movingout.world.state import WorldState


class DerivedTopics:
    """Follows the truth messages of one episode and writes the derived ones beside them."""

    def __init__(self, writer: Writer, episode: Episode) -> None:
        self._writer = writer
        self._map = episode.header.map
        self._transforms = foxglove.Transforms(self._map)
        self._metrics = EpisodeMetrics(self._map)
        self._episode = episode
        self._next = 0  # index of the state that comes next
        self._events: Iterator[Event] = iter(episode.events)
        self._shown: tuple[bool, ...] | None = None  # what /scene/bodies shows as delivered
        self._channels = _register(writer)
        self._after: dict[str, Callable[[int, int], None]] = {
            "/map": self._static,
            "/state": self._state,
            "/events": self._event,
        }

    def follow(self, topic: str, log_ns: int, publish_ns: int) -> None:
        """Write what follows from the truth message of `topic` that was just written."""
        after = self._after.get(topic)
        if after is not None:
            after(log_ns, publish_ns)

    def _static(self, log_ns: int, publish_ns: int) -> None:
        self._add("/scene/static", log_ns, publish_ns, foxglove.static_scene(self._map, log_ns))

    def _state(self, log_ns: int, publish_ns: int) -> None:
        number, self._next = self._next, self._next + 1
        state, delivered = self._after_tick(number)
        if delivered != self._shown:
            self._add("/scene/bodies", log_ns, publish_ns, foxglove.body_scene(self._map, delivered, log_ns))
            self._shown = delivered
        self._add("/tf", log_ns, publish_ns, self._transforms.of(state, log_ns))
        self._add(METRICS_TOPIC.name, log_ns, publish_ns, _metrics_payload(number, delivered, self._metrics.result()))

    def _after_tick(self, number: int) -> tuple[WorldState, tuple[bool, ...]]:
        if number == 0:
            return self._episode.initial, self._episode.delivered_after(0)
        tick = self._episode.ticks[number - 1]
        before = self._episode.ticks[number - 2].state if number > 1 else self._episode.initial
        self._metrics.update(before, tick.actions, tick.state)
        return tick.state, tick.delivered

    def _event(self, log_ns: int, publish_ns: int) -> None:
        event = next(self._events)
        self._add("/log", log_ns, publish_ns, foxglove.log_line(event, log_ns))
        if event.kind == "ping":
            self._add(PINGS_TOPIC.name, log_ns, publish_ns, orjson.dumps(ping_of(event, self._episode)._asdict()))

    def _add(self, topic: str, log_ns: int, publish_ns: int, payload: bytes) -> None:
        self._writer.add_message(self._channels[topic], log_ns, payload, publish_ns)


def _register(writer: Writer) -> dict[str, int]:
    channels = {}
    for topic in (METRICS_TOPIC, PINGS_TOPIC):
        schema = writer.register_schema(topic.schema_name, "jsonschema", orjson.dumps(topic.schema))
        channels[topic.name] = writer.register_channel(topic.name, "json", schema)
    for name, message in foxglove.TOPICS.items():
        schema = writer.register_schema(message.DESCRIPTOR.full_name, "protobuf", foxglove.descriptor(message))
        channels[name] = writer.register_channel(name, "protobuf", schema)
    return channels


def _metrics_payload(tick: int, delivered: tuple[bool, ...], metrics: Metrics) -> bytes:
    return orjson.dumps({"tick": tick, "delivered": sum(delivered), **to_numbers(metrics.values())})


def curves(episode: Episode) -> dict[str, list[float | None]]:
    """The metrics after each tick, T values each, by key."""
    metrics = EpisodeMetrics(episode.header.map)
    rows = []
    for before, tick in zip(episode.states, episode.ticks, strict=False):
        metrics.update(before, tick.actions, tick.state)
        rows.append(metrics.result().values())
    return {metric.key: [row[metric.key] for row in rows] for metric in METRICS}


def result(episode: Episode) -> dict[str, float | None]:
    """How it ended: `delivered` and `items`, then the metrics by key."""
    metrics = EpisodeMetrics(episode.header.map)
    metrics.update_episode(list(episode.states), episode.actions)
    return {
        "delivered": float(sum(episode.delivered_after(len(episode.ticks)))),
        "items": float(len(episode.header.map.items)),
        **metrics.result().values(),
    }
