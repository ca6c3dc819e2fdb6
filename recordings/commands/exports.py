"""`movingout recordings export`."""

import argparse
from collections.abc import Collection, Sequence
from pathlib import Path

from movingout.maps.commands.parser import add_out
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import add_paths, expanded, share
from movingout.recordings.commands.selection import left_out_words
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports import FORMATS, export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import SPLIT_BY, obtained
from movingout.recordings.exports.trajectories import VIEWS
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.listing import is_tutorial, read_summary
from movingout.recordings.storage.study_rounds import counted_recordings
from movingout.world.observation import LAYOUTS

LEARNED = ("lerobot", "robomimic", "official")  # formats of which an episode without a tick is no part


def configure(parser: argparse.ArgumentParser) -> None:
    add_paths(parser)
    formats = "; ".join(f"{name}: {chosen.help}" for name, chosen in FORMATS.items())
    parser.add_argument("--to", required=True, choices=FORMATS, metavar="FORMAT", help=formats)
    add_out(parser, "TARGET", "a new file or folder", required=True)
    parser.add_argument(
        "--test-share",
        type=share,
        metavar="SHARE",
        default=0.0,
        help="share of episodes for testing",
    )
    parser.add_argument(
        "--split-by", choices=SPLIT_BY, default="participant", help="what is on one side as a whole (%(default)s)"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the split")
    parser.add_argument("--layout", choices=LAYOUTS, default="official-v1", help="layout of observations (%(default)s)")
    parser.add_argument(
        "--view", choices=VIEWS, default="ego", help="an episode per seat, or both seats in one (%(default)s)"
    )
    parser.add_argument(
        "--images", type=int, default=0, metavar="PIXELS", help="lerobot: also what each seat sees, as video"
    )
    parser.add_argument("--side", type=int, default=512, help="pixels of a picture (%(default)s)")
    parser.add_argument("--speed", type=float, default=1.0, help="speed of a video, times real time (%(default)s)")
    parser.add_argument(
        "--every", type=float, default=5.0, metavar="S", help="seconds between pictures of a strip (%(default)s)"
    )
    parser.add_argument("--no-overlay", action="store_true", help="pictures without names and time")
    parser.add_argument(
        "--ray", default="", metavar="auto|ADDRESS", help="tables, training data: convert on a Ray cluster"
    )
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    if args.images and args.to != "lerobot":
        raise RecordingError(f"--images is for --to lerobot; {args.to} has no images")
    shown, left_out = _chosen(expanded(args.paths), args.paths)
    if left_out:
        print(f"left out {', '.join(left_out)}; name a file to export it all the same")
    recordings = [path for path in shown if args.to not in LEARNED or _has_tick(path)]
    if empty := len(shown) - len(recordings):
        print(f"left out {counted(empty, 'empty recording')}, in which nothing was played")
        if not recordings:
            raise RecordingError(f"--to {args.to} is of what was played; name recordings that have a tick")
    plan = ExportPlan(
        recordings=recordings,
        target=args.out,
        test_share=args.test_share,
        seed=args.seed,
        split_by=args.split_by,
        layout=args.layout,
        view=args.view,
        images=args.images,
        side=args.side,
        speed=args.speed,
        every_s=args.every,
        overlay=not args.no_overlay,
        ray=args.ray,
    )
    export(args.to, plan)
    print(f"wrote {counted(len(plan.recordings), 'recording')} to {args.out}")
    if args.test_share:
        print(obtained(plan.splits, args.test_share, args.split_by))
    return 0


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
