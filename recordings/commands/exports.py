"""`movingout recordings export`."""

import argparse
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import add_paths, expanded, share
from movingout.recordings.commands.selection import left_out_words
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports import FORMATS, export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import SPLIT_BY, caution, obtained
from movingout.recordings.exports.trajectories import VIEWS
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.listing import is_tutorial, read_summary
from movingout.recordings.storage.study_rounds import counted_recordings
from movingout.world.observation import LAYOUTS

LEARNED = ("lerobot", "robomimic", "official")  # formats of which an episode without a tick is no part
DRAWN = ("mp4", "gif", "png", "rrd")
DIVIDED = tuple(name for name in FORMATS if name not in DRAWN)
USED_BY: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("test_share", "split_by", "seed"), DIVIDED),
    "layout": ("parquet", "lerobot", "robomimic"),
    "view": ("lerobot", "robomimic"),
    "images": ("lerobot",),
    **dict.fromkeys(("side", "overlay"), ("mp4", "gif", "png")),
    "speed": ("mp4", "gif"),
    "every_s": ("png",),
}
"""The formats in which an option of the plan does something."""
_OPTIONS = {name: f"--{name.replace('_', '-')}" for name in USED_BY} | {"every_s": "--every", "overlay": "--no-overlay"}


def configure(parser: argparse.ArgumentParser) -> None:
    add_paths(parser)
    formats = "; ".join(f"{name}: {chosen.help}" for name, chosen in FORMATS.items())
    parser.add_argument("--to", required=True, choices=FORMATS, metavar="FORMAT", help=formats)
    add_out(parser, "TARGET", "a new file or folder", required=True)
    add = parser.add_argument
    add("--test-share", type=share, metavar="SHARE", help="share of episodes for testing")
    add("--split-by", choices=SPLIT_BY, help="what is on one side as a whole (participant)")
    add("--seed", type=int, help="seed of the split")
    add("--layout", choices=LAYOUTS, help="layout of observations (official-v1)")
    add("--view", choices=VIEWS, help="an episode per seat, or both seats in one (ego)")
    add("--images", type=int, metavar="PIXELS", help="lerobot: also what each seat sees, as video")
    add("--side", type=int, help="pixels of a picture (512)")
    add("--speed", type=float, help="speed of a video, times real time (1.0)")
    add("--every", dest="every_s", type=float, metavar="S", help="seconds between pictures of a strip (5.0)")
    add("--no-overlay", dest="overlay", action="store_false", default=None, help="pictures without names and time")
    parser.add_argument(
        "--ray", default="", metavar="auto|ADDRESS", help="tables, training data: convert on a Ray cluster"
    )
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Raises RecordingError."""
    given = _given(args)
    shown, left_out = _chosen(expanded(args.paths), args.paths)
    if left_out:
        print(f"left out {printable(', '.join(left_out))}; name a file to export it all the same")
    recordings = [path for path in shown if args.to not in LEARNED or _has_tick(path)]
    if empty := len(shown) - len(recordings):
        print(f"left out {counted(empty, 'empty recording')}, in which nothing was played")
        if not recordings:
            raise RecordingError(f"--to {args.to} is of what was played; name recordings that have a tick")
    plan = ExportPlan(
        recordings=recordings,
        target=args.out,
        **given,
        tell=_tell,
        ray=args.ray,
    )
    export(args.to, plan)
    print(f"wrote {counted(len(plan.recordings), 'recording')} to {args.out}")
    if args.test_share:
        print(obtained(plan.splits, plan.test_share, plan.split_by))
        if sentence := caution(plan.players, plan.split_by):
            print(printable(sentence))
    return 0


def _given(args: argparse.Namespace) -> dict[str, Any]:
    """What is not as usual. Raises RecordingError for an option that does nothing with this format."""
    given = {name: getattr(args, name) for name in USED_BY if getattr(args, name) is not None}
    for name in given:
        if args.to not in USED_BY[name]:
            able = ", ".join(USED_BY[name])
            raise RecordingError(f"{_OPTIONS[name]} is for --to {able}; with --to {args.to} it does nothing")
        if name in ("split_by", "seed") and not args.test_share:
            raise RecordingError(f"{_OPTIONS[name]} does nothing without --test-share")
    return given


def _tell(sentence: str) -> None:
    tell(printable(sentence))


def _chosen(found: Sequence[Path], named: Collection[Path]) -> tuple[list[Path], list[str]]:
    """What is exported of the files found, and words for the rest: only of folders, never a file that is named."""
    counting = set(counted_recordings([path for path in found if path not in named])).union(named)
    valid = [path for path in found if path in counting]
    finished = [path for path in valid if path in named or not path.name.endswith(JOURNAL_SUFFIX)]
    shown = [path for path in finished if path in named or not is_tutorial(path)]
    numbers = {
        "unfinished recording": len(valid) - len(finished),
        "tutorial recording": len(finished) - len(shown),
    }
    words = [counted(number, what) for what, number in numbers.items() if number]
    return shown, words + left_out_words(len(found) - len(valid), 0)


def _has_tick(path: Path) -> bool:
    """False where an agent failed at once; True for what cannot be read, which the export names."""
    try:
        return read_summary(path).ticks > 0
    except RecordingError:
        return True
