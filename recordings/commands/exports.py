"""`movingout recordings export`."""

import argparse

from movingout.maps.commands.parser import add_out
from movingout.recordings.commands.arguments import add_paths, expanded
from movingout.recordings.exports import FORMATS, export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import SPLIT_BY, obtained
from movingout.recordings.exports.trajectories import VIEWS
from movingout.recordings.storage.listing import is_tutorial
from movingout.world.observation import LAYOUTS


def configure(parser: argparse.ArgumentParser) -> None:
    add_paths(parser)
    formats = "; ".join(f"{name}: {chosen.help}" for name, chosen in FORMATS.items())
    parser.add_argument("--to", required=True, choices=FORMATS, metavar="FORMAT", help=formats)
    add_out(parser, "TARGET", "a new file or folder", required=True)
    parser.add_argument(
        "--test-share",
        type=_share,
        metavar="SHARE",
        default=0.0,
        help="of episodes for testing",
    )
    parser.add_argument("--split-by", choices=SPLIT_BY, default="participant", help="what is on one side as a whole")
    parser.add_argument("--seed", type=int, default=0, help="of the split")
    parser.add_argument("--layout", choices=LAYOUTS, default="official-v1", help="of observations")
    parser.add_argument("--view", choices=VIEWS, default="ego", help="an episode per seat, or both seats in one")
    parser.add_argument("--side", type=int, default=512, help="pixels of a picture")
    parser.add_argument("--speed", type=float, default=1.0, help="of a video, times real time")
    parser.add_argument("--every", type=float, default=5.0, metavar="S", help="seconds between pictures of a strip")
    parser.add_argument("--no-overlay", action="store_true", help="pictures without names and time")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    found = expanded(args.paths)
    recordings = [path for path in found if path in args.paths or not is_tutorial(path)]
    if len(recordings) < len(found):
        print(f"{len(found) - len(recordings)} of tutorials left out; name a file to export it all the same")
    plan = ExportPlan(
        recordings=recordings,
        target=args.out,
        test_share=args.test_share,
        seed=args.seed,
        split_by=args.split_by,
        layout=args.layout,
        view=args.view,
        side=args.side,
        speed=args.speed,
        every_s=args.every,
        overlay=not args.no_overlay,
    )
    export(args.to, plan)
    count = len(plan.recordings)
    print(f"{count} recording{'s' * (count != 1)} written to {args.out}")
    if args.test_share:
        print(obtained(plan.splits, args.test_share, args.split_by))
    return 0


def _share(text: str) -> float:
    try:
        share = float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no share; write 0.2 for a fifth") from error
    if not 0 <= share < 1:
        raise argparse.ArgumentTypeError("a share is from 0 up to, but not including, 1")
    return share
