"""`recordings info`: one recording as a page for a person, or as JSON with fixed fields."""

import argparse
from collections import Counter
from pathlib import Path
from typing import Any

from movingout.maps.commands.parser import add_json
from movingout.maps.files.terminal import printable
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.commands.arguments import add_data, print_json
from movingout.recordings.episode import Episode, SeatInfo
from movingout.recordings.file_format.derived_topics import result
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.file_format.metadata import utc
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.storage.index import path_of
from movingout.recordings.storage.listing import seat_title
from movingout.recordings.versions import why_not_exact
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.metrics import METRICS, Metric, Values, to_numbers

_OUTCOMES = {
    "delivered": "everything delivered",
    "time": "time was up",
    "left": "somebody left",
    "stopped": "stopped by the experimenter",
    "error": "ended by an error",
    "interrupted": "interrupted, never ended",
}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", help="a file, or an episode id in DATA/recordings")
    add_data(parser)
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Print the page, or the JSON. Raises RecordingError."""
    path = Path(args.recording)
    if not path.exists():
        path = path_of(args.data / "recordings", args.recording)
    episode = read_episode(path)
    if args.json:
        print_json(info_json(path, episode))
    else:
        print("\n".join(map(printable, info_page(path, episode).splitlines())))
    return 0


def info_json(path: Path, episode: Episode) -> dict[str, Any]:
    """The fields scripts rely on, and more."""
    header = episode.header
    return {
        "path": str(path),
        "id": header.episode_id,
        "map": header.map.name,
        "variant": header.map.variant,
        "ticks": len(episode.ticks),
        "limit_ticks": header.limit_ticks,
        **{colour: _seat_json(seat) for colour, seat in zip(SEAT_COLOURS, header.seats, strict=True)},
        "seed": header.seed,
        "started": utc(header.started_ns),
        "source": header.source,
        "study": dict(header.study),
        "outcome": episode.outcome,
        "complete": episode.complete,
        "damage": episode.damage,
        "metrics": to_numbers(result(episode)),
        "events": dict(Counter(event.kind for event in episode.events)),
        "versions": dict(episode.versions),
        "finalised": not path.name.endswith(JOURNAL_SUFFIX),
    }


def _seat_json(seat: SeatInfo) -> dict[str, str]:
    return {
        "kind": seat.kind,
        "name": seat.name,
        "device": seat.device,
        "checkpoint_sha256": seat.checkpoint_sha256,
    }


def info_page(path: Path, episode: Episode) -> str:
    """The page for a person."""
    header = episode.header
    variant = f", {header.map.variant}" if header.map.variant else ""
    sections = [
        f"{header.map.title}{variant}  ·  {utc(header.started_ns)[:19].replace('T', ' ')} UTC  ·  {header.source}",
        _rows(
            ("file", f"{path} ({path.stat().st_size / 1024:.0f} KiB)"),
            *(
                (colour, _seat_words(seat, episode, index))
                for index, (colour, seat) in enumerate(zip(SEAT_COLOURS, header.seats, strict=True))
            ),
            ("played", _played(episode)),
        ),
        _rows(*_metric_rows(result(episode))),
        _rows(
            ("events", _counted([event.kind for event in episode.events]) or "none"),
            ("timing", _timing(episode)),
            ("study", ", ".join(f"{key} {value}" for key, value in header.study.items()) or "none"),
            ("made by", ", ".join(f"{key} {value}" for key, value in episode.versions.items())),
            ("replay", _promise(episode)),
        ),
        *([f"! {episode.damage}"] if episode.damage else []),
    ]
    return "\n\n".join(sections)


def _rows(*rows: tuple[str, str]) -> str:
    return "\n".join(f"  {name:<9} {text}" for name, text in rows)


def _played(episode: Episode) -> str:
    ticks, limit = len(episode.ticks), episode.header.limit_ticks
    of = f" of {limit / TICKS_PER_SECOND:.1f} s" if limit else ""
    return f"{ticks / TICKS_PER_SECOND:.1f} s{of} ({ticks} ticks), {_OUTCOMES[episode.outcome]}"


def _seat_words(seat: SeatInfo, episode: Episode, index: int) -> str:
    silent = sum(tick.sources[index] == "neutral" for tick in episode.ticks)
    weights = [f"(weights {seat.checkpoint_sha256[:12]})"] if seat.checkpoint_sha256 else []
    words = [seat_title(seat.kind, seat.name), *weights, *([f"on {seat.device}"] if seat.device else [])]
    return " ".join(words) + (f", {silent} ticks without an answer" if silent else "")


def _promise(episode: Episode) -> str:
    caveat = why_not_exact(episode.versions)
    return caveat or "same engine as here, so it must re-simulate to the same bits; `recordings verify` checks it"


def _metric_rows(values: Values) -> list[tuple[str, str]]:
    delivered = ("delivered", f"{values['delivered']:.0f} of {values['items']:.0f} items")
    return [delivered, *((metric.symbol, _metric_words(metric, values[metric.key])) for metric in METRICS)]


def _metric_words(metric: Metric, value: float | None) -> str:
    return metric.none_when if value is None else f"{metric.text(value):<7} {metric.title.lower()}: {metric.meaning}"


def _counted(words: list[str]) -> str:
    return ", ".join(f"{count} {word.replace('_', ' ')}" for word, count in Counter(words).most_common())


def _timing(episode: Episode) -> str:
    if not episode.ticks:
        return "no ticks"
    late = sorted(tick.late_ms for tick in episode.ticks)
    missed = sum(decision.missed for decision in episode.decisions)
    return f"late {late[len(late) // 2]:.1f} ms median, {late[-1]:.1f} ms at worst; {missed} agent deadlines missed"
